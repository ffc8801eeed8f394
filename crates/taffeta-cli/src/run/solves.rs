//! How hard the constraints of a run were to solve.

use crate::summary::SolverSummary;
use serde::{Deserialize, Serialize};
use taffeta::diagnostics::{FrameReport, SolverReport};
use taffeta::scene::{ConstraintForm, Method, Scene};

/// The solver's reports over a run.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
pub struct Solves {
    frames: u32,
    iterations: u32,
    residual: f64,
    active_fraction: f64,
    capped: u64,
    /// Sums over frames.
    all_iterations: u64,
    all_fractions: f64,
}

impl Solves {
    /// A frame.
    pub fn add(&mut self, report: &FrameReport) {
        let SolverReport { iterations, residual, active_fraction, capped } = report.solver;
        self.frames += 1;
        self.iterations = self.iterations.max(iterations);
        self.residual = self.residual.max(residual);
        self.active_fraction = self.active_fraction.max(active_fraction);
        self.capped += u64::from(capped);
        self.all_iterations += u64::from(iterations);
        self.all_fractions += active_fraction;
    }

    /// For the summary.
    pub fn summary(&self) -> SolverSummary {
        let frames = f64::from(self.frames.max(1));
        SolverSummary {
            iterations: self.iterations,
            mean_iterations: self.all_iterations as f64 / frames,
            residual: self.residual,
            active_fraction: self.active_fraction,
            mean_active_fraction: self.all_fractions / frames,
            capped: self.capped,
        }
    }

    /// What to say of solutions, in so many sub-steps, that were not as good as was asked for.
    pub fn warning(&self, scene: &Scene, substeps: u64) -> Option<String> {
        let (ice, acad) = (&scene.solver.ice, &scene.solver.acad);
        if self.capped == 0 {
            return None;
        }
        let (table, form) = match scene.solver.method {
            Method::Acad => ("acad", acad.form),
            _ => ("ice", ice.form),
        };
        let more = match form {
            ConstraintForm::Compliant => format!("a larger {table}.epsilon"),
            // The error of a Newton step is not that of its system.
            ConstraintForm::Primal => "softer springs (newton_steps does not help)".to_owned(),
            _ => format!("{table}.form = \"compliant\""),
        };
        Some(format!(
            "the solver's residual was beyond the tolerance of {:?} in {} of {} sub-steps, up to {:.1e}, after up to {} \
             iterations; in [solver], a larger ice.max_iterations or ice.tolerance, {more}, or a smaller time.max_step \
             would do",
            ice.tolerance, self.capped, substeps, self.residual, self.iterations
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(iterations: u32, residual: f64, active_fraction: f64, capped: u32) -> FrameReport {
        let solver = SolverReport { iterations, residual, active_fraction, capped };
        FrameReport { solver, ..FrameReport::default() }
    }

    #[test]
    fn a_run_adds_up_extremes_means_and_what_was_not_solved() {
        let mut solves = Solves::default();
        let mut scene = Scene::new("").time(0.01, 0.002).method(Method::Ice);
        assert_eq!(solves.summary(), SolverSummary::default());
        solves.add(&frame(10, 1e-4, 0.25, 0));
        assert_eq!(solves.warning(&scene, 10), None);
        solves.add(&frame(200, 0.03, 0.75, 2));
        let expected = SolverSummary {
            iterations: 200,
            mean_iterations: 105.0,
            residual: 0.03,
            active_fraction: 0.75,
            mean_active_fraction: 0.5,
            capped: 2,
        };
        assert_eq!(solves.summary(), expected);
        let said = solves.warning(&scene, 10).unwrap();
        assert!(
            said.contains("tolerance of 0.001 in 2 of 10 sub-steps, up to 3.0e-2, after up to 200"),
            "{said}"
        );
        assert!(said.contains("a larger ice.epsilon"), "{said}");
        scene.solver.method = Method::Acad;
        scene.solver.acad.form = ConstraintForm::Printed;
        let said = solves.warning(&scene, 10).unwrap();
        assert!(said.contains("acad.form = \"compliant\"") && !said.contains("epsilon"), "{said}");
        scene.solver.method = Method::Ice;
        scene.solver.ice.form = ConstraintForm::Primal;
        let said = solves.warning(&scene, 10).unwrap();
        assert!(said.contains("softer springs") && !said.contains("epsilon"), "{said}");
    }
}
