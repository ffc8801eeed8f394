//! Springs as constraints: implicit constraint enforcement.
//!
//! Source: Va, Choi, Hong, "Real-Time Cloth Simulation Using Compute Shader in Unity3D for AR/VR Contents", 2021, §2.2;
//! the compliance after Servin, Lacoursière and Melin, "Interactive Simulation of Elastic Deformable Materials", 2006.
//!
//! Between nodes a and b, with d = x_b − x_a, l = |d|, n = d/l and J u = n·(u_b − u_a): the pull λ [N] of all
//! constraints solves
//!
//! (J W Jᵀ + D) λ = c + J v*/h,
//!
//! where v* is the velocity that all other forces would give. With stiffness k and damping e of the material,
//! D = 1/(h (k h + e)) and c = k (l − L)/(h (k h + e)): that is, λ = k (l − L) + e l̇ at the end of the step, in which l
//! changes along n. Each row and column is multiplied by its s, so that the diagonal of the system is 1.

use crate::real::{Real, dot};
use crate::scene::ConstraintForm;

/// How a constraint gives way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Softness<T> {
    /// Compliance 1/(h (k h + e)) [1/kg]; 0: none but `epsilon`.
    pub compliance: T,
    /// Share of the elongation that the right side asks for, k/(h (k h + e)) [1/s²].
    pub rate: T,
    /// Compliance by the diagonal.
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

impl<T: Real> Softness<T> {
    /// Of a spring of stiffness `k` [N/m] and damping `d` [kg/s] over a step `h` [s]. One of them is more than 0.
    pub fn spring(k: f64, d: f64, epsilon: f64, form: ConstraintForm, h: f64) -> Self {
        let compliance = 1.0 / (h * (k * h + d));
        match form {
            ConstraintForm::Compliant | ConstraintForm::Primal => Self {
                compliance: T::from_f64(compliance),
                rate: T::from_f64(k * compliance),
                epsilon: T::from_f64(epsilon),
                form,
            },
            ConstraintForm::Printed => Self::stiff(0.0, form, h),
        }
    }

    /// Without a material: what is too long is closed within a step `h` [s], as far as `epsilon` lets it.
    pub fn stiff(epsilon: f64, form: ConstraintForm, h: f64) -> Self {
        let epsilon = if form == ConstraintForm::Printed { 0.0 } else { epsilon };
        Self { compliance: T::ZERO, rate: T::from_f64(1.0 / (h * h)), epsilon: T::from_f64(epsilon), form }
    }

    /// The row of a constraint: `d` from its first to its second end [m], the sum of their inverse masses [1/kg], and the
    /// length that it aims at [m]. Of two held ends nothing is asked.
    #[inline(always)]
    pub fn row(&self, d: [T; 3], inverse_mass: T, rest_length: T) -> Row<T> {
        let squared = dot(d, d);
        let squared = if squared < T::TINY { T::TINY } else { squared };
        let length = squared.sqrt();
        let inverse = T::ONE / length;
        let free = inverse_mass > T::ZERO;
        let (scale, compliance, off) = if self.form == ConstraintForm::Printed {
            let twice = length + length;
            (twice, T::ZERO, (squared - rest_length * rest_length) / twice)
        } else {
            let compliance = self.compliance + self.epsilon * inverse_mass;
            (T::ONE / (inverse_mass + compliance).sqrt(), compliance, length - rest_length)
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

/// What the last digit of a place near `x` [m] is worth on the right side of a row: nothing is solved beyond it.
#[inline(always)]
pub fn noise<T: Real>(row: &Row<T>, rate: T, x: [T; 3]) -> T {
    row.scale * (rate * (T::EPSILON * (x[0].abs() + x[1].abs() + x[2].abs())))
}

/// The scalars of conjugate gradients with one reduction an iteration.
///
/// Source: Chronopoulos and Gear, "s-step iterative methods for symmetric linear systems", 1989.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Conjugate {
    /// r·r of the iteration before.
    gamma: f64,
    /// Length of the step before.
    alpha: f64,
}

impl Conjugate {
    /// The step along the new direction, and the share of the old one in it, from r·r and r·A r; `None` where the system
    /// answers no more.
    pub fn step(&mut self, gamma: f64, delta: f64) -> Option<(f64, f64)> {
        let first = self.gamma == 0.0;
        let beta = if first { 0.0 } else { gamma / self.gamma };
        let curvature = if first { delta } else { delta - beta * gamma / self.alpha };
        let alpha = gamma / curvature;
        if !(curvature > 0.0 && alpha.is_finite()) {
            return None;
        }
        (self.gamma, self.alpha) = (gamma, alpha);
        Some((alpha, beta))
    }
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
    fn the_printed_row_is_that_of_the_squared_length() {
        let softness = Softness::<f64>::spring(10.0, 2.0, 0.5, ConstraintForm::Printed, 0.5);
        let row = softness.row([3.0, 0.0, 4.0], 2.0, 4.0);
        // Φ = 25 − 16, gradient 2 d.
        assert_eq!((row.direction, row.compliance, row.scale), ([6.0, 0.0, 8.0], 0.0, 10.0));
        assert!((row.right - 9.0 / 0.25).abs() < 1e-13);
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
