//! The row of a constraint as its paper prints it, to compare with.
//!
//! Source: Va, Choi, Hong, "Real-Time Cloth Simulation Using Compute Shader in Unity3D for AR/VR Contents", 2021, §2.2:
//! Φ = l² − L² with the gradient 2 d, and no compliance.

use crate::real::Real;

/// s, s² D and Φ/s of a row with s = 2 l, so that s n is the gradient; from l² and l.
#[inline(always)]
pub fn row<T: Real>(squared: T, length: T, rest_length: T) -> (T, T, T) {
    let twice = length + length;
    (twice, T::ZERO, (squared - rest_length * rest_length) / twice)
}

#[cfg(test)]
mod tests {
    use crate::scene::ConstraintForm;
    use crate::solvers::dual::distance::Softness;

    #[test]
    fn the_printed_row_is_that_of_the_squared_length() {
        let softness = Softness::<f64>::spring(10.0, 2.0, 0.5, ConstraintForm::Printed, 0.5);
        let row = softness.row([3.0, 0.0, 4.0], 2.0, 4.0);
        // Φ = 25 − 16, gradient 2 d.
        assert_eq!((row.direction, row.compliance, row.scale), ([6.0, 0.0, 8.0], 0.0, 10.0));
        assert!((row.right - 9.0 / 0.25).abs() < 1e-13);
    }
}
