//! Joints between two nodes, or between a node and a point, and tethers.
//!
//! Sources: a joint of stiffness k is taken implicitly, as XPBD does (Macklin, Müller, Chentanez, "XPBD: Position-Based
//! Simulation of Compliant Constrained Dynamics", MIG 2016, eq. 18) with one iteration a sub-step (Macklin et al., "Small
//! Steps in Physics Simulation", SCA 2019): p = (l − L)/(w₁ + w₂ + 1/(k h²)). Joints that share
//! nodes are found together: joints.rs. A tether: Kim, Chentanez, Müller-Fischer, "Long Range Attachments – A Method
//! to Simulate Inextensible Clothing in Computer Games", SCA 2012.

use crate::real::{Real, add, dot, scale, sub};

/// The correction of a joint at its first node; the second node gets the opposite.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointCorrection<T> {
    /// Change of position times mass [kg·m]. Divided by the sub-step, it is the impulse.
    pub shift: [T; 3],
    /// Its length [kg·m]. Divided by the square of the sub-step, it is the force.
    pub size: T,
}

/// Solves a joint whose ends are `d` [m] apart, first less second, and should be `length` [m]. `give` [1/kg] is the
/// sum of their inverse masses, and `softness` [1/kg] the joint's own compliance 1/(k h²). Ends at one position are
/// not corrected.
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

/// The softness of a joint with compliance 1/k [m/N] in a sub-step of `h` [s], 1/(k h²) [1/kg].
#[inline(always)]
pub fn softness<T: Real>(compliance: T, h: T) -> T {
    compliance / (h * h)
}

/// Whether a joint with this correction in a sub-step of `h` [s] breaks: its force exceeds `break_force` [N].
#[inline(always)]
pub fn breaks<T: Real>(correction: &JointCorrection<T>, h: T, break_force: T) -> bool {
    correction.size / (h * h) > break_force
}

/// Length [m] of a joint at a `fraction` of its closing: it changes from `start` [m] to `end` [m].
#[inline(always)]
pub fn length<T: Real>(start: T, end: T, fraction: T) -> T {
    start * (T::ONE - fraction) + end * fraction
}

/// Position [m] and velocity [m/s].
pub type PointState<T> = ([T; 3], [T; 3]);

/// Whether a node at `x` [m] is inside the sphere of radius `length` [m] around its anchor at `at` [m].
#[inline(always)]
pub fn is_within<T: Real>(x: [T; 3], at: [T; 3], length: T) -> bool {
    let d = sub(x, at);
    dot(d, d) <= length * length
}

/// Projects a node at `x` [m] onto the sphere of radius `length` [m] around its anchor at `at` [m]. Returns the new
/// position and the translation. `None` if it is inside.
#[inline(always)]
pub fn project_to_sphere<T: Real>(x: [T; 3], at: [T; 3], length: T) -> Option<PointState<T>> {
    let d = sub(x, at);
    let squared = dot(d, d);
    if squared > length * length {
        let distance = squared.sqrt();
        let outward = [d[0] / distance, d[1] / distance, d[2] / distance];
        // This sum keeps the digits that a difference of positions would lose.
        Some((add(at, scale(outward, length)), scale(outward, length - distance)))
    } else {
        None
    }
}

/// The velocity [m/s] of a node that tethers have moved by `shift` [m] in a sub-step of `h` [s]. It loses the part
/// that the tethers have undone: at most its component against `shift`, relative to the anchors' velocity `with`
/// [m/s].
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

/// The velocity [m/s] of a node on a taut tether, `d` [m] from its anchor, which has the velocity `with` [m/s]. The
/// node loses its speed away from the anchor.
#[inline(always)]
pub fn without_stretching<T: Real>(v: [T; 3], d: [T; 3], with: [T; 3]) -> [T; 3] {
    let (speed, squared) = (dot(sub(v, with), d), dot(d, d));
    if speed > T::ZERO && squared > T::ZERO { sub(v, scale(d, speed / squared)) } else { v }
}

/// Most rounds over the tethers of a node in a sub-step: one tether may move it out of the reach of another.
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
