//! Springs as constraints: implicit constraint enforcement.
//!
//! Source: Va, Choi, Hong, "Real-Time Cloth Simulation Using Compute Shader in Unity3D for AR/VR Contents", 2021, §2.2;
//! the compliance after Servin, Lacoursière and Melin, "Interactive Simulation of Elastic Deformable Materials", 2006.
//!
//! Between nodes a and b, with d = x_b − x_a, l = |d|, n = d/l and J u = n·(u_b − u_a): the forces λ [N] of all
//! constraints solve
//!
//! (J W Jᵀ + D) λ = c + J v*/h,
//!
//! where v* is the velocity that all other forces would give. With stiffness k and damping e of the material,
//! D = 1/(h (k h + e)) and c = k (l − L)/(h (k h + e)): that is, λ = k (l − L) + e l̇ at the end of the step, in which l
//! changes along n. Each row and column is multiplied by its s, so that the diagonal of the system is 1.

use crate::real::{Real, dot};
use crate::scene::ConstraintForm;
#[cfg(feature = "paper-forms")]
use crate::solvers::dual::printed;

/// The softness of a constraint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Softness<T> {
    /// Compliance 1/(h (k h + e)) [1/kg]; 0: none but `epsilon`.
    pub compliance: T,
    /// Factor of the elongation in the right side, k/(h (k h + e)) [1/s²].
    pub rate: T,
    /// Compliance relative to the diagonal.
    pub epsilon: T,
    /// Which equations.
    pub form: ConstraintForm,
}

/// One row of the system.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row<T> {
    /// s n, towards the second end.
    pub direction: [T; 3],
    /// s² D.
    pub compliance: T,
    /// s c.
    pub right: T,
    /// s.
    pub scale: T,
}

/// Whether a spring with `d` between its ends [m] is an active constraint in this sub-step. It becomes active above
/// the first limit, and if it `was` active it stays so above the second one; both are squared, and relative to the
/// squared rest length. At least one end must be free.
#[inline(always)]
pub fn becomes_active<T: Real>(d: [T; 3], rest_length: T, limits: [T; 2], is_free: bool, was: bool) -> bool {
    let (squared, rest) = (dot(d, d), rest_length * rest_length);
    is_free && (squared > limits[0] * rest || (was && squared > limits[1] * rest))
}

impl<T: Real> Softness<T> {
    /// Of a spring of stiffness `k` [N/m] and damping `d` [kg/s] over a step `h` [s]. One of them is more than 0.
    pub fn spring(k: T, d: T, epsilon: T, form: ConstraintForm, h: T) -> Self {
        let compliance = T::ONE / (h * (k * h + d));
        match form {
            ConstraintForm::Compliant | ConstraintForm::Primal => {
                Self { compliance, rate: k * compliance, epsilon, form }
            }
            #[cfg(feature = "paper-forms")]
            ConstraintForm::Printed => Self::stiff(T::ZERO, form, h),
        }
    }

    /// Without a material: excess length is closed within a step `h` [s], as far as `epsilon` permits.
    pub fn stiff(epsilon: T, form: ConstraintForm, h: T) -> Self {
        let epsilon = match form {
            #[cfg(feature = "paper-forms")]
            ConstraintForm::Printed => T::ZERO,
            ConstraintForm::Compliant | ConstraintForm::Primal => epsilon,
        };
        Self { compliance: T::ZERO, rate: T::ONE / (h * h), epsilon, form }
    }

    /// The same in another precision.
    pub fn rounded<U: Real>(&self) -> Softness<U> {
        let [compliance, rate, epsilon] =
            [self.compliance, self.rate, self.epsilon].map(|number| U::from_f64(number.to_f64()));
        Softness { compliance, rate, epsilon, form: self.form }
    }

    /// The row of a constraint: `d` from its first to its second end [m], the sum of their inverse masses [1/kg], and
    /// the target length [m]. With two pinned ends, the row is 0.
    #[inline(always)]
    pub fn row(&self, d: [T; 3], inverse_mass: T, rest_length: T) -> Row<T> {
        let squared = dot(d, d);
        let squared = if squared < T::TINY { T::TINY } else { squared };
        let length = squared.sqrt();
        let inverse = T::ONE / length;
        let free = inverse_mass > T::ZERO;
        let (scale, compliance, off) = match self.form {
            #[cfg(feature = "paper-forms")]
            ConstraintForm::Printed => printed::row(squared, length, rest_length),
            ConstraintForm::Compliant | ConstraintForm::Primal => {
                let compliance = self.compliance + self.epsilon * inverse_mass;
                (T::ONE / (inverse_mass + compliance).sqrt(), compliance, length - rest_length)
            }
        };
        let scale = if free { scale } else { T::ZERO };
        let along = scale * inverse;
        Row {
            direction: [along * d[0], along * d[1], along * d[2]],
            compliance: scale * scale * compliance,
            right: scale * (self.rate * off),
            scale,
        }
    }
}

/// Rounding error of a position near `x` [m] in the right side of a row. The solve is no more accurate than that.
#[inline(always)]
pub fn noise<T: Real>(row: &Row<T>, rate: T, x: [T; 3]) -> T {
    row.scale * (rate * (T::EPSILON * (x[0].abs() + x[1].abs() + x[2].abs())))
}

