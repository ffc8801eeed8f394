//! The system of a Newton step, and conjugate gradients on all bodies' systems at once, each with steps of its own.

use crate::contact::colliders::predicted_contact::{Approach, PredictedContact, reach};
use crate::cpu::numbers::Numbers;
use crate::real::{Real, scale};
use crate::solvers::dual::distance::{Conjugate, warm_start_factor};
use crate::solvers::implicit::cpu::cycle::slots_of;
use crate::solvers::implicit::cpu::kernels::{Advance, Apply, FINE, Operator, Own, store};
use crate::solvers::implicit::cpu::setup::SetUp;
use crate::solvers::implicit::cpu::tables::Chunk;
use crate::solvers::implicit::cpu::{ImplicitWorker, Scratch};
use crate::solvers::implicit::implicit::{
    Stiff, is_solved, leaves_much, motion, residual_fraction, right_side, velocity_change,
};
use crate::topology::LANES;
use std::ops::Range;

/// How far the system of a body is.
#[derive(Clone, Copy, Debug, Default)]
pub struct CgState {
    conjugate: Conjugate<f64>,
    /// What errors are measured by: the larger of Σ m |v* − v|² and the first r·z.
    whole: f64,
    /// r·z of the residual r, by the preconditioner z ≈ A⁻¹ r: about eᵀ A e of the error e.
    error: f64,
    /// In this Newton step, and in all.
    pub iterations: u32,
    pub all: u32,
    pub done: bool,
    /// Whether its equations are met, so that it takes no further Newton step.
    pub met: bool,
    /// The next step, and the share of the last direction in its own.
    step: (f64, f64),
    /// Velocity [m/s] that the whole body still lacks, where nothing holds it.
    pub drift: [f64; 3],
}

impl<T: Real> ImplicitWorker<'_, '_, T> {
    /// Materials over this sub-step.
    pub fn soften(&mut self) {
        let (materials, h) = (&self.primal.materials, self.h.to_f64());
        self.scratch.stiff.clear();
        self.scratch.stiff.extend(materials.iter().map(|&[k, e]| Stiff::new(k, e, h).rounded()));
    }

    /// From where the first Newton step starts: nodes go on as they went, or as surfaces that hold them want; pins as they
    /// are moved.
    pub fn begin_step(&mut self, chunk: &Chunk) {
        self.find_base(&chunk.part);
        // SAFETY: only this chunk's places.
        let total = unsafe { self.shared.total.write::<3>(&chunk.part) };
        let (hold, masses) = (self.hold(0), self.masses());
        let mut outer = [0.0; 6];
        for (at, place) in chunk.part.clone().enumerate() {
            let [_, free] = self.base(place);
            let moves = self.worker.nodes.inverse_mass[place] > T::ZERO;
            let before = if moves { self.worker.old_velocity(place) } else { free };
            let start =
                hold.predicted.get(place).map_or(before, |predicted| predicted.carried_velocity(before));
            for axis in 0..3 {
                total[axis][at] = start[axis] - free[axis];
                let off = before[axis] - free[axis];
                outer[0] += (masses[place] * off * off).to_f64();
                outer[1] += (masses[place] * before[axis] * before[axis]).to_f64();
                outer[2 + axis] += (masses[place] * before[axis]).to_f64();
            }
            outer[5] += masses[place].to_f64();
        }
        self.shared.outer.set(chunk.number, outer);
        self.set_trial_state(chunk, &total);
    }

    /// Places and velocities with the changes of velocity so far.
    fn set_trial_state(&self, chunk: &Chunk, total: &[&mut [T]; 3]) {
        // SAFETY: only this chunk's places; others read after a barrier.
        let mut moved = unsafe { self.shared.moved.write::<6>(&chunk.part) };
        let (base, (places, velocities)) = (self.bases(&chunk.part), moved.split_at_mut(3));
        for axis in 0..3 {
            let n = chunk.part.len();
            let (before, free, total) = (&base[axis][..n], &base[3 + axis][..n], &total[axis][..n]);
            let (place, velocity) = (&mut places[axis][..n], &mut velocities[axis][..n]);
            for at in 0..n {
                velocity[at] = free[at] + total[at];
                place[at] = before[at] + self.h * velocity[at];
            }
        }
    }

