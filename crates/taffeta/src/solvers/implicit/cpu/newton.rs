//! Newton steps: as many as the scene says, or as the equations need.

use crate::real::{Real, dot};
use crate::solvers::implicit::cpu::ImplicitWorker;
use crate::solvers::implicit::cpu::conjugate::CgState;
use crate::solvers::implicit::implicit::times;

/// Most Newton steps that are taken where the scene does not say how many.
const MOST_STEPS: u32 = 4;

/// Share of what errors are measured by, in Σ m δ², from which on a step may have left much.
const FAR: f64 = 0.25;

/// Residual of the equations after a step, relative to what errors are measured by, from which on another one follows.
const LEFT: f64 = 0.7;

impl<T: Real> ImplicitWorker<'_, '_, T> {
    /// Finds what springs change of velocities.
    pub fn solve(&mut self) {
        let (least, most) = match self.primal.ice.newton_steps {
            0 => (1, MOST_STEPS),
            steps => (steps, steps),
        };
        self.scratch.bodies.clear();
        self.scratch.bodies.resize(self.primal.tables[0].bodies.len(), CgState::default());
        self.soften();
        self.each(0, Self::begin_step);
        self.worker.synchronise();
        for step in 1.. {
            self.scratch.bodies.iter_mut().for_each(|body| *body = body.again());
            self.linearise();
            self.each(0, Self::set_up);
            self.worker.synchronise();
            let mut is_last = step > least && self.is_enough();
            if !is_last {
                self.step(step == 1);
                is_last = step == most || (step >= least && !self.went_far());
            }
            self.each_of_all(0, |worker, chunk| worker.take(chunk, is_last));
            self.worker.synchronise();
            if is_last {
                break;
            }
        }
        self.report();
    }

    /// Solves for a Newton step whose system is set up on the finest level.
    fn step(&mut self, is_first: bool) {
        self.coarsen();
        self.scale_jacobi();
        self.start(is_first);
        self.iterate();
        self.find_drifts();
    }

    /// Whether a step went so far on some body that it may have left much.
    fn went_far(&self) -> bool {
        self.scratch.bodies.iter().any(|body| body.moved > FAR * body.whole)
    }

    /// Whether the equations are met well enough where the last step went; a body on which they are takes no further one.
    fn is_enough(&mut self) -> bool {
        self.start(false);
        self.each(0, |worker, chunk| {
            let here = &worker.shared.levels[0];
            // SAFETY: only this chunk's places.
            let (residual, inverse) = unsafe { (here.r.read(), here.inverse.read()) };
            let mut sum = 0.0;
            for place in chunk.part.clone() {
                let r: [T; 3] = residual.at(place);
                sum += dot(r, times(&inverse.at(place), r)).to_f64();
            }
            *worker.product_of(chunk) = [sum, 0.0];
        });
        self.worker.synchronise();
        for index in 0..self.scratch.bodies.len() {
            let [left, _] = self.product_sums(index);
            let body = &mut self.scratch.bodies[index];
            // What is no number is not made one by further steps.
            let is_much = left > LEFT * LEFT * body.whole;
            body.done = !is_much;
        }
        self.worker.synchronise();
        self.scratch.bodies.iter().all(|body| body.done)
    }
}
