//! The volume inside a closed surface, kept by one Lagrange multiplier a body.
//!
//! Source: Va, Choi, Hong, "Real-Time Surface-Based Volume Constraints on Mass-Spring Model in Unity3D", 2023, eqs. 9–15
//! and algorithm 2; local weights after Hong, Jung, Choi, Welch, "Fast Volume Preservation for a Mass-Spring System",
//! 2006. What was corrected, and why: docs/models/volume.md.
//!
//! With places r = x − o [m] from a node o of the body, and over the ring of a node's triangles (a, b, c):
//! g = ∂V/∂a = Σ (b − a)×(c − a)/6 [m²], V = Σ r·g/3 [m³].
//! With v* = v + h (w f + g₀), the velocity [m/s] without the constraint, Φ = V − V₀ and D = Σ w |g|²:
//! λ = (Φ/h² + Σ g·v*/h)/D [Pa], and the force of the constraint is −λ g [N].
//!
//! With weights W the force is −λ u, u = W g − m (A + Ω × (x − c)). This subtracts the rigid motion of the whole body
//! by which W g would change its momenta, A = Σ W g/M, Ω = I⁻¹ Σ (x − c) × W g. If nodes are pinned, the pins take up
//! the momenta, and u = W g. D = Σ w g·u = Σ w W |g|²: the gradients of a free body have neither resultant nor
//! moment.

use crate::real::{Real, cross, dot, scale, sub};
#[cfg(feature = "paper-forms")]
use crate::volume::printed;

/// How the multiplier is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Form {
    /// From the volume to keep, as above.
    Kept = 0,
    /// As the paper's programs do.
    #[cfg(feature = "paper-forms")]
    PaperShader = 1,
    /// As the paper prints it.
    #[cfg(feature = "paper-forms")]
    Printed = 2,
    /// A pressure p [Pa]: λ = −p.
    Pressure = 3,
}

impl Form {
    /// All that there are.
    pub const ALL: &[Self] = &[
        Self::Kept,
        #[cfg(feature = "paper-forms")]
        Self::PaperShader,
        #[cfg(feature = "paper-forms")]
        Self::Printed,
        Self::Pressure,
    ];

    /// Those whose volume error grows with every step.
    pub const DIVERGING: &[Self] = &[
        #[cfg(feature = "paper-forms")]
        Self::Printed,
    ];
}

/// The numbers of a node in the sums of its body.
#[derive(Clone, Copy, Debug)]
pub struct Node<T> {
    /// Position relative to the body's reference node [m].
    pub place: [T; 3],
    /// Gradient of the volume with respect to its position [m²].
    pub gradient: [T; 3],
    /// Velocity without the constraint [m/s].
    pub velocity: [T; 3],
    /// Inverse mass [1/kg]; 0: held.
    pub inverse_mass: T,
}

/// Sums over all nodes of a body: 3 V [m³], Σ g·v* [m³/s], D [m⁴/kg].
pub const SUMS: usize = 3;
/// Further sums with weights: M, Σ m r (3), Σ m r rᵀ (xx, yy, zz, xy, xz, yz), Σ W g (3), Σ r × W g (3), pinned
/// nodes.
pub const WEIGHTED_SUMS: usize = SUMS + 17;

/// The terms of a node.
#[inline(always)]
pub fn terms<T: Real>(node: &Node<T>) -> [T; SUMS] {
    let Node { place, gradient, velocity, inverse_mass } = *node;
    [dot(place, gradient), dot(gradient, velocity), inverse_mass * dot(gradient, gradient)]
}

/// The terms of a node with the weight `weight` and the mass `mass` [kg].
#[inline(always)]
pub fn weighted_terms<T: Real>(node: &Node<T>, weight: T, mass: T) -> [T; WEIGHTED_SUMS] {
    let ([volume, flux, response], r) = (terms(node), node.place);
    let weighted = scale(node.gradient, weight);
    let (m, turn) = (scale(r, mass), cross(r, weighted));
    [
        volume,
        flux,
        weight * response,
        mass,
        m[0],
        m[1],
        m[2],
        m[0] * r[0],
        m[1] * r[1],
        m[2] * r[2],
        m[0] * r[1],
        m[0] * r[2],
        m[1] * r[2],
        weighted[0],
        weighted[1],
        weighted[2],
        turn[0],
        turn[1],
        turn[2],
        if node.inverse_mass > T::ZERO { T::ZERO } else { T::ONE },
    ]
}

