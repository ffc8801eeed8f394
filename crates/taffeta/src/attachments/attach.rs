//! What holds two nodes together, a node to a point, and a node near another one.
//!
//! Sources: a joint of stiffness k is taken implicitly, as XPBD does (Macklin, Müller, Chentanez, "XPBD: Position-Based
//! Simulation of Compliant Constrained Dynamics", MIG 2016, eq. 18) with one iteration a sub-step (Macklin et al., "Small
//! Steps in Physics Simulation", SCA 2019): p = (l − L)/(w₁ + w₂ + 1/(k h²)). Joints that share
//! nodes are found together: joints.rs. A tether: Kim, Chentanez, Müller-Fischer, "Long Range Attachments – A Method
//! to Simulate Inextensible Clothing in Computer Games", SCA 2012.

use crate::real::{Real, add, dot, scale, sub};

/// What a joint does to its first node; to its second the opposite.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointCorrection<T> {
    /// Change of place times mass [kg·m]; by the sub-step, change of momentum.
    pub shift: [T; 3],
    /// Its length [kg·m]; by the square of the sub-step, the force.
    pub size: T,
}

/// A joint of two ends that are `d` [m] apart, first less second, and should be `length` [m]. `give` [1/kg] is the sum of
/// their inverse masses, and `softness` [1/kg] how easily it gives way itself, 1/(k h²). Where its ends are at one place
/// nothing happens.
#[inline(always)]
pub fn solve_joint<T: Real>(d: [T; 3], length: T, give: T, softness: T) -> JointCorrection<T> {
    let distance = dot(d, d).sqrt();
    if distance > T::ZERO && give > T::ZERO {
        let size = (distance - length) / (give + softness);
        let by = -size / distance;
        JointCorrection { shift: scale(d, by), size: if size > T::ZERO { size } else { -size } }
    } else {
        JointCorrection { shift: [T::ZERO; 3], size: T::ZERO }
    }
}

/// How easily a joint of compliance 1/k [m/N] gives way in a sub-step of `h` [s], 1/(k h²) [1/kg].
#[inline(always)]
pub fn softness<T: Real>(compliance: T, h: T) -> T {
    compliance / (h * h)
}

/// Whether a joint that did so much in a sub-step of `h` [s] breaks: its force is beyond `break_force` [N].
#[inline(always)]
pub fn breaks<T: Real>(correction: &JointCorrection<T>, h: T, break_force: T) -> bool {
    correction.size / (h * h) > break_force
}

/// Distance [m] of a joint's ends when a `share` of its closing has gone by: it goes from `start` [m] to `end` [m].
#[inline(always)]
pub fn length<T: Real>(start: T, end: T, fraction: T) -> T {
    start * (T::ONE - fraction) + end * fraction
}

/// Place [m] and velocity [m/s].
pub type PointState<T> = ([T; 3], [T; 3]);

/// Where a node at `x` [m] comes that may not be farther than `length` [m] from an anchor at `at` [m], on the sphere, and the
/// way there. `None` where it is inside.
#[inline(always)]
pub fn project_to_sphere<T: Real>(x: [T; 3], at: [T; 3], length: T) -> Option<PointState<T>> {
    let d = sub(x, at);
    let squared = dot(d, d);
    if squared > length * length {
        let distance = squared.sqrt();
        let outward = [d[0] / distance, d[1] / distance, d[2] / distance];
        // As a sum of these it has the digits that a difference of places has lost.
        Some((add(at, scale(outward, length)), scale(outward, length - distance)))
    } else {
        None
    }
}

/// The velocity [m/s] of a node that tethers have moved by `shift` [m] in a sub-step of `h` [s]: it loses that with which it
/// did not get anywhere, as far as it leads away from where the tethers pull, seen from their anchors, which go `with` [m/s].
#[inline(always)]
pub fn without_lost_motion<T: Real>(v: [T; 3], shift: [T; 3], with: [T; 3], h: T) -> [T; 3] {
    let (against, squared) = (dot(shift, sub(with, v)), dot(shift, shift));
    if against > T::ZERO && squared > T::ZERO {
        let (whole, all) = (against / squared, T::ONE / h);
        add(v, scale(shift, if whole < all { whole } else { all }))
    } else {
        v
    }
}

/// The velocity [m/s] of a node whose tether is taut, `d` [m] from its anchor, which goes `with` [m/s]: it loses the speed at
/// which it leaves it.
#[inline(always)]
pub fn without_stretching<T: Real>(v: [T; 3], d: [T; 3], with: [T; 3]) -> [T; 3] {
    let (speed, squared) = (dot(sub(v, with), d), dot(d, d));
    if speed > T::ZERO && squared > T::ZERO { sub(v, scale(d, speed / squared)) } else { v }
}

