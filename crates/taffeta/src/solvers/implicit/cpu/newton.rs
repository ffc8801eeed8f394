//! Newton steps: as many as the scene says, or as the equations need.

use crate::real::Real;
use crate::solvers::implicit::cpu::ImplicitWorker;
use crate::solvers::implicit::cpu::conjugate::CgState;
use crate::solvers::implicit::implicit::MOST_STEPS;

impl<T: Real> ImplicitWorker<'_, '_, T> {
    /// Finds what springs change of velocities.
    pub fn solve(&mut self) {
        let most = match self.primal.ice.newton_steps {
            0 => MOST_STEPS,
            steps => steps,
        };
        let (bodies, resting) = (0..self.multigrid.tables[0].bodies.len(), self.worker.resting);
        self.scratch.bodies.clear();
        self.scratch.bodies.extend(bodies.map(|body| CgState::new(resting.has(body))));
        self.soften();
        self.each(0, |worker, chunk| worker.predict_contacts(&chunk.part));
        self.worker.synchronise();
        self.hold_points();
        self.each(0, Self::begin_step);
        self.worker.synchronise();
        self.begin_points();
        self.join_systems();
        self.sum_motion();
        for step in 1..=most {
            self.begin_newton_step();
            if step > 1 && self.is_met() || self.worker.is_stopped() {
                break;
            }
            self.linearise();
            self.each(0, Self::set_up);
            self.worker.synchronise();
            self.add_contacts(step == 1);
            self.step(step == 1);
            if self.is_met() {
                break;
            }
            self.take_back(0, &self.shared.x);
            self.each_of_all(0, |worker, chunk| worker.take(chunk));
            self.note_contacts();
            self.worker.synchronise();
        }
        self.pool_impulses();
        self.each_of_all(0, |worker, chunk| worker.note_changes(chunk));
        self.keep_contacts();
        self.worker.synchronise();
        self.report();
    }

    /// Where the solver finds how many steps it takes, none follows one that ran out of iterations.
    fn begin_newton_step(&mut self) {
        let ice = &self.primal.ice;
        for body in &mut self.scratch.bodies {
            body.met |= ice.newton_steps == 0 && body.iterations == ice.max_iterations;
            *body = body.again();
        }
    }

    /// Solves for a Newton step whose system is set up on the finest level, of those bodies whose equations are not met where it
    /// starts.
    fn step(&mut self, is_first: bool) {
        self.coarsen();
        self.scale_jacobi();
        self.start(is_first);
        self.iterate(self.primal.ice.newton_steps == 0 && !is_first);
        self.find_drifts();
    }

    /// Whether all equations are met.
    fn is_met(&self) -> bool {
        self.scratch.bodies.iter().all(|body| body.met)
    }
}