/// The force that keeps a body's volume, or the translation that restores it: −λ u.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VolumeCorrection<T> {
    /// λ [Pa], or [kg/m²·s²] where positions are moved.
    pub lambda: T,
    /// A [m²/kg].
    pub shift: [T; 3],
    /// Ω [m/kg].
    pub spin: [T; 3],
    /// c − o [m].
    pub centre: [T; 3],
}

/// The correction of a sub-step of `h` [s] that ends at the volume `goal` [m³], or has the pressure `goal` [Pa].
pub fn correction<T: Real>(form: Form, sums: &[T], goal: T, h: T) -> VolumeCorrection<T> {
    let off = sums[0] / T::from_f64(3.0) - goal;
    let flux = sums[1] / h;
    let (mut correction, response) = (rigid_correction(sums), sums[2]);
    correction.lambda = match form {
        Form::Kept => quotient(off / (h * h) + flux, response),
        #[cfg(feature = "paper-forms")]
        Form::PaperShader => quotient(printed::of_programs(off, flux), response),
        #[cfg(feature = "paper-forms")]
        Form::Printed => quotient(printed::as_printed(off, flux, h), response),
        Form::Pressure => -goal,
    };
    correction
}

/// The correction that moves nodes so that the volume is `goal` [m³]; `None` if it is, within `tolerance`. Instead of
/// Σ g·v*, the sums have D of all nodes, including those that must not move. If these are nearly all nodes, the few
/// others would be thrown across the scene. So they restore a part only, and the rest remains as an error.
pub fn projection<T: Real>(sums: &[T], goal: T, tolerance: T) -> Option<VolumeCorrection<T>> {
    let off = sums[0] / T::from_f64(3.0) - goal;
    if off.abs() <= tolerance * goal {
        return None;
    }
    let mut correction = rigid_correction(sums);
    correction.lambda = restoring(off, sums);
    Some(correction)
}

/// The multiplier that restores a volume with the error `off` [m³].
pub fn restoring<T: Real>(off: T, sums: &[T]) -> T {
    let (response, least) = (sums[2], T::from_f64(FEW) * sums[1]);
    quotient(off, if response > least { response } else { least })
}

/// Fraction of a body's response below which the movable nodes are few.
pub const FEW: f64 = 0.0625;

/// a + b × c, one product after the other: some shader compilers do so whatever the parentheses are.
#[inline(always)]
fn add_cross<T: Real>(a: [T; 3], b: [T; 3], c: [T; 3]) -> [T; 3] {
    [a[0] + b[1] * c[2] - b[2] * c[1], a[1] + b[2] * c[0] - b[0] * c[2], a[2] + b[0] * c[1] - b[1] * c[0]]
}

/// A quotient; 0 if nothing can move.
fn quotient<T: Real>(wanted: T, response: T) -> T {
    if response > T::TINY { wanted / response } else { T::ZERO }
}

/// −u of a node: the factor of λ.
#[inline(always)]
pub fn direction<T: Real>(
    correction: &VolumeCorrection<T>,
    node: (&[T; 3], &[T; 3]),
    weight: T,
    mass: T,
) -> [T; 3] {
    let (place, gradient) = node;
    let turned = add_cross(correction.shift, correction.spin, sub(*place, correction.centre));
    sub(scale(turned, mass), scale(*gradient, weight))
}

/// The rigid motion that weights would cause; none without weights, or if nodes are pinned.
fn rigid_correction<T: Real>(sums: &[T]) -> VolumeCorrection<T> {
    let mut correction = VolumeCorrection::default();
    let &[_, _, _, mass, mx, my, mz, xx, yy, zz, xy, xz, yz, px, py, pz, tx, ty, tz, held] = sums else {
        return correction;
    };
    if mass <= T::ZERO || held > T::ZERO {
        return correction;
    }
    let (force, c) = ([px, py, pz], [mx / mass, my / mass, mz / mass]);
    correction.centre = c;
    correction.shift = [px / mass, py / mass, pz / mass];
    let torque = add_cross([tx, ty, tz], force, c);
    let [xx, yy, zz] = [xx - mx * c[0], yy - my * c[1], zz - mz * c[2]];
    let [xy, xz, yz] = [xy - mx * c[1], xz - mx * c[2], yz - my * c[2]];
    correction.spin = solve([yy + zz, xx + zz, xx + yy], [-xy, -xz, -yz], torque);
    correction
}