    /// Blocks, diagonals and springs' impulses of a chunk.
    pub fn set_up(&mut self, chunk: &Chunk) {
        let (shared, table, part) = (self.shared, &self.multigrid.tables[0], chunk.part.clone());
        let here = &shared.levels[0];
        // SAFETY: what was moved was written before a barrier; chunks do not overlap.
        unsafe {
            let kernel = SetUp {
                part: part.clone(),
                table,
                body: chunk.body,
                rest: &self.primal.rest,
                material: &self.primal.material,
                stiff: &self.scratch.stiff,
                moved: shared.moved.read(),
                mass: self.masses(),
                inverse_mass: &self.worker.nodes.inverse_mass,
                predicted: if self.colliders.is_empty() { &[] } else { shared.predicted.read() },
                right: shared.right.write(&part),
                inverse: here.inverse.write(&part),
                own: here.own.write(&part),
                blocks: here.blocks.write(slots_of(table, &part, FINE)),
                elements: self.set_up_elements(&part),
            };
            self.worker.nodes.level.run(kernel);
        }
    }

    /// Finds the surface that will hold each node, as far as what springs did in the last sub-step tells.
    pub fn predict_contacts(&self, part: &Range<usize>) {
        if self.colliders.is_empty() {
            return;
        }
        let (nodes, h) = (self.worker.nodes, self.worker.substep.h);
        let reach = T::from_f64(reach(self.worker.substep.gravity, h.to_f64()));
        // SAFETY: chunks do not overlap; what is remembered is written after a barrier.
        let (change, predictions, touched) = unsafe {
            (
                self.shared.change.read(),
                self.shared.predicted.write(part.clone()),
                self.shared.collider.write(part.clone()),
            )
        };
        for ((predicted, collider), place) in predictions.iter_mut().zip(touched).zip(part.clone()) {
            let approach = Approach {
                position: self.worker.old_position(place),
                free: self.free_velocity(place),
                solver_change: change.at(place),
                reach,
                h,
            };
            let free = nodes.inverse_mass[place] > T::ZERO;
            (*predicted, *collider) = match self.mesh_cache.filter(|_| free) {
                Some(cache) => cache.predict(self.colliders.at(place), place, &approach),
                None => (PredictedContact::FREE, 0),
            };
        }
    }

    /// The velocity of a place without springs, which waits where the state after will be.
    pub fn free_velocity(&self, place: usize) -> [T; 3] {
        // SAFETY: written before a barrier, and written over after another.
        unsafe {
            let [x, y, z, ..] = self.worker.next();
            [x.read()[place], y.read()[place], z.read()[place]]
        }
    }

    /// Where the iteration starts: in the first Newton step from what springs did in the last sub-step, times what brings it
    /// nearest to the solution in the norm of the system.
    pub fn start(&mut self, first: bool) {
        let warm = first && self.primal.ice.warm_start;
        self.each(0, |worker, chunk| worker.leave_right(&chunk.part, warm));
        self.worker.synchronise();
        self.weigh_points();
        self.distribute_residuals();
        if warm {
            self.average_points(&self.shared.levels[0].t);
            self.start_warm();
        }
    }

    /// The right side: springs' impulse and inertia. If `warm`, in `t` what would do if springs did as in the last sub-step.
    fn leave_right(&self, part: &Range<usize>, warm: bool) {
        let (shared, here, hold) = (self.shared, &self.shared.levels[0], self.hold(0));
        let masses = self.masses();
        // SAFETY: only this chunk's places.
        let (mut r, mut t, right, total, change) = unsafe {
            for columns in [shared.x.write::<3>(part), shared.p.write(part), shared.s.write(part)] {
                columns.into_iter().for_each(|column| column.fill(T::ZERO));
            }
            let vectors = (here.r.write::<3>(part), here.t.write::<3>(part));
            (vectors.0, vectors.1, shared.right.read(), shared.total.read(), shared.change.read())
        };
        for first in part.clone().step_by(LANES) {
            let (mut residual, mut off) = (right.lanes(first), total.lanes::<3>(first));
            for (lane, predicted) in
                hold.predicted.get(first..first + LANES).unwrap_or(&[]).iter().enumerate()
            {
                let friction = predicted.friction_change();
                (0..3).for_each(|axis| off[axis][lane] -= friction[axis]);
            }
            for lane in 0..LANES {
                let [impulse, off] = [&residual, &off].map(|lanes| [0, 1, 2].map(|axis| lanes[axis][lane]));
                let right = right_side(impulse, masses[first + lane], off);
                (0..3).for_each(|axis| residual[axis][lane] = right[axis]);
            }
            hold.filtered(first, &mut residual);
            store(&mut r, first - part.start, &residual);
            if warm {
                let mut before = self.changes(&change, first);
                for axis in 0..3 {
                    for lane in 0..LANES {
                        before[axis][lane] -= off[axis][lane];
                    }
                }
                hold.filtered(first, &mut before);
                store(&mut t, first - part.start, &before);
            }
        }
        self.begin(0, part);
    }

