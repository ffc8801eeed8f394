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

/// The ball around an anchor that a tether keeps its node in: center and radius [m]. An infinite one holds nothing.
pub type Ball<T> = ([T; 3], T);

/// The radius of a tether's ball in numbers of this precision. Between two pins as far apart as the cloth is wide both balls just touch, and
/// rounding would decide where a node is; a hundred times that much room is as little as is smooth.
pub fn radius<T: Real>(length: f64) -> T {
    T::from_f64(length * (1.0 + 100.0 * T::EPSILON.to_f64()))
}

/// By how much the squared distance of a node at `x` [m] is beyond a ball [m²]. At most 0: it is inside.
#[inline(always)]
pub fn excess<T: Real>(x: [T; 3], (center, radius): Ball<T>) -> T {
    let d = sub(x, center);
    dot(d, d) - radius * radius
}

/// The same beyond what rounding may have done.
#[inline(always)]
pub fn sure_excess<T: Real>(x: [T; 3], (center, radius): Ball<T>) -> T {
    let (d, room) = (sub(x, center), T::from_f64(8.0) * T::EPSILON * (radius + size(x)));
    dot(d, d) - radius * (radius + room)
}

/// Sum of the absolute coordinates, by which rounding grows.
#[inline(always)]
fn size<T: Real>(x: [T; 3]) -> T {
    x[0].abs() + x[1].abs() + x[2].abs()
}

/// Projects a node at `x` [m] onto the surface of a ball, whose center it is not at. Returns the new position and the translation.
#[inline(always)]
pub fn project_to_sphere<T: Real>(x: [T; 3], (center, radius): Ball<T>) -> ([T; 3], [T; 3]) {
    let d = sub(x, center);
    let ratio = radius / dot(d, d).sqrt();
    // This sum keeps the digits that a difference of positions would lose.
    (add(center, scale(d, ratio)), scale(d, ratio - T::ONE))
}

/// Projects a node at `x` [m] onto the circle in which the surfaces of two balls meet, which it is farther out than. Returns the new position
/// and the translation. Balls that do not meet have a point between them in place of the circle.
#[inline(always)]
pub fn project_to_circle<T: Real>(x: [T; 3], (a, r): Ball<T>, (b, s): Ball<T>) -> ([T; 3], [T; 3]) {
    let (d, axis) = (sub(x, a), sub(b, a));
    let squared = dot(axis, axis);
    // Where on the axis the circle's plane and the node are: 0 is a, 1 is b.
    let plane = ((r - s) * (r + s) / squared + T::ONE) * T::from_f64(0.5);
    let along = dot(d, axis) / squared;
    let across = sub(d, scale(axis, along));
    let distance = dot(across, across).sqrt();
    let radius = r * r - plane * plane * squared;
    let radius = (if radius > T::ZERO { radius } else { T::ZERO }).sqrt();
    // Only rounding would lead away from the axis.
    let ratio = if distance > radius { radius / distance } else { T::ONE };
    let position = add(add(a, scale(axis, plane)), scale(across, ratio));
    (position, add(scale(axis, plane - along), scale(across, ratio - T::ONE)))
}

/// A node that its tethers have moved: its position, the translation [m], and 1 for each tether that is taut, else 0.
pub type HeldBack<T, const N: usize> = ([T; 3], [T; 3], [T; N]);

/// Two balls, first the one that a node at `x` [m] exceeds most.
#[derive(Clone, Copy)]
pub struct ByExcess<T> {
    /// Whether that is the second of them.
    pub is_second: bool,
    pub first: Ball<T>,
    pub second: Ball<T>,
    /// By how much the node exceeds each [m²].
    pub excess: [T; 2],
}

/// The ball that a node at `x` [m] exceeds most, and the other.
#[inline(always)]
pub fn by_excess<T: Real>(x: [T; 3], (p, p_radius): Ball<T>, (q, q_radius): Ball<T>) -> ByExcess<T> {
    let (of_p, of_q) = (excess(x, (p, p_radius)), excess(x, (q, q_radius)));
    let is_second = of_q > of_p;
    let pick = |p: T, q: T| if is_second { q } else { p };
    ByExcess {
        is_second,
        first: ([0, 1, 2].map(|axis| pick(p[axis], q[axis])), pick(p_radius, q_radius)),
        second: ([0, 1, 2].map(|axis| pick(q[axis], p[axis])), pick(q_radius, p_radius)),
        excess: [pick(of_p, of_q), pick(of_q, of_p)],
    }
}

