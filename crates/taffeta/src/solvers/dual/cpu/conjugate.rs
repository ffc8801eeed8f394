//! Conjugate gradients on the systems of all bodies at once; each system has its own steps. An iteration is a pass
//! over nodes, a pass over rows, and an update of vectors. Workers synchronise after each of them. What each pass does on a
//! body with bands is in `bands.rs`.

use crate::contact::colliders::predicted_contact::{Approach, PredictedContact, reach};
use crate::real::{Real, scale};
use crate::solvers::dual::cpu::bands::BandChunk;
use crate::solvers::dual::cpu::kernels::{
    Advance, Along, Apply, Combine, GatherConstraintForces, Multiply, Product, SetUpRows,
};
use crate::solvers::dual::cpu::layout::Chunk;
use crate::solvers::dual::cpu::{Quad, SolveWorker};
use crate::solvers::dual::distance::{
    Conjugate, Softness, is_left, limit, residual_fraction, warm_start_factor,
};
use std::ops::Range;

/// The state of conjugate gradients on a body's system.
#[derive(Clone, Copy, Debug, Default)]
pub struct CgState {
    conjugate: Conjugate<f64>,
    /// Squared residual at which it has converged, and that of the right side.
    limit: f64,
    right: f64,
    /// Squared residual.
    gamma: f64,
    iterations: u32,
    done: bool,
    /// Length of the next step, and the factor of the last direction in it.
    step: (f64, f64),
}

/// A vector that is multiplied by the matrix.
#[derive(Clone, Copy)]
enum Vector {
    X,
    R,
    S,
}

/// A worker's part of the vectors.
struct Vectors<'a, T> {
    rows: &'a mut [Quad<T>],
    scale: &'a mut [T],
    offset: &'a mut [T],
    x: &'a mut [T],
    right: &'a mut [T],
    r: &'a mut [T],
    p: &'a mut [T],
    s: &'a mut [T],
    w: &'a mut [T],
    row_forces: &'a mut [Quad<T>],
}

/// Some nodes of the system, and the constraint forces at them.
struct NodeLists<'a, T> {
    spans: &'a [[u32; 2]],
    entries: &'a [u32],
    row_forces: &'a [Quad<T>],
    places: &'a [u32],
    response: &'a mut [Quad<T>],
}