/// Times that the tethers of a node are looked at in a sub-step, at most: one may lead out of reach of another.
pub const ROUNDS: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::real::norm;

    #[test]
    fn a_stiff_joint_closes_its_gap_and_shares_it_by_mass() {
        // 0.3 m too long; 1 kg and 2 kg.
        let done = solve_joint([0.5, 0.0, 0.0], 0.2, 1.5, 0.0);
        assert!((done.size - 0.2).abs() < 1e-15 && (done.shift[0] + 0.2).abs() < 1e-15, "{done:?}");
        assert_eq!(&done.shift[1..], [0.0; 2]);
        // Too short: it pushes.
        let done = solve_joint([0.1, 0.0, 0.0], 0.2, 1.0, 0.0);
        assert!((done.size - 0.1).abs() < 1e-15 && (done.shift[0] - 0.1).abs() < 1e-15, "{done:?}");
    }

    #[test]
    fn a_soft_joint_at_rest_pulls_by_its_stiffness() {
        // At rest gravity adds g h² to the gap and the joint takes it off: what is left is m g/k.
        let (mass, k, h, g) = (0.3_f64, 50.0, 0.01, 9.81);
        let gap = mass * g / k;
        let done = solve_joint([0.0, gap + g * h * h, 0.0], 0.0, 1.0 / mass, 1.0 / (k * h * h));
        assert!((done.size / (h * h) - mass * g).abs() < 1e-12, "{}", done.size / (h * h));
    }

    #[test]
    fn what_is_done_to_one_is_done_to_the_other_the_opposite_way() {
        for n in 0..1000 {
            let some =
                |k: u32| f64::from((7 * n + k).wrapping_mul(2_654_435_761)) / f64::from(1_u32 << 31) - 1.0;
            let d = [some(0), some(1), some(2)];
            let (there, back) = (solve_joint(d, 0.4, 1.7, 0.3), solve_joint(scale(d, -1.0), 0.4, 1.7, 0.3));
            assert_eq!((there.shift, there.size), (scale(back.shift, -1.0), back.size));
        }
    }

    #[test]
    fn ends_at_one_place_and_held_ends_stay() {
        assert_eq!(solve_joint([0.0; 3], 0.5, 1.0, 0.0), JointCorrection::default());
        assert_eq!(solve_joint([1.0; 3], 0.5, 0.0, 0.0), JointCorrection::default());
    }

    #[test]
    fn a_length_begins_and_ends_exactly_where_it_should() {
        assert_eq!([0.0, 1.0, 0.5].map(|fraction| length(0.7_f32, 0.1, fraction)), [0.7, 0.1, 0.4]);
    }

    #[test]
    fn a_node_is_put_back_on_its_sphere() {
        let at = [1.0, 0.0, 0.0];
        assert_eq!(project_to_sphere([1.0, 3.0, 0.0], at, 2.0), Some(([1.0, 2.0, 0.0], [0.0, -1.0, 0.0])));
        assert_eq!(project_to_sphere([1.0, 2.0, 0.0], at, 2.0), None);
        let (far, shift) = project_to_sphere([3.0, 4.0, -7.0], at, 0.5).unwrap();
        assert!((norm(sub(far, at)) - 0.5_f64).abs() < 1e-15);
        assert!(norm(sub(add([3.0, 4.0, -7.0], shift), far)) < 1e-14);
    }

    #[test]
    fn a_taut_tether_takes_the_speed_away_from_its_anchor_alone() {
        let (d, with) = ([0.0, 2.0, 0.0], [0.0, 5.0, 0.0]);
        assert_eq!(without_stretching([2.0, 6.0, -1.0], d, with), [2.0, 5.0, -1.0]);
        // Coming back already: the velocity stays.
        assert_eq!(without_stretching([2.0, 4.0, -1.0], d, with), [2.0, 4.0, -1.0]);
        assert_eq!(without_stretching([1.0; 3], [0.0; 3], with), [1.0; 3]);
    }

    #[test]
    fn what_tethers_undo_is_no_speed() {
        let shift = [0.0, 0.02, 0.0];
        // All of it, a part of it, and no more than it has, seen from anchors at rest and from moving ones.
        assert_eq!(without_lost_motion([3.0, -2.0, 0.0], shift, [0.0; 3], 0.01), [3.0, 0.0, 0.0]);
        assert_eq!(without_lost_motion([3.0, -5.0, 0.0], shift, [0.0; 3], 0.01), [3.0, -3.0, 0.0]);
        assert_eq!(without_lost_motion([3.0, -1.0, 0.0], shift, [0.0; 3], 0.01), [3.0, 0.0, 0.0]);
        assert_eq!(without_lost_motion([3.0, -1.0, 0.0], shift, [7.0, -1.5, 0.0], 0.01), [3.0, -1.0, 0.0]);
        assert_eq!(without_lost_motion([3.0, 1.0, 0.0], shift, [0.0; 3], 0.01), [3.0, 1.0, 0.0]);
        assert_eq!(without_lost_motion([1.0; 3], [0.0; 3], [2.0; 3], 0.01), [1.0; 3]);
    }
}
