//! Dihedral bending of two triangles that share an edge.
//!
//! Energy ½ k (θ − θ₀)² [J], with the fold angle θ (0 when flat) between the triangles' normals and k [N·m/rad]:
//! Grinspun, Hirani, Desbrun, Schröder, "Discrete Shells", 2003, with the gradient of θ as in Bridson, Marino,
//! Fedkiw, "Simulation of Clothing with Folds and Wrinkles", 2003, sec. 4, and Tamstorf, Grinspun, "Discrete
//! bending forces and their Jacobians", 2013. Damping [N·m·s/rad] opposes dθ/dt.

use crate::elements::element::{Element, MODES, Mode};
use crate::real::{Real, add, cross, dot, scale, sub, wrap};

/// The formula, with the numbers of [`Rest`], k and damping.
pub struct Bending;

/// Fold angle [rad] and its gradient [rad/m] at the four corners: edge a, edge b, opposite in the triangle that
/// runs a→b, opposite in the other. A triangle without area gives no gradient.
#[inline(always)]
pub fn angle_and_gradient<T: Real>(x: [[T; 3]; 4]) -> (T, [[T; 3]; 4]) {
    let [a, b, c, d] = x;
    let edge = sub(b, a);
    let left = cross(edge, sub(c, a));
    let right = cross(sub(d, a), edge);
    let (squared, area_left, area_right) = (dot(edge, edge), dot(left, left), dot(right, right));
    let has_area = (squared > T::TINY) & (area_left > T::TINY) & (area_right > T::TINY);
    // Chosen, not branched to, so that compilers can do this for many hinges at a time.
    let valid = |size: T| if has_area { size } else { T::ONE };
    let (squared, area_left, area_right) = (valid(squared), valid(area_left), valid(area_right));
    let length = squared.sqrt();
    let sine = dot(cross(left, right), edge) / length;
    let theta = sine.atan2(dot(left, right));
    // ∇θ at the opposite corners: along the normals, with 1/height.
    let at_c = scale(left, -(length / area_left));
    let at_d = scale(right, -(length / area_right));
    // The rest is shared by the edge's ends so that a rigid motion does not change θ.
    let inverse = T::ONE / squared;
    let (along_c, along_d) = (dot(sub(c, a), edge) * inverse, dot(sub(d, a), edge) * inverse);
    let at_b = add(scale(at_c, -along_c), scale(at_d, -along_d));
    let at_a = add(scale(at_c, along_c - T::ONE), scale(at_d, along_d - T::ONE));
    let some = |number: T| if has_area { number } else { T::ZERO };
    let some_of = |[x, y, z]: [T; 3]| [some(x), some(y), some(z)];
    (some(theta), [some_of(at_a), some_of(at_b), some_of(at_c), some_of(at_d)])
}

/// How much stiffer a hinge may become by its triangles' shape than it is at rest.
pub const STIFFEST: f64 = 16.0;

/// What a hinge is at rest.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rest<T> {
    /// Fold angle [rad].
    pub angle: T,
    /// Σ|∇θ|² over the corners [rad²/m²]: what k is multiplied by to give a stiffness along the corners' ways.
    pub steepness: T,
}

/// The hinge at rest with its corners at `x`.
pub fn rest<T: Real>(x: [[T; 3]; 4]) -> Rest<T> {
    let (angle, gradient) = angle_and_gradient(x);
    Rest { angle, steepness: steepness(&gradient) }
}

/// Σ|∇θ|² over the corners [rad²/m²].
#[inline(always)]
pub fn steepness<T: Real>(gradient: &[[T; 3]; 4]) -> T {
    let [a, b, c, d] = gradient;
    dot(*a, *a) + dot(*b, *b) + dot(*c, *c) + dot(*d, *d)
}

/// Forces [N] on the four corners: −(k (θ − θ₀) + d dθ/dt) ∇θ.
///
/// On triangles that are squashed to slivers |∇θ| grows without bound, and no step would be stable. There the forces
/// are scaled down so that stiffness and damping along the corners' ways stay within [`STIFFEST`] times those at rest.
#[inline(always)]
pub fn forces<T: Real>(x: [[T; 3]; 4], v: [[T; 3]; 4], k: T, damping: T, at_rest: Rest<T>) -> [[T; 3]; 4] {
    let (theta, gradient) = angle_and_gradient(x);
    let rate =
        dot(gradient[0], v[0]) + dot(gradient[1], v[1]) + dot(gradient[2], v[2]) + dot(gradient[3], v[3]);
    let moment = k * wrap(theta - at_rest.angle) + damping * rate;
    let (steep, most) = (steepness(&gradient), T::from_f64(STIFFEST) * at_rest.steepness);
    let limited = moment * (most / if steep > most { steep } else { T::ONE });
    let moment = if steep > most { limited } else { moment };
    let [a, b, c, d] = gradient;
    [scale(a, -moment), scale(b, -moment), scale(c, -moment), scale(d, -moment)]
}