/// The scalars of conjugate gradients with one reduction an iteration.
///
/// Source: Chronopoulos and Gear, "s-step iterative methods for symmetric linear systems", 1989.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Conjugate<T> {
    /// r·r of the iteration before.
    pub gamma: T,
    /// Length of the step before.
    pub alpha: T,
}

/// A step of conjugate gradients: lengths along the directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConjugateStep<T> {
    /// Along the new direction.
    pub alpha: T,
    /// Factor of the old direction in the new one.
    pub beta: T,
    /// Whether the curvature is positive.
    pub is_there: bool,
}

impl<T: Real> Conjugate<T> {
    /// The step along the new direction, and the factor of the old one in it, from r·r and r·A r.
    pub fn next(&self, gamma: T, delta: T) -> ConjugateStep<T> {
        let first = self.gamma == T::ZERO;
        let beta = if first { T::ZERO } else { gamma / self.gamma };
        let curvature = if first { delta } else { delta - beta * gamma / self.alpha };
        let alpha = gamma / curvature;
        ConjugateStep { alpha, beta, is_there: curvature > T::ZERO && alpha.is_finite() }
    }

    /// Takes the next step. Returns its length and the factor of the old direction; `None` if the curvature is not
    /// positive.
    pub fn step(&mut self, gamma: T, delta: T) -> Option<(T, T)> {
        let step = self.next(gamma, delta);
        if !step.is_there {
            return None;
        }
        *self = Self { gamma, alpha: step.alpha };
        Some((step.alpha, step.beta))
    }
}

/// The factor by which a start x is closest to the solution in the norm of the system, from x·b and x·A x. Unscaled,
/// the forces of a sub-step that was cut short can be worse than none.
pub fn warm_start_factor<T: Real>(along: T, curvature: T) -> T {
    if along > T::ZERO && curvature > T::ZERO { along / curvature } else { T::ZERO }
}

/// Squared residual at which a system has converged, from the squares of the tolerance, of the right side and of its
/// noise.
pub fn limit<T: Real>(tolerance_squared: T, right: T, noise: T) -> T {
    (tolerance_squared * right).max(noise)
}

/// Whether iterations continue at a squared residual. A NaN ends them.
pub fn is_left<T: Real>(gamma: T, limit: T, iterations: u32, most: u32) -> bool {
    gamma > limit && iterations < most
}

/// Squared residual relative to that of the right side, or to the noise.
pub fn residual_fraction<T: Real>(gamma: T, right: T, limit: T, tolerance_squared: T) -> T {
    let whole = right.max(limit / tolerance_squared);
    if whole > T::ZERO { gamma / whole } else { T::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_that_by_hand() {
        // l = 5 along (3, 0, 4), L = 4, k = 10, e = 2, h = 0.5: k h + e = 7, D = 1/3.5, c = 10 · 1/3.5. w = 2.
        let softness = Softness::<f64>::spring(10.0, 2.0, 0.5, ConstraintForm::Compliant, 0.5);
        let row = softness.row([3.0, 0.0, 4.0], 2.0, 4.0);
        let (d, c) = (1.0 / 3.5 + 1.0, 10.0 / 3.5);
        let s = 1.0 / f64::sqrt(2.0 + d);
        let expected = [s * 0.6, 0.0, s * 0.8, s * s * d, s * c, s];
        let found =
            [row.direction[0], row.direction[1], row.direction[2], row.compliance, row.right, row.scale];
        for (a, b) in found.into_iter().zip(expected) {
            assert!((a - b).abs() < 1e-14, "{found:?} {expected:?}");
        }
        // Diagonal of the scaled system.
        assert!((2.0 * dot(row.direction, row.direction) + row.compliance - 1.0).abs() < 1e-14);
    }

    #[test]
    fn held_ends_ask_for_nothing_and_ends_at_one_place_are_finite() {
        let softness = Softness::<f32>::stiff(0.3, ConstraintForm::Compliant, 0.016);
        let row = softness.row([1.0, 0.0, 0.0], 0.0, 0.5);
        assert_eq!((row.direction, row.right, row.compliance), ([0.0; 3], 0.0, 0.0));
        let row = softness.row([0.0; 3], 1.0, 0.5);
        assert!(row.direction == [0.0; 3] && row.right.is_finite());
    }

    #[test]
    fn steps_are_those_of_conjugate_gradients() {
        // A = diag(1, 3), b = (1, 1) from 0: the second step ends at (1, 1/3).
        let apply = |v: [f64; 2]| [v[0], 3.0 * v[1]];
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let (mut x, mut r, mut p, mut s) = ([0.0; 2], [1.0; 2], [0.0; 2], [0.0; 2]);
        let mut conjugate = Conjugate::default();
        for _ in 0..2 {
            let w = apply(r);
            let (alpha, beta) = conjugate.step(dot(r, r), dot(w, r)).unwrap();
            for i in 0..2 {
                (p[i], s[i]) = (r[i] + beta * p[i], w[i] + beta * s[i]);
                (x[i], r[i]) = (x[i] + alpha * p[i], r[i] - alpha * s[i]);
            }
        }
        assert!((x[0] - 1.0).abs() < 1e-15 && (x[1] - 1.0 / 3.0).abs() < 1e-15);
        assert!(conjugate.step(dot(r, r), 0.0).is_none());
    }
}