    /// From what springs did in the last sub-step, in `t`.
    fn start_warm(&mut self) {
        self.take_back(0, &self.shared.levels[0].t);
        self.each(0, |worker, chunk| {
            let here = &worker.shared.levels[0];
            // What is left is needed: its product goes to `z`, which is found again.
            worker.note_products(chunk, worker.apply(chunk, &here.t, &here.r, &here.z));
        });
        self.worker.synchronise();
        let share = |[along, curvature]: [f64; 2]| T::from_f64(warm_start_factor(along, curvature));
        let shares: Vec<T> = self.product_sums().into_iter().map(share).collect();
        self.each(0, |worker, chunk| {
            let (here, part) = (&worker.shared.levels[0], &chunk.part);
            // SAFETY: only this chunk's places.
            let (x, r, t, z) = unsafe {
                (
                    worker.shared.x.write::<3>(part),
                    here.r.write::<3>(part),
                    here.t.write::<3>(part),
                    here.z.write::<3>(part),
                )
            };
            let share = shares[chunk.body];
            for axis in 0..3 {
                for i in 0..part.len() {
                    x[axis][i] += share * t[axis][i];
                    r[axis][i] -= share * z[axis][i];
                }
            }
            worker.begin(0, part);
        });
        self.worker.synchronise();
        self.distribute_residuals();
    }

    /// Iterates until all systems are solved. If `may_be_met` the first products tell which bodies' equations are met well enough as
    /// they are: nothing is changed of those.
    pub fn iterate(&mut self, may_be_met: bool) {
        while !self.worker.is_stopped() && self.scratch.bodies.iter().any(|body| !body.done) {
            self.cycle(0);
            self.average_points(&self.shared.levels[0].t);
            self.take_back(0, &self.shared.levels[0].t);
            self.each(0, |worker, chunk| {
                let here = &worker.shared.levels[0];
                worker.note_products(chunk, worker.apply(chunk, &here.t, &here.r, &here.z));
            });
            self.worker.synchronise();
            self.find_steps(may_be_met);
            self.each(0, Self::advance);
            self.worker.synchronise();
            self.distribute_residuals();
            self.judge();
        }
    }

    /// The next step of each body.
    fn find_steps(&mut self, may_be_met: bool) {
        let sums = self.product_sums();
        let Scratch { bodies, outer, .. } = &mut *self.scratch;
        for ((body, [gamma, delta]), &mut [off, squares, x, y, z, mass]) in
            bodies.iter_mut().zip(sums).zip(outer)
        {
            if body.done {
                continue;
            }
            if may_be_met && body.iterations == 0 {
                body.met = !leaves_much(gamma, motion([off, squares], [x, y, z], mass));
                body.done = body.met;
                if body.met {
                    continue;
                }
            }
            if body.all == 0 {
                body.whole = gamma.max(off);
            }
            body.error = gamma;
            match body.conjugate.step(gamma, delta) {
                Some(step) => {
                    (body.step, body.iterations, body.all) = (step, body.iterations + 1, body.all + 1);
                }
                // Nothing is left, or what is left is no number.
                None => body.done = true,
            }
        }
    }

    /// Which bodies are done. The step that was found with the error is taken all the same.
    fn judge(&mut self) {
        let ice = &self.primal.ice;
        for body in &mut self.scratch.bodies {
            body.done |= body.is_solved(ice.tolerance) || body.iterations == ice.max_iterations;
        }
    }