/// Energy ½ k (θ − θ₀)² [J].
#[inline(always)]
pub fn energy<T: Real>(x: [[T; 3]; 4], k: T, rest_angle: T) -> T {
    let fold = wrap(angle_and_gradient(x).0 - rest_angle);
    T::from_f64(0.5) * k * fold * fold
}

impl Element<4, 4> for Bending {
    #[inline(always)]
    fn forces<T: Real>(x: [[T; 3]; 4], v: [[T; 3]; 4], numbers: [T; 4]) -> [[T; 3]; 4] {
        let [angle, steepness, k, damping] = numbers;
        forces(x, v, k, damping, Rest { angle, steepness })
    }

    #[inline(always)]
    fn energy<T: Real>(x: [[T; 3]; 4], [rest_angle, _, k, _]: [T; 4]) -> T {
        energy(x, k, rest_angle)
    }

    /// The hinge as it is, which may be another shape than that at rest.
    #[inline(always)]
    fn modes<T: Real>(x: [[T; 3]; 4], [_, rest_steepness, k, d]: [T; 4]) -> [Mode<T, 4>; MODES] {
        let (_, directions) = angle_and_gradient(x);
        let (steep, most) = (steepness(&directions), T::from_f64(STIFFEST) * rest_steepness);
        // A hinge without height cannot move, and neither can one without height at rest.
        let all = most / if steep > T::ZERO { steep } else { T::ONE };
        let ratio = if steep > T::ZERO { all } else { T::ZERO };
        let is_flat = ratio > T::ONE;
        let (now, stiffest) = (if is_flat { T::ONE } else { ratio }, if is_flat { ratio } else { T::ONE });
        [Mode { directions, k: now * k, d: now * d, stiffest }, Mode::NONE, Mode::NONE]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: [[f64; 3]; 4] = [[0.1, 0.2, -0.1], [1.1, 0.1, 0.2], [0.6, 0.4, 0.9], [0.4, 0.5, -0.8]];

    #[test]
    fn a_right_fold_is_a_quarter_turn_and_flat_is_zero() {
        let flat = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.5, -1.0, 0.0]];
        assert_eq!(angle_and_gradient(flat).0, 0.0);
        let mut up = flat;
        up[3] = [0.5, 0.0, 1.0];
        assert!((angle_and_gradient(up).0.abs() - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    }

    #[test]
    fn the_gradient_is_the_angles_derivative() {
        let (_, gradient) = angle_and_gradient(X);
        for corner in 0..4 {
            for axis in 0..3 {
                let step = 1e-6;
                let at = |s: f64| {
                    let mut x = X;
                    x[corner][axis] += s;
                    angle_and_gradient(x).0
                };
                let numeric = (at(step) - at(-step)) / (2.0 * step);
                assert!((numeric - gradient[corner][axis]).abs() < 1e-8, "corner {corner} axis {axis}");
            }
        }
    }

    #[test]
    fn forces_are_minus_the_energys_derivative_and_keep_momentum() {
        let (k, rest) = (0.7, 0.3);
        let force = forces(X, [[0.0; 3]; 4], k, 0.0, Rest { angle: rest, ..super::rest(X) });
        let (mut net, mut moment) = ([0.0; 3], [0.0; 3]);
        for corner in 0..4 {
            net = add(net, force[corner]);
            moment = add(moment, cross(X[corner], force[corner]));
            for axis in 0..3 {
                let at = |s: f64| {
                    let mut x = X;
                    x[corner][axis] += s;
                    energy(x, k, rest)
                };
                let numeric = -(at(1e-6) - at(-1e-6)) / 2e-6;
                assert!((numeric - force[corner][axis]).abs() < 1e-8);
            }
        }
        assert!(net.iter().chain(&moment).all(|c| c.abs() < 1e-12));
    }

    #[test]
    fn a_triangle_without_area_gives_no_force_and_no_nan() {
        let mut x = X;
        x[2] = x[0];
        let force = forces(x, X, 1.0, 1.0, rest(X));
        assert!(force.iter().flatten().all(|&c| c == 0.0));
    }

    #[test]
    fn a_squashed_triangle_is_at_most_so_much_stiffer() {
        let mut x = X;
        x[2] = add(scale(x[0], 0.499), add(scale(x[1], 0.5), scale(x[2], 0.001)));
        let at_rest = Rest { angle: angle_and_gradient(x).0 - 0.1, ..rest(X) };
        let force = forces(x, [[0.0; 3]; 4], 2.0, 0.0, at_rest);
        let (_, gradient) = angle_and_gradient(x);
        let stiffness = dot(force[2], force[2]).sqrt() / 0.1 * steepness(&gradient).sqrt();
        assert!(steepness(&gradient) > 1e5 && stiffness <= 2.0 * STIFFEST * at_rest.steepness * (1.0 + 1e-9));
    }
}
