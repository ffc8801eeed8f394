//! Newton steps: as many as the scene says, or as the equations need.

use crate::real::{Real, dot, times};
use crate::solvers::implicit::cpu::conjugate::CgState;
use crate::solvers::implicit::cpu::{ImplicitWorker, Scratch};
use crate::solvers::implicit::implicit::{MOST_STEPS, leaves_much, motion};

impl<T: Real> ImplicitWorker<'_, '_, T> {
    /// Finds what springs change of velocities.
    pub fn solve(&mut self) {
        let (least, most) = match self.primal.ice.newton_steps {
            0 => (1, MOST_STEPS),
            steps => (steps, steps),
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
            self.scratch.bodies.iter_mut().for_each(|body| *body = body.again());
            self.linearise();
            self.each(0, Self::set_up);
            self.worker.synchronise();
            self.add_contacts(step == 1);
            if step > least && self.is_enough() || self.worker.is_stopped() {
                break;
            }
            self.step(step == 1);
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

    /// Solves for a Newton step whose system is set up on the finest level.
    fn step(&mut self, is_first: bool) {
        self.coarsen();
        self.scale_jacobi();
        self.start(is_first);
        self.iterate();
        self.find_drifts();
    }

    /// Whether the equations are met well enough where the last step went; a body on which they are takes no further one, nor
    /// does one that has no iterations left.
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
            worker.note_products(chunk, [sum, 0.0]);
        });
        self.worker.synchronise();
        let sums = self.product_sums();
        let Scratch { bodies, outer, .. } = &mut *self.scratch;
        for ((body, [left, _]), &mut [off, squares, x, y, z, mass]) in bodies.iter_mut().zip(sums).zip(outer)
        {
            let may = body.all < self.primal.ice.max_iterations;
            body.met |= !(may && leaves_much(left, motion([off, squares], [x, y, z], mass)));
            body.done = body.met;
        }
        self.worker.synchronise();
        self.scratch.bodies.iter().all(|body| body.met)
    }
}