    /// What iterations have left of each body's momentum. Springs answer nothing to a velocity that is the same everywhere, so
    /// where nothing holds the body that is exactly the rest of the solution in this direction: momentum is kept at any
    /// tolerance.
    pub fn find_drifts(&mut self) {
        self.each_of_all(0, |worker, chunk| {
            // SAFETY: only this chunk's places.
            let residual = unsafe { worker.shared.levels[0].r.read() };
            let (hold, masses) = (worker.hold(0), worker.masses());
            let mut sums = [0.0; 5];
            for place in chunk.part.clone() {
                let mass = masses[place];
                let moves = hold.inverse_mass[place] > T::ZERO
                    && hold.predicted.get(place).is_none_or(|predicted| !predicted.in_contact());
                let [x, y, z] = residual.at::<3>(place).map(T::to_f64);
                let held = f64::from(u8::from(mass > T::ZERO && !moves));
                for (sum, number) in sums.iter_mut().zip([x, y, z, mass.to_f64(), held]) {
                    *sum += number;
                }
            }
            worker.shared.residual.set(chunk.number, sums);
        });
        self.worker.synchronise();
        let sums = self.sums(&self.shared.residual);
        let Scratch { bodies, joined, .. } = &mut *self.scratch;
        for (index, (body, [x, y, z, mass, held])) in bodies.iter_mut().zip(sums).enumerate() {
            let free = held == 0.0 && mass > 0.0 && !joined.is_held(index);
            body.drift = if free && !body.met { [x / mass, y / mass, z / mass] } else { [0.0; 3] };
        }
    }

    fn advance(&mut self, chunk: &Chunk) {
        let (shared, part, here) = (self.shared, &chunk.part, &self.shared.levels[0]);
        let (alpha, beta) = self.scratch.bodies[chunk.body].step;
        // SAFETY: only this chunk's places.
        let kernel = unsafe {
            Advance {
                alpha: T::from_f64(alpha),
                beta: T::from_f64(beta),
                x: shared.x.write(part),
                r: here.r.write(part),
                p: shared.p.write(part),
                s: shared.s.write(part),
                z: here.t.write(part).map(|column| &*column),
                w: here.z.write(part).map(|column| &*column),
            }
        };
        self.worker.nodes.level.run(kernel);
        self.begin(0, part);
    }

    /// The system times a vector, into `out`; returns the vector times `other`, and times the product.
    fn apply(
        &self,
        chunk: &Chunk,
        vector: &crate::solvers::implicit::cpu::Columns<T>,
        other: &crate::solvers::implicit::cpu::Columns<T>,
        out: &crate::solvers::implicit::cpu::Columns<T>,
    ) -> [f64; 2] {
        // SAFETY: vectors were found before a barrier; chunks do not overlap.
        let kernel = unsafe {
            Apply {
                part: chunk.part.clone(),
                operator: self.operator(0, chunk.body),
                hold: self.hold(0),
                vector: vector.read(),
                other: other.read(),
                out: out.write(&chunk.part),
            }
        };
        self.worker.nodes.level.run(kernel)
    }

    /// Takes a Newton step: changes of velocity, from where the next one starts, and the impulses that springs then have.
    pub fn take(&self, chunk: &Chunk) {
        let (shared, part, body) = (self.shared, &chunk.part, &self.scratch.bodies[chunk.body]);
        if body.met {
            return;
        }
        self.note_impulses(chunk);
        // SAFETY: `x` was found before a barrier; of the others only this chunk's places.
        let (total, x) = unsafe { (shared.total.write::<3>(part), shared.x.read()) };
        for first in part.clone().step_by(LANES) {
            let (at, step) = (first - part.start, x.lanes::<3>(first));
            for axis in 0..3 {
                let drift = T::from_f64(body.drift[axis]);
                for lane in 0..LANES {
                    total[axis][at + lane] = total[axis][at + lane] + drift + step[axis][lane];
                }
            }
        }
        self.set_trial_state(chunk, &total);
    }