/// Solves A x = b with A symmetric, by cofactors: `d` is its diagonal, `o` = (A₁₂, A₁₃, A₂₃). 0 if A is singular.
pub fn solve<T: Real>(d: [T; 3], o: [T; 3], b: [T; 3]) -> [T; 3] {
    let trace = d[0] + d[1] + d[2];
    if trace <= T::ZERO {
        return [T::ZERO; 3];
    }
    // Scaled to size 1, so that a small determinant means a flat matrix, not small units.
    let [d, o, b] = [d, o, b].map(|v| [v[0] / trace, v[1] / trace, v[2] / trace]);
    let c = [d[1] * d[2] - o[2] * o[2], o[1] * o[2] - o[0] * d[2], o[0] * o[2] - d[1] * o[1]];
    let determinant = d[0] * c[0] + o[0] * c[1] + o[1] * c[2];
    if determinant <= T::from_f64(FLAT) {
        return [T::ZERO; 3];
    }
    let [e, f, g] = [d[0] * d[2] - o[1] * o[1], o[0] * o[1] - d[0] * o[2], d[0] * d[1] - o[0] * o[0]];
    let x = [dot(c, b), dot([c[1], e, f], b), dot([c[2], f, g], b)];
    [x[0] / determinant, x[1] / determinant, x[2] / determinant]
}

/// Determinant below which a tensor of inertia, divided by its trace, is that of a line.
pub const FLAT: f64 = 1e-7;