/// Moves a node at `x` [m] to the nearest point of two balls: of the one that it exceeds most, or of the other, or where both surfaces meet.
/// It has no branches, so that a loop over nodes becomes vector instructions.
#[inline(always)]
pub fn project_to_two<T: Real>(x: [T; 3], p: Ball<T>, q: Ball<T>) -> HeldBack<T, 2> {
    let ByExcess { is_second, first, second, excess } = by_excess(x, p, q);
    let (at_first, by_first) = project_to_sphere(x, first);
    let (at_second, by_second) = project_to_sphere(x, second);
    let (on_circle, by_both) = project_to_circle(x, first, second);
    let acts = excess[0] > T::ZERO;
    // Of balls around nearly the same point, one is as good as both, and the circle is anywhere.
    let ((a, r), (b, _)) = (first, second);
    let (apart, blur) = (sub(b, a), T::from_f64(1000.0) * T::EPSILON * (r + size(x)));
    let alone = (sure_excess(at_first, second) <= T::ZERO) | (dot(apart, apart) <= blur * blur);
    // A node within the second needs both.
    let needs_both = (sure_excess(at_second, first) > T::ZERO) | (excess[1] <= T::ZERO);
    let choose = |none: T, first: T, second: T, both: T| {
        let of_two = if needs_both { both } else { second };
        let of_all = if alone { first } else { of_two };
        if acts { of_all } else { none }
    };
    let (mut position, mut shift) = (x, x);
    for axis in 0..3 {
        position[axis] = choose(x[axis], at_first[axis], at_second[axis], on_circle[axis]);
        shift[axis] = choose(T::ZERO, by_first[axis], by_second[axis], by_both[axis]);
    }
    let of_first = choose(T::ZERO, T::ONE, T::ZERO, T::ONE);
    let of_second = choose(T::ZERO, T::ZERO, T::ONE, T::ONE);
    let pick = |p: T, q: T| if is_second { q } else { p };
    (position, shift, [pick(of_first, of_second), pick(of_second, of_first)])
}

/// Moves a node into one ball after the other, each once. Returns 1 if it was outside any, else 0.
#[inline(always)]
pub fn project_in_turn<T: Real, const N: usize>(node: &mut HeldBack<T, N>, balls: &[Ball<T>; N]) -> T {
    let (x, shift, taut) = node;
    let mut moved = T::ZERO;
    for tether in 0..N {
        let (position, by) = project_to_sphere(*x, balls[tether]);
        let is_out = excess(*x, balls[tether]) > T::ZERO;
        for axis in 0..3 {
            x[axis] = if is_out { position[axis] } else { x[axis] };
            shift[axis] = if is_out { shift[axis] + by[axis] } else { shift[axis] };
        }
        taut[tether] = if is_out { T::ONE } else { taut[tether] };
        moved = if is_out { T::ONE } else { moved };
    }
    moved
}

/// The velocity [m/s] of a node that tethers have moved in a sub-step of `h` [s]. Before, it had the velocity `v`; `balls` have the velocities
/// `with` [m/s].
#[inline(always)]
pub fn held_velocity<T: Real, const N: usize>(
    v: [T; 3],
    (x, shift, taut): &HeldBack<T, N>,
    balls: &[Ball<T>; N],
    with: &[[T; 3]; N],
    h: T,
) -> [T; 3] {
    let (mut sum, mut count) = ([T::ZERO; 3], T::ZERO);
    for tether in 0..N {
        for axis in 0..3 {
            sum[axis] = if taut[tether] > T::ZERO { sum[axis] + with[tether][axis] } else { sum[axis] };
        }
        count += taut[tether];
    }
    let along = [sum[0] / count, sum[1] / count, sum[2] / count];
    let mut after = without_lost_motion(v, *shift, along, h);
    for tether in 0..N {
        let kept = without_stretching(after, sub(*x, balls[tether].0), with[tether]);
        for axis in 0..3 {
            after[axis] = if taut[tether] > T::ZERO { kept[axis] } else { after[axis] };
        }
    }
    for axis in 0..3 {
        after[axis] = if count > T::ZERO { after[axis] } else { v[axis] };
    }
    after
}

/// The velocity [m/s] of a node that tethers have moved by `shift` [m] in a sub-step of `h` [s]. It loses the part
/// that the tethers have undone: at most its component against `shift`, relative to the anchors' velocity `with`
/// [m/s].
#[inline(always)]
pub fn without_lost_motion<T: Real>(v: [T; 3], shift: [T; 3], with: [T; 3], h: T) -> [T; 3] {
    let (against, squared) = (dot(shift, sub(with, v)), dot(shift, shift));
    let (whole, all) = (against / squared, T::ONE / h);
    let part = if whole < all { whole } else { all };
    add(v, scale(shift, if (against > T::ZERO) & (squared > T::ZERO) { part } else { T::ZERO }))
}