impl<'w, T: Real> SolveWorker<'w, '_, T> {
    /// Solves for the forces of all constraints.
    pub fn solve(&mut self) {
        if self.solve.adaptive {
            self.compact();
        } else {
            self.cut_all();
        }
        if self.scratch.layout.count > 0 {
            self.soften();
            self.scratch.bodies.clear();
            self.each(self.scratch.layout.rows.len(), Self::set_up_rows);
            self.predict_contacts();
            self.start();
            if self.solve.solver.ice.warm_start {
                self.start_warm();
            }
            self.iterate();
            self.store_multipliers();
        }
        self.report();
    }

    /// Predicts the contacts of nodes.
    fn predict_contacts(&mut self) {
        if self.colliders.is_empty() {
            return;
        }
        self.worker.synchronise();
        self.each(self.scratch.layout.nodes.len(), Self::predict_contacts_of);
    }

    /// The residual without constraint forces.
    fn start(&mut self) {
        let rows = self.scratch.layout.rows.len();
        let warm = self.solve.solver.ice.warm_start;
        if self.solve.adaptive {
            self.worker.synchronise();
        }
        self.each(self.scratch.layout.nodes.len(), Self::free_response);
        self.worker.synchronise();
        self.each(rows, |worker, chunk| {
            if let Some(bands) = worker.banded(&worker.scratch.layout.rows[chunk]) {
                return worker.note_sum(chunk, 0, bands.start(warm));
            }
            let part = worker.rows_of(chunk);
            let Vectors { right, r, p, s, .. } = worker.vectors(&part);
            r.copy_from_slice(right);
            p.fill(T::ZERO);
            s.fill(T::ZERO);
            // A vector of zeros: the part of the velocities remains.
            worker.apply_to(&part, Vector::S);
            let Vectors { rows, x, r, w, row_forces, .. } = worker.vectors(&part);
            let level = worker.worker.nodes.level;
            if !warm {
                // These forces have predicted the contacts.
                x.fill(T::ZERO);
            }
            worker.note_sum(chunk, 0, level.run(Combine { to: r, factor: T::ONE, other: w }));
            level.run(Along { rows, vector: if warm { x } else { r }, row_forces });
        });
        self.worker.synchronise();
        let tolerance = self.solve.solver.ice.tolerance;
        for body in 0..self.solve.list.bodies.len() {
            let [right, noise, _] = self.body_sums(body);
            let limit = limit(tolerance * tolerance, right, noise);
            self.scratch.bodies.push(CgState { limit, right, ..CgState::default() });
        }
    }

    /// The residual with the constraint forces of the last sub-step, scaled so that they are closest to the solution
    /// in the norm of the system. Unscaled, the forces of a sub-step that was cut short can be worse than none.
    fn start_warm(&mut self) {
        self.each(self.scratch.layout.nodes.len(), Self::respond);
        self.worker.synchronise();
        self.each(self.scratch.layout.rows.len(), |worker, chunk| {
            let [along, curvature] = if let Some(bands) = worker.banded(&worker.scratch.layout.rows[chunk]) {
                bands.warmth()
            } else {
                let part = worker.rows_of(chunk);
                let [_, curvature] = worker.apply_to(&part, Vector::X);
                let Vectors { x, r, .. } = worker.vectors(&part);
                [worker.worker.nodes.level.run(Product { a: x, b: r }), curvature]
            };
            worker.note_sum(chunk, 0, along);
            worker.note_sum(chunk, 2, curvature);
        });
        self.worker.synchronise();
        let factor = |[along, _, curvature]: [f64; 3]| T::from_f64(warm_start_factor(along, curvature));
        let factors: Vec<T> =
            (0..self.scratch.bodies.len()).map(|body| factor(self.body_sums(body))).collect();
        self.each(self.scratch.layout.rows.len(), |worker, chunk| {
            let Chunk { body, part } = worker.scratch.layout.rows[chunk].clone();
            let (level, factor) = (worker.worker.nodes.level, factors[body]);
            if let Some(bands) = worker.banded(&worker.scratch.layout.rows[chunk]) {
                return bands.scale_start(factor);
            }
            let Vectors { rows, x, r, w, row_forces, .. } = worker.vectors(&part);
            level.run(Multiply { vector: x, factor });
            level.run(Combine { to: r, factor: -factor, other: w });
            level.run(Along { rows, vector: r, row_forces });
        });
        self.worker.synchronise();
    }

    fn iterate(&mut self) {
        let (rows, nodes) = (self.scratch.layout.rows.len(), self.scratch.layout.nodes.len());
        loop {
            self.each(nodes, Self::respond);
            self.worker.synchronise();
            self.each(rows, |worker, chunk| {
                let of = &worker.scratch.layout.rows[chunk];
                if !worker.is_done(of.body) {
                    let [gamma, delta] = match worker.banded(of) {
                        Some(bands) => bands.apply(),
                        None => worker.apply_to(&of.part, Vector::R),
                    };
                    worker.note_sum(chunk, 0, gamma);
                    worker.note_sum(chunk, 2, delta);
                }
            });
            self.worker.synchronise();
            if self.update_state() || self.worker.is_stopped() {
                break;
            }
            self.each(rows, Self::advance);
            self.worker.synchronise();
        }
    }

    /// Finds the next step of each body. Returns whether all have converged.
    fn update_state(&mut self) -> bool {
        let most = self.solve.solver.ice.max_iterations;
        for index in 0..self.scratch.bodies.len() {
            if self.is_done(index) {
                continue;
            }
            let [gamma, _, delta] = self.body_sums(index);
            let body = &mut self.scratch.bodies[index];
            body.gamma = gamma;
            body.done = !is_left(gamma, body.limit, body.iterations, most);
            if !body.done {
                match body.conjugate.step(gamma, delta) {
                    Some(step) => (body.step, body.iterations) = (step, body.iterations + 1),
                    None => body.done = true,
                }
            }
        }
        self.scratch.bodies.iter().all(|body| body.done)
    }

    /// Stores the constraint forces, and their force along each row.
    fn store_multipliers(&mut self) {
        self.each(self.scratch.layout.rows.len(), Self::store_chunk);
        self.worker.synchronise();
        if self.solve.bands.iter().any(Option::is_some) {
            self.each(self.scratch.layout.nodes.len(), |worker, chunk| {
                if let Some(bands) = worker.banded(&worker.scratch.layout.nodes[chunk]) {
                    bands.gather(&[], false);
                }
            });
            self.worker.synchronise();
        }
    }

    fn store_chunk(&mut self, chunk: usize) {
        if let Some(bands) = self.banded(&self.scratch.layout.rows[chunk]) {
            return bands.store();
        }
        let part = self.rows_of(chunk);
        let Vectors { rows, scale, offset, x, w, row_forces, .. } = self.vectors(&part);
        // SAFETY: rows were listed before a barrier; different rows are different constraints, whose forces are read in the
        // next sub-step.
        unsafe {
            for (i, &constraint) in self.shared.which.read()[part].iter().enumerate() {
                *self.shared.multiplier.item(constraint as usize) = scale[i] * x[i];
            }
        }
        w.copy_from_slice(x);
        if self.solve.adaptive {
            self.worker.nodes.level.run(Combine { to: w, factor: -T::ONE, other: offset });
        }
        self.worker.nodes.level.run(Along { rows, vector: w, row_forces });
    }

    fn report(&mut self) {
        let (report, layout) = (&mut self.scratch.report, &self.scratch.layout);
        let mut capped = false;
        for body in self.scratch.bodies.iter().take(if layout.count > 0 { usize::MAX } else { 0 }) {
            let tolerance = self.solve.solver.ice.tolerance;
            let left = residual_fraction(body.gamma, body.right, body.limit, tolerance * tolerance);
            report.residual = report.residual.max(left.sqrt());
            report.iterations = report.iterations.max(body.iterations);
            capped |= body.gamma > body.limit;
        }
        report.capped += u32::from(capped);
        let fraction = layout.count as f64 / self.solve.list.len() as f64;
        report.active_fraction = report.active_fraction.max(fraction);
    }

    /// The softness of each material in this sub-step.
    fn soften(&mut self) {
        let Self { solve, scratch, worker, .. } = self;
        let (ice, acad, h) = (&solve.solver.ice, &solve.solver.acad, worker.substep.h.to_f64());
        scratch.softness.clear();
        scratch.softness.extend(solve.list.materials.iter().map(|&[k, d]| {
            let softness = if solve.adaptive {
                Softness::stiff(acad.epsilon, acad.form, h)
            } else {
                Softness::spring(k, d, ice.epsilon, ice.form, h)
            };
            softness.rounded()
        }));
    }

    fn set_up_rows(&mut self, chunk: usize) {
        let (old, inverse_mass) = (self.worker.old(), &self.worker.nodes.inverse_mass);
        if let Some(bands) = self.banded(&self.scratch.layout.rows[chunk]) {
            let noise = bands.set_up(&self.scratch.softness, [old[0], old[1], old[2]], inverse_mass);
            return self.note_sum(chunk, 1, noise);
        }
        let part = self.rows_of(chunk);
        let Vectors { rows, scale, offset, x, right, row_forces, .. } = self.vectors(&part);
        let (solve, adaptive) = (self.solve, self.solve.adaptive);
        let target = T::from_f64(1.0 + solve.solver.acad.target);
        // SAFETY: listed before a barrier; pulls are those of the last sub-step.
        let (which, multiplier) = unsafe { (&self.shared.which.read()[part], self.shared.multiplier.read()) };
        let noise = self.worker.nodes.level.run(SetUpRows {
            which,
            all_ends: &solve.list.ends,
            rest: &solve.rest,
            material: &solve.list.material,
            softness: &self.scratch.softness,
            inverse_mass,
            old,
            springs: adaptive.then_some((&solve.list.materials[..], target)),
            multiplier,
            rows: &mut *rows,
            scale,
            right,
            x: &mut *x,
            offset: &mut *offset,
        });
        self.note_sum(chunk, 1, noise);
        if adaptive {
            self.list_ends(which, chunk);
        }
        // For the next pass: springs are taken out of the force, or contacts are predicted.
        let vector = if adaptive { offset } else { x };
        self.worker.nodes.level.run(Along { rows, vector, row_forces });
    }

    /// Lists the nodes at the ends of a chunk's rows.
    fn list_ends(&self, which: &[u32], chunk: usize) {
        // SAFETY: nodes were listed before a barrier; rows of chunks are different.
        let (node_of, ends) =
            unsafe { (self.shared.node_of.read(), self.shared.ends.write(self.rows_of(chunk))) };
        for (ends, &constraint) in ends.iter_mut().zip(which) {
            *ends = self.solve.list.ends[constraint as usize].map(|place| node_of[place as usize]);
        }
    }

    /// Predicts the contact of each node from the constraint forces of the last sub-step.
    fn predict_contacts_of(&mut self, chunk: usize) {
        let of = self.scratch.layout.nodes[chunk].clone();
        if let Some(bands) = self.banded(&of) {
            bands.gather(&self.worker.nodes.inverse_mass, false);
            let (mut nodes, inside) = (bands.own_nodes(), bands.real_nodes());
            let first = bands.bands.first + inside.start;
            let predicted = self.predicted(first..first + inside.len());
            for (i, (predicted, collider)) in predicted.0.iter_mut().zip(predicted.1).enumerate() {
                (*predicted, *collider) = self.predict(first + i, nodes.response.each_ref().map(|v| v[i]));
                let [x, y, z] = predicted.normal;
                nodes
                    .contact
                    .iter_mut()
                    .zip([x, y, z, predicted.slides])
                    .for_each(|(to, number)| to[i] = number);
            }
            return;
        }
        self.gather_constraint_forces(&of.part, false);
        let NodeLists { places, response, .. } = self.node_lists(&of.part);
        let (predictions, colliders) = self.predicted(of.part);
        for (((response, predicted), collider), &place) in
            response.iter().zip(predictions).zip(colliders).zip(places)
        {
            let [x, y, z, _] = response.0;
            (*predicted, *collider) = self.predict(place as usize, [x, y, z]);
        }
    }

    /// The contact of a place, whose velocity the constraint forces change at a rate of -`response`, and its collider.
    fn predict(&self, place: usize, response: [T; 3]) -> (PredictedContact<T>, u32) {
        let h = self.worker.substep.h;
        let free = self.worker.nodes.inverse_mass[place] > T::ZERO;
        let Some(cache) = self.mesh_cache.filter(|_| free) else { return (PredictedContact::FREE, 0) };
        let approach = Approach {
            position: self.worker.old_position(place),
            free: self.free_velocity(place),
            solver_change: scale(response, -h),
            reach: T::from_f64(reach(self.worker.substep.gravity, h.to_f64())),
            h,
        };
        cache.predict(self.colliders.at(place), place, &approach)
    }

    /// The velocity of a place without constraints. It is stored where the state after will be.
    fn free_velocity(&self, place: usize) -> [T; 3] {
        // SAFETY: written before a barrier, and written over after another.
        [0, 1, 2].map(|axis| unsafe { self.worker.next()[axis].read() }[place])
    }

    /// By node: the velocity without constraints, divided by the sub-step. Springs that constraints replace are taken
    /// out.
    fn free_response(&mut self, chunk: usize) {
        let of = self.scratch.layout.nodes[chunk].clone();
        if let Some(bands) = self.banded(&of) {
            let (nodes, inside) = (bands.own_nodes(), bands.real_nodes());
            let first = bands.bands.first + inside.start;
            let [x, y, z] = nodes.response;
            for (i, predicted) in self.predicted(first..first + inside.len()).0.iter().enumerate() {
                [x[i], y[i], z[i]] = self.free_rate(first + i, predicted, [T::ZERO; 3]);
            }
            // What fills up the last vector keeps nothing of what was before, which need not be a number.
            [x, y, z].into_iter().for_each(|column| column[inside.len()..].fill(T::ZERO));
            return;
        }
        if self.solve.adaptive {
            self.gather_constraint_forces(&of.part, false);
        }
        let NodeLists { places, response, .. } = self.node_lists(&of.part);
        for ((response, predicted), &place) in response.iter_mut().zip(self.predicted(of.part).0).zip(places)
        {
            let [x, y, z, _] = if self.solve.adaptive { response.0 } else { [T::ZERO; 4] };
            let [x, y, z] = self.free_rate(place as usize, predicted, [x, y, z]);
            *response = Quad([x, y, z, T::ZERO]);
        }
    }

    /// The velocity of a place without constraints, divided by the sub-step, plus the rate that springs had.
    fn free_rate(&self, place: usize, predicted: &PredictedContact<T>, [x, y, z]: [T; 3]) -> [T; 3] {
        let (h, [u, v, w]) = (self.worker.substep.h, self.free_velocity(place));
        let rate = [u / h + x, v / h + y, w / h + z];
        if self.colliders.is_empty() { rate } else { predicted.rate(rate, h) }
    }

    /// By node: the response to the forces of a vector.
    fn respond(&mut self, chunk: usize) {
        let (of, in_contact) = (&self.scratch.layout.nodes[chunk], !self.colliders.is_empty());
        if self.is_done(of.body) {
            return;
        }
        match self.banded(of) {
            Some(bands) => bands.gather(&self.worker.nodes.inverse_mass, in_contact),
            None => self.gather_constraint_forces(&of.part, in_contact),
        }
    }

    /// The response of some nodes to constraint forces; `held` says whether predicted contacts act.
    fn gather_constraint_forces(&self, nodes: &Range<usize>, held: bool) {
        let NodeLists { spans, entries, row_forces, places, response } = self.node_lists(nodes);
        self.worker.nodes.level.run(GatherConstraintForces {
            spans,
            entries,
            row_forces,
            places,
            inverse_mass: &self.worker.nodes.inverse_mass,
            predicted: if held { self.predicted(nodes.clone()).0 } else { &[] },
            out: response,
        });
    }

    /// Some nodes of the system; callers take each only once at a time.
    fn node_lists(&self, nodes: &Range<usize>) -> NodeLists<'w, T> {
        let shared = self.shared;
        // SAFETY: listed before a barrier, as row forces were found; nodes of chunks are different, and others read
        // `response` after a barrier.
        unsafe {
            NodeLists {
                spans: &shared.spans.read()[nodes.clone()],
                entries: shared.entries.read(),
                row_forces: shared.row_forces.read(),
                places: &shared.places.read()[nodes.clone()],
                response: shared.response.write(nodes.clone()),
            }
        }
    }

    /// The predicted contacts of some nodes, and their colliders; callers take each only once at a time.
    fn predicted(&self, nodes: Range<usize>) -> (&'w mut [PredictedContact<T>], &'w mut [u32]) {
        // SAFETY: nodes of chunks are different.
        unsafe { (self.shared.predicted.write(nodes.clone()), self.shared.collider.write(nodes)) }
    }

    /// A chunk of a body with bands.
    fn banded(&self, chunk: &Chunk) -> Option<BandChunk<'w, T>> {
        let (solve, level) = (self.solve, self.worker.nodes.level);
        let bands = solve.bands[chunk.body].as_ref()?;
        Some(BandChunk { bands, state: &solve.band_state, level, nodes: chunk.part.clone() })
    }

    /// Multiplies one of the vectors by the matrix, into `w`.
    fn apply_to(&self, part: &Range<usize>, vector: Vector) -> [f64; 2] {
        let Vectors { rows, x, r, s, w, .. } = self.vectors(part);
        let vector = match vector {
            Vector::X => x,
            Vector::R => r,
            Vector::S => s,
        };
        // SAFETY: found before a barrier.
        let (ends, response) =
            unsafe { (&self.shared.ends.read()[part.clone()], self.shared.response.read()) };
        self.worker.nodes.level.run(Apply { rows, ends, response, vector, out: w })
    }

    fn advance(&mut self, chunk: usize) {
        let Chunk { body, part } = self.scratch.layout.rows[chunk].clone();
        if self.is_done(body) {
            return;
        }
        let (alpha, beta) = self.scratch.bodies[body].step;
        let (alpha, beta) = (T::from_f64(alpha), T::from_f64(beta));
        if let Some(bands) = self.banded(&self.scratch.layout.rows[chunk]) {
            return bands.advance(alpha, beta);
        }
        let Vectors { rows, x, r, p, s, w, row_forces, .. } = self.vectors(&part);
        self.worker.nodes.level.run(Advance { alpha, beta, x, r, p, s, w });
        self.worker.nodes.level.run(Along { rows, vector: r, row_forces });
    }

    /// Whether the system of a body has converged.
    fn is_done(&self, body: usize) -> bool {
        self.scratch.bodies.get(body).is_some_and(|body| body.done)
    }

    /// The sums of a body, its chunks in their order.
    fn body_sums(&self, body: usize) -> [f64; 3] {
        let sums = self.scratch.layout.of_body[body].clone().map(|chunk| self.shared.sums.get(chunk));
        sums.fold([0.0; 3], |[a, b, c], sum| [a + sum[0], b + sum[1], c + sum[2]])
    }

    /// Notes one of the sums of one of its chunks.
    fn note_sum(&self, chunk: usize, which: usize, sum: f64) {
        self.shared.sums.set_one(chunk, which, sum);
    }

    /// The rows of a chunk.
    fn rows_of(&self, chunk: usize) -> Range<usize> {
        self.scratch.layout.rows[chunk].part.clone()
    }

    /// Some rows of all vectors; callers take each only once at a time.
    fn vectors(&self, part: &Range<usize>) -> Vectors<'w, T> {
        let shared = self.shared;
        // SAFETY: chunks of rows do not overlap, and each is in one worker's share. Of these others read `row_forces` alone,
        // after a barrier.
        unsafe {
            Vectors {
                rows: shared.rows.write(part.clone()),
                scale: shared.scale.write(part.clone()),
                offset: shared.offset.write(part.clone()),
                x: shared.x.write(part.clone()),
                right: shared.right.write(part.clone()),
                r: shared.r.write(part.clone()),
                p: shared.p.write(part.clone()),
                s: shared.s.write(part.clone()),
                w: shared.w.write(part.clone()),
                row_forces: shared.row_forces.write(part.clone()),
            }
        }
    }

    /// Its chunks: an even part of all.
    fn mine(&self, chunks: usize) -> Range<usize> {
        self.worker.part(chunks)
    }

    /// Does `work` for each of its chunks.
    fn each(&mut self, chunks: usize, work: impl Fn(&mut Self, usize)) {
        for chunk in self.mine(chunks) {
            work(self, chunk);
        }
    }
}