    /// Impulses of springs [N s] on nodes that something holds, as the system has them: with those all of momentum is there,
    /// whatever a Newton step leaves.
    fn note_impulses(&self, chunk: &Chunk) {
        let (shared, part) = (self.shared, &chunk.part);
        // SAFETY: as in `take`.
        let (mut impulse, right, x) =
            unsafe { (shared.impulse.write::<3>(part), shared.right.read(), shared.x.read()) };
        let (predicted, inverse_mass) = (self.hold(0).predicted, &self.worker.nodes.inverse_mass);
        let edges = Operator { own: Own::None, ..self.operator(0, chunk.body) };
        for first in part.clone().step_by(LANES) {
            let held = predicted.get(first..first + LANES).unwrap_or(&[]);
            let pinned = inverse_mass[first..first + LANES].iter().any(|&w| w <= T::ZERO);
            if pinned || self.is_sewn() || held.iter().any(PredictedContact::in_contact) {
                let (product, _) = edges.slice::<FINE>(first / LANES, &x);
                let mut given: [[T; LANES]; 3] = right.lanes(first);
                for axis in 0..3 {
                    for lane in 0..LANES {
                        given[axis][lane] -= product[axis][lane];
                    }
                }
                store(&mut impulse, first - part.start, &given);
            }
        }
    }

    /// What springs change of each node's velocity: what was solved for, and on nodes that a surface holds, what they press.
    pub fn note_changes(&self, chunk: &Chunk) {
        let (shared, part) = (self.shared, &chunk.part);
        // SAFETY: only this chunk's places.
        let (change, total, impulse) =
            unsafe { (shared.change.write::<3>(part), shared.total.read(), shared.impulse.read()) };
        let (predicted, inverse_mass) = (self.hold(0).predicted, &self.worker.nodes.inverse_mass);
        for (at, place) in part.clone().enumerate() {
            let mut after: [T; 3] = total.at(place);
            let contact = predicted.get(place).filter(|predicted| predicted.in_contact());
            let whole = self.keep_rate(place, &mut after, contact);
            if let Some(predicted) = contact {
                let springs = scale(impulse.at(place), whole * inverse_mass[place]);
                after = velocity_change(predicted, after, springs);
            }
            for axis in 0..3 {
                change[axis][at] = after[axis];
            }
        }
    }

    pub fn report(&mut self) {
        let (report, mut capped) = (&mut self.scratch.report, false);
        for body in &self.scratch.bodies {
            report.residual = report.residual.max(residual_fraction(body.error, body.whole).sqrt());
            report.iterations = report.iterations.max(body.all);
            capped |= !body.is_solved(self.primal.ice.tolerance);
        }
        report.capped += u32::from(capped);
        report.active_fraction = 1.0;
    }

    /// Whether the system of a body needs no more iterations.
    pub fn is_done(&self, body: usize) -> bool {
        self.scratch.bodies.get(body).is_some_and(|body| body.done)
    }

    /// The sums of each body and what it is joined with: chunks in their order, then bodies.
    fn sums<const N: usize>(&self, chunks: &Numbers<N>) -> Vec<[f64; N]> {
        let of_body = |own: &Range<usize>| {
            let all = own.clone().map(|chunk| chunks.get(chunk));
            all.fold([0.0; N], |sum, one| std::array::from_fn(|i| sum[i] + one[i]))
        };
        self.scratch.joined.together(self.multigrid.tables[0].chunks_of.iter().map(of_body).collect())
    }

    /// Those of products.
    pub fn product_sums(&self) -> Vec<[f64; 2]> {
        self.sums(&self.shared.products)
    }

    /// Sums up the motion of each body and what it is joined with.
    pub fn sum_motion(&mut self) {
        self.scratch.outer = self.sums(&self.shared.outer);
    }

    /// Notes the products of a chunk of its share.
    pub fn note_products(&self, chunk: &Chunk, products: [f64; 2]) {
        self.shared.products.set(chunk.number, products);
    }
}

impl CgState {
    /// Of a body, which may rest.
    pub fn new(rests: bool) -> Self {
        Self { met: rests, done: rests, ..Self::default() }
    }

    /// Before a further Newton step.
    pub fn again(self) -> Self {
        let Self { whole, error, all, met, .. } = self;
        Self { whole, error, all, met, done: met, ..Self::default() }
    }

    fn is_solved(&self, tolerance: f64) -> bool {
        is_solved(self.error, self.whole, tolerance * tolerance)
    }
}