/// The velocity [m/s] of a node on a taut tether, `d` [m] from its anchor, which has the velocity `with` [m/s]. The
/// node loses its speed away from the anchor.
#[inline(always)]
pub fn without_stretching<T: Real>(v: [T; 3], d: [T; 3], with: [T; 3]) -> [T; 3] {
    let (speed, squared) = (dot(sub(v, with), d), dot(d, d));
    let part = speed / squared;
    sub(v, scale(d, if (speed > T::ZERO) & (squared > T::ZERO) { part } else { T::ZERO }))
}

/// Most rounds over the tethers of a node with more than two: one may move it out of the reach of another.
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
        assert_eq!(project_to_sphere([1.0, 4.0, 0.0], (at, 2.0)), ([1.0, 2.0, 0.0], [0.0, -2.0, 0.0]));
        let (far, shift) = project_to_sphere([3.0, 4.0, -7.0], (at, 0.5));
        assert!((norm(sub(far, at)) - 0.5_f64).abs() < 1e-15);
        assert!(norm(sub(add([3.0, 4.0, -7.0], shift), far)) < 1e-14);
    }

    #[test]
    fn a_node_is_put_on_the_circle_where_two_spheres_meet() {
        let (a, b) = ([0.2, -0.1, 0.3], [1.1, 0.4, -0.2]);
        for (n, [r, s]) in (0..).zip([[1.0, 0.7], [0.4, 1.1], [0.9, 0.9]]) {
            let x = [2.0 - f64::from(n), 1.5, 1.0 + f64::from(n)];
            let (at, shift) = project_to_circle(x, (a, r), (b, s));
            assert!((norm(sub(at, a)) - r).abs() < 1e-14 && (norm(sub(at, b)) - s).abs() < 1e-14, "{at:?}");
            assert!(norm(sub(add(x, shift), at)) < 1e-14);
            // Nearest: what is left lies in the plane of both normals.
            let normal = crate::real::cross(sub(at, a), sub(at, b));
            assert!(dot(shift, normal).abs() < 1e-14, "{shift:?}");
        }
    }

    #[test]
    fn spheres_that_do_not_meet_have_a_point_between_them() {
        let project = |x, radius| project_to_circle(x, ([0.0; 3], radius), ([3.0, 0.0, 0.0], radius));
        assert_eq!(project([1.0, 2.0, 0.0], 1.0), ([1.5, 0.0, 0.0], [0.5, -2.0, 0.0]));
        // A node on the axis has no direction away from it.
        assert_eq!(project([4.0, 0.0, 0.0], 2.0), ([1.5, 0.0, 0.0], [-2.5, 0.0, 0.0]));
    }

    #[test]
    fn pins_at_one_place_far_out_hold_as_one() {
        // In 32 bits both balls differ by rounding alone, which is a thousandth of a millimetre there.
        for n in 0..3000_u16 {
            let at = [10.0_f32 + f32::from(n % 53) / 7.0, -20.0 + f32::from(n % 31) / 3.0, 5.0];
            let other = [at[0] + if n % 3 == 0 { 2e-6 } else { 0.0 }, at[1], at[2]];
            let length = radius::<f32>(0.3 + f64::from(n % 97) / 140.0);
            let x = [at[0] + 0.5 + f32::from(n % 11) / 20.0, at[1] - 1.0 - f32::from(n % 7), at[2] + 0.3];
            let (there, shift, _) = project_to_two(x, (at, length), (other, length));
            let alone = project_to_sphere(x, (at, length)).0;
            assert!(norm(sub(there, alone)) < 2e-5, "{n}: {there:?} for {alone:?}");
            assert!(norm(shift).is_finite());
        }
    }

    #[test]
    fn a_taut_row_between_pins_that_move_stays_smooth() {
        // Two pins as far apart as the row is long move at 1 m/s; gravity pulls at its middle.
        let (h, mut before) = (5e-4_f32, None);
        let half = radius::<f32>(0.5);
        for step in 0..4000_u16 {
            let x = h * f32::from(step) - 1.5;
            let node = before.map_or([x + 0.5, 0.0, 0.0], |[_, y, z]: [f32; 3]| [x + 0.5, y - 2.5e-6, z]);
            let (there, ..) = project_to_two(node, ([x, 0.0, 0.0], half), ([x + 1.0, 0.0, 0.0], half));
            let jump = before.map_or(0.0, |[_, y, _]| there[1] - y);
            // √ε of the length, 3e-4 m, without the room of `radius`.
            assert!(jump < 1e-4 && there[1] > -4e-3, "{step}: {there:?} by {jump}");
            before = Some(there);
        }
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