/// Weight of a node at a `distance` [m] from the centre of a ball of `radius` [m]: eq. 15 with the missing π, cut off at
/// the radius.
pub fn weight(distance: f64, radius: f64) -> f64 {
    if distance < radius { 0.5 * (libm::cos(std::f64::consts::PI * distance / radius) + 1.0) } else { 0.0 }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::real::add;

    type V = [f64; 3];

    /// The corner of a cube of edge 1 m at the origin: V = 1/6 m³, each gradient a third of the face across from it.
    pub const CORNER: [V; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    pub const SLOPES: [V; 4] = {
        let s = 1.0 / 6.0;
        [[-s, -s, -s], [s, 0.0, 0.0], [0.0, s, 0.0], [0.0, 0.0, s]]
    };

    fn volume(x: &[V; 4]) -> f64 {
        let [a, b, c] = [1, 2, 3].map(|i| sub(x[i], x[0]));
        dot(a, cross(b, c)) / 6.0
    }

    /// The corner's nodes with inverse masses.
    fn nodes(velocity: [V; 4], inverse_mass: [f64; 4]) -> [Node<f64>; 4] {
        std::array::from_fn(|i| Node {
            place: CORNER[i],
            gradient: SLOPES[i],
            velocity: velocity[i],
            inverse_mass: inverse_mass[i],
        })
    }

    fn add_up<const N: usize>(terms: impl IntoIterator<Item = [f64; N]>) -> [f64; N] {
        terms.into_iter().fold([0.0; N], |sum, term| std::array::from_fn(|i| sum[i] + term[i]))
    }

    pub fn near(got: f64, expected: f64, tolerance: f64) {
        assert!((got - expected).abs() <= tolerance, "{got}, expected {expected} ± {tolerance:e}");
    }

    #[test]
    fn sums_of_a_tetrahedron_are_as_by_hand() {
        // The corner at (1, 0, 0) leaves at 3 m/s along x; that at the origin is held.
        let velocity = [[0.0; 3], [3.0, 7.0, 0.0], [0.0; 3], [0.0; 3]];
        let sums = add_up(nodes(velocity, [0.0, 1.0, 2.0, 0.5]).iter().map(terms));
        near(sums[0], 3.0 / 6.0, 1e-15);
        near(sums[1], 3.0 / 6.0, 1e-15);
        near(sums[2], (1.0 + 2.0 + 0.5) / 36.0, 1e-15);
        // From wherever places are counted.
        let shifted = nodes(velocity, [1.0; 4]).map(|n| Node { place: add(n.place, [5.0, -3.0, 2.0]), ..n });
        near(add_up(shifted.iter().map(terms))[0], 0.5, 1e-14);
    }

    /// Volume [m³] after a step of `h` [s] of a form that should end at `goal`, to first order and in truth.
    pub fn stepped(form: Form, goal: f64, h: f64) -> (f64, f64) {
        let velocity = [[0.1, 0.0, 0.2], [0.5, -0.3, 0.0], [0.0, 0.4, 0.1], [-0.2, 0.3, 0.6]];
        let inverse_mass = [0.5, 1.0, 2.0, 4.0];
        let all = nodes(velocity, inverse_mass);
        let correction = correction(form, &add_up(all.iter().map(terms)), goal, h);
        let moves = all.map(|n| {
            let force = scale(n.gradient, -correction.lambda);
            scale(add(n.velocity, scale(force, n.inverse_mass * h)), h)
        });
        let linear: f64 = moves.iter().zip(&SLOPES).map(|(&m, &g)| dot(m, g)).sum();
        (1.0 / 6.0 + linear, volume(&std::array::from_fn(|i| add(CORNER[i], moves[i]))))
    }

    #[test]
    fn the_volume_kept_is_met_in_one_linear_step_and_to_second_order_in_truth() {
        for goal in [1.0 / 6.0, 0.2, 0.1] {
            near(stepped(Form::Kept, goal, 1e-3).0, goal, 1e-15);
        }
        let error = |h: f64| (stepped(Form::Kept, 1.0 / 6.0, h).1 - 1.0 / 6.0).abs();
        near(error(1e-3) / error(5e-4), 4.0, 0.01);
    }

    #[test]
    fn moved_nodes_restore_the_volume_and_stay_where_it_is_right() {
        let all = nodes([[0.0; 3]; 4], [0.0, 1.0, 2.0, 4.0]);
        let sums = add_up(all.iter().map(terms));
        let correction = projection(&sums, 0.17, 1e-6).unwrap();
        let moves = all.map(|n| scale(n.gradient, -correction.lambda * n.inverse_mass));
        near(moves.iter().zip(&SLOPES).map(|(&m, &g)| dot(m, g)).sum(), 0.17 - 1.0 / 6.0, 1e-16);
        assert_eq!(moves[0], [0.0; 3]);
        assert_eq!(projection(&sums, (1.0 / 6.0) * (1.0 - 0.9e-6), 1e-6), None);
    }

    #[test]
    fn where_nothing_can_move_nothing_pushes() {
        let sums = add_up(nodes([[1.0; 3]; 4], [0.0; 4]).iter().map(terms));
        assert_eq!(correction(Form::Kept, &sums, 0.1, 1e-3).lambda, 0.0);
        assert_eq!(projection(&sums, 0.1, 1e-6).unwrap().lambda, 0.0);
        assert_eq!(correction(Form::Kept, &sums.map(|s| s as f32), 0.1, 1e-3).lambda, 0.0);
    }

    /// Seven nodes, whose gradients add up to nothing and turn nothing, as on any closed surface (an octahedron, its
    /// corners shifted, and one node that no triangle has).
    fn blob(held: &[usize]) -> ([Node<f64>; 7], [f64; 7], [f64; 7]) {
        let x = [
            [1.1, 0.1, 0.0],
            [-0.9, 0.0, 0.2],
            [0.1, 1.3, 0.0],
            [0.0, -1.0, -0.1],
            [0.2, 0.1, 0.8],
            [0.0, 0.3, -1.2],
            [2.0, 2.0, 2.0],
        ];
        let mut gradient = [[0.0; 3]; 7];
        let faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
        for [a, b, c] in faces {
            let area = scale(cross(sub(x[b], x[a]), sub(x[c], x[a])), 1.0 / 6.0);
            for node in [a, b, c] {
                gradient[node] = add(gradient[node], area);
            }
        }
        let mass = [1.0, 2.0, 0.5, 1.5, 3.0, 1.0, 0.7];
        let node = |i: usize| Node {
            place: x[i],
            gradient: gradient[i],
            velocity: [0.1 * i as f64, -0.2, 0.3],
            inverse_mass: if held.contains(&i) { 0.0 } else { 1.0 / mass[i] },
        };
        (std::array::from_fn(node), mass, [1.0, 0.0, 0.3, 0.8, 0.5, 0.0, 0.0])
    }

    #[test]
    fn forces_with_weights_meet_the_volume_and_neither_shift_nor_turn_a_free_body() {
        for held in [&[][..], &[1], &[0, 5], &[0, 2, 3], &[0, 1, 2, 5]] {
            let (nodes, mass, weight) = blob(held);
            let sums = add_up((0..7).map(|i| weighted_terms(&nodes[i], weight[i], mass[i])));
            let (goal, h) = (0.9 * sums[0] / 3.0, 1e-2);
            let correction = correction(Form::Kept, &sums, goal, h);
            let direction =
                |i: usize| direction(&correction, (&nodes[i].place, &nodes[i].gradient), weight[i], mass[i]);
            // What free nodes do with it is what the multiplier is divided by: the volume is met in one linear step.
            let change: f64 = nodes
                .iter()
                .enumerate()
                .map(|(i, n)| {
                    let pushed = scale(direction(i), correction.lambda * n.inverse_mass * h);
                    h * dot(add(n.velocity, pushed), n.gradient)
                })
                .sum();
            near(sums[0] / 3.0 + change, goal, 1e-13);
            let apart = direction(6);
            if !held.is_empty() {
                assert_eq!(apart, [0.0; 3], "nothing pushes a node beyond the weights");
                continue;
            }
            let force = add_up((0..7).map(direction));
            let torque = add_up((0..7).map(|i| cross(nodes[i].place, direction(i))));
            assert!(force.iter().chain(&torque).all(|c| c.abs() < 1e-14), "{force:?} {torque:?}");
            // The rigid motion alone is what a weight of 0 gets.
            let rigid = scale(
                add(correction.shift, cross(correction.spin, sub(nodes[6].place, correction.centre))),
                mass[6],
            );
            assert!(apart == rigid && dot(apart, apart) > 1e-4);
        }
    }

    #[test]
    fn weights_on_held_nodes_alone_push_nothing() {
        let (nodes, mass, weight) = blob(&[0, 2, 3, 4]);
        let sums = add_up((0..7).map(|i| weighted_terms(&nodes[i], weight[i], mass[i])));
        assert_eq!(correction(Form::Kept, &sums, 1.0, 1e-3), VolumeCorrection::default());
        assert_eq!(projection(&sums, 1.0, 1e-6), Some(VolumeCorrection::default()));
    }

    #[test]
    fn weights_of_one_are_no_weights() {
        let (nodes, mass, _) = blob(&[]);
        let weighted = add_up((0..7).map(|i| weighted_terms(&nodes[i], 1.0, mass[i])));
        let [with, without] = [&weighted[..], &add_up(nodes.iter().map(terms))]
            .map(|sums| correction(Form::Kept, sums, 1.0, 0.01));
        near(with.lambda / without.lambda, 1.0, 1e-12);
        assert!(dot(with.shift, with.shift) + dot(with.spin, with.spin) < 1e-28);
    }

    #[test]
    fn a_symmetric_system_is_solved() {
        // ((4, 1, −1), (1, 3, 2), (−1, 2, 5)) (1, −2, 3).
        for size in [1.0, 1e-12, 1e12] {
            let scaled = |v: V| v.map(|c| c * size);
            let x = solve(scaled([4.0, 3.0, 5.0]), scaled([1.0, -1.0, 2.0]), scaled([-1.0, 1.0, 10.0]));
            (0..3).for_each(|i| near(x[i], [1.0, -2.0, 3.0][i], 1e-13));
        }
    }

    #[test]
    fn a_point_a_line_and_nothing_have_no_spin_and_give_no_nan() {
        assert_eq!(solve([0.0; 3], [0.0; 3], [1.0; 3]), [0.0; 3]);
        for along in [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 2.0, -2.0]] {
            let node = |i: i32| Node {
                place: scale(along, f64::from(i)),
                gradient: [0.1, 0.2, f64::from(i)],
                velocity: [0.0; 3],
                inverse_mass: 1.0,
            };
            let sums = add_up((0..4).map(|i| weighted_terms(&node(i), 0.5, 1.0)));
            for &form in Form::ALL {
                let correction = correction(form, &sums, 1.0, 1e-3);
                let numbers = [[correction.lambda; 3], correction.shift, correction.spin, correction.centre];
                assert!(numbers.as_flattened().iter().all(|c| c.is_finite()), "{along:?} {correction:?}");
                assert_eq!(correction.spin, [0.0; 3]);
            }
        }
        assert_eq!(correction(Form::Kept, &[0.0; WEIGHTED_SUMS], 1.0, 1e-3), VolumeCorrection::default());
    }

    #[test]
    fn a_weight_falls_from_one_at_the_centre_to_nothing_at_the_radius() {
        assert_eq!(weight(0.0, 0.3), 1.0);
        near(weight(0.15, 0.3), 0.5, 1e-15);
        near(weight(0.1, 0.3), 0.75, 1e-15);
        assert_eq!([weight(0.3, 0.3), weight(0.6, 0.3), weight(f64::INFINITY, 0.3)], [0.0; 3]);
        assert!(weight(0.3 * (1.0 - 1e-9), 0.3) < 1e-16);
    }
}
