//! The volume as its paper prints it and as its programs keep it, to compare with.
//!
//! Source: Va, Choi, Hong, "Real-Time Surface-Based Volume Constraints on Mass-Spring Model in Unity3D", 2023. Eq. 10 has
//! −3 g for the gradient; the programs have that too, and Φ for Φ/h² in eq. 14. In λ = (…)/D that leaves, with the error Φ
//! [m³] and the flux Σ g·v*/h [m³/s²]:

use crate::real::Real;

/// λ D of the programs.
pub fn of_programs<T: Real>(off: T, flux: T) -> T {
    flux - off / T::from_f64(3.0)
}

/// λ D as printed.
pub fn as_printed<T: Real>(off: T, flux: T, h: T) -> T {
    flux - off / (T::from_f64(3.0) * h * h)
}

#[cfg(test)]
mod tests {
    use crate::real::scale;
    use crate::volume::volume::tests::{CORNER, SLOPES, near, stepped};
    use crate::volume::volume::{Form, correction};

    #[test]
    fn the_printed_form_leaves_four_thirds_of_the_error() {
        let (goal, error) = (0.16, 1.0 / 6.0 - 0.16);
        for h in [1e-3, 0.1] {
            near(stepped(Form::Printed, goal, h).0 - goal, 4.0 / 3.0 * error, 1e-14);
        }
    }

    #[test]
    fn the_form_of_the_papers_programs_keeps_the_volume_that_there_is() {
        let (goal, error) = (0.16, 1.0 / 6.0 - 0.16);
        for h in [1e-3, 0.1] {
            near(stepped(Form::PaperShader, goal, h).0 - goal, (1.0 + h * h / 3.0) * error, 1e-14);
        }
    }

    #[test]
    fn eq_10_and_eq_14_give_the_same_multipliers_once_their_gradient_is_written_out() {
        // Eq. 10a at the corner (1, 0, 0) of the face (1, 2, 3): half of (y₃z₂ − y₂z₃, …), three times −1/6.
        let [p, q] = [CORNER[2], CORNER[3]];
        let printed =
            scale([q[1] * p[2] - p[1] * q[2], p[0] * q[2] - q[0] * p[2], q[0] * p[1] - p[0] * q[1]], 0.5);
        assert_eq!(printed, [-0.5, 0.0, 0.0]);
        assert_eq!(scale(SLOPES[1], -3.0), printed);
        let (h, off, flux, response) = (0.1, 0.02, 0.3, 0.7);
        let sums = [3.0 * (1.0 + off), flux, response];
        // Eq. 14 with J = −3 g, then −Jᵀλ = 3 g λ.
        let of_user = |phi: f64| -3.0 * (phi - 3.0 * flux / h) / (9.0 * response);
        near(correction(Form::Printed, &sums, 1.0, h).lambda, of_user(off / (h * h)), 1e-12);
        near(correction(Form::PaperShader, &sums, 1.0, h).lambda, of_user(off), 1e-12);
    }
}
