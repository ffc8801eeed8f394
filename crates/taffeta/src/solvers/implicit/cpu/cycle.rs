//! The multigrid cycle: an approximate solution of the system, as preconditioner.
//!
//! Source: Trottenberg, Oosterlee and Schüller, "Multigrid", 2001, §2.4: a V-cycle with one step of damped Jacobi (by blocks of
//! three) on the way down and one on the way up, which makes it symmetric. Every pass of a level is shared by all workers,
//! who meet after it; small levels are one worker's alone.

use crate::contact::triangles::cpu::TriangleContact;
use crate::real::Real;
use crate::solvers::implicit::cpu::ImplicitWorker;
use crate::solvers::implicit::cpu::columns::Columns;
use crate::solvers::implicit::cpu::kernels::{
    Begin, COARSE, FINE, Hold, Interpolate, Operator, Own, Residual, Smooth,
};
use crate::solvers::implicit::cpu::setup::{Coarsen, Finer, Restrict};
use crate::solvers::implicit::cpu::tables::{Chunk, Table};
use crate::solvers::implicit::implicit::LAST_PAIRS;
use crate::topology::LANES;
use std::ops::Range;

/// Which of a level's two approximations a pass reads.
#[derive(Clone, Copy, PartialEq)]
enum From {
    Z,
    T,
}

impl<'w, 'a, T: Real> ImplicitWorker<'w, 'a, T> {
    /// Finds blocks and diagonals of all levels but the finest, whose own were found before a barrier.
    pub fn coarsen(&mut self) {
        let multigrid = self.multigrid;
        self.couple_contacts();
        for level in 1..multigrid.tables.len() {
            if multigrid.elements.is_some() {
                self.each(level - 1, |worker, chunk| {
                    if let Some(elements) = multigrid.elements_of(chunk.body) {
                        worker.multiply_by_weights(elements, level - 1, chunk);
                    }
                });
                self.worker.synchronise();
            }
            self.each(level, |worker, chunk| {
                if let Some(elements) = worker.multigrid.elements_of(chunk.body) {
                    return worker.coarsen_elements(elements, level, chunk);
                }
                let part = &chunk.part;
                let (finer, here) = (&worker.shared.levels[level - 1], &worker.shared.levels[level]);
                let table = &worker.multigrid.tables[level];
                // SAFETY: the finer level was found before a barrier; chunks do not overlap.
                let kernel = unsafe {
                    let blocks = finer.blocks.read();
                    Coarsen {
                        part: part.clone(),
                        table,
                        finer: if level == 1 { Finer::Fine(blocks) } else { Finer::Coarse(blocks) },
                        finer_own: finer.own.read(),
                        inverse: here.inverse.write(part),
                        own: here.own.write(part),
                        blocks: here.blocks.write(slots_of(table, part, COARSE)),
                        contacts: worker.shares_of_contacts(level),
                    }
                };
                worker.worker.nodes.level.run(kernel);
            });
            self.worker.synchronise();
        }
    }

    /// From `z`, the first step of Jacobi's iteration on right side `r`, to an approximate solution in `t`.
    pub fn cycle(&mut self, level: usize) {
        if !self.alone && level > 0 && self.multigrid.tables[level].is_small() {
            if self.worker.index == 0 {
                self.alone = true;
                self.cycle(level);
                self.alone = false;
            }
            self.meet();
            return;
        }
        if level + 1 < self.multigrid.tables.len() {
            self.take_back(level, &self.shared.levels[level].z);
            self.each(level, |worker, chunk| worker.leave(level, chunk));
            self.meet();
            self.each(level + 1, |worker, chunk| worker.restrict(level + 1, chunk));
            self.settle(level);
            self.meet();
            self.cycle(level + 1);
            self.each(level, |worker, chunk| worker.interpolate(level, chunk));
            self.meet();
        } else {
            self.settle(level);
            self.meet();
        }
        self.take_back(level, &self.shared.levels[level].z);
        self.each(level, |worker, chunk| worker.smooth(level, &chunk.part, chunk.body, From::Z));
        self.meet();
    }

    /// What the first step leaves of the right side.
    fn leave(&self, level: usize, chunk: &Chunk) {
        if !self.multigrid.tables[level].goes_on[chunk.body] {
            return;
        }
        if level == 0 { self.leave_of::<FINE>(level, chunk) } else { self.leave_of::<COARSE>(level, chunk) }
    }

    fn leave_of<const C: usize>(&self, level: usize, chunk: &Chunk) {
        let here = &self.shared.levels[level];
        // SAFETY: `t` is not read before the next barrier; chunks do not overlap.
        let kernel = unsafe {
            Residual::<T, C> {
                part: chunk.part.clone(),
                operator: self.operator(level, chunk.body),
                hold: self.hold(level),
                right: here.r.read(),
                vector: here.z.read(),
                out: here.t.write(&chunk.part),
            }
        };
        self.worker.nodes.level.run(kernel);
    }

    /// Right side of a coarser level, and the first step there.
    fn restrict(&self, level: usize, chunk: &Chunk) {
        let (finer, here) = (&self.shared.levels[level - 1], &self.shared.levels[level]);
        // SAFETY: the finer `t` was found before a barrier; chunks do not overlap, and `r` is read by its own chunk alone.
        unsafe {
            let table = &self.multigrid.tables[level];
            let (part, finer) = (chunk.part.clone(), finer.t.read());
            self.worker.nodes.level.run(Restrict { part, table, finer, out: here.r.write(&chunk.part) });
        }
        self.begin(level, &chunk.part);
    }

    /// The first step of Jacobi's iteration.
    pub fn begin(&self, level: usize, part: &Range<usize>) {
        let here = &self.shared.levels[level];
        // SAFETY: only this chunk's places are read and written; its right side by nobody else before the next barrier.
        let kernel = unsafe {
            Begin {
                part: part.clone(),
                inverse: here.inverse.read(),
                right: here.r.write(part).map(|column| &*column),
                out: here.z.write(part),
            }
        };
        self.worker.nodes.level.run(kernel);
    }

    /// Bodies that end on a level with few nodes: they are nearly solved there, each by one worker, or together if contacts join
    /// them.
    fn settle(&mut self, level: usize) {
        if self.contacts_in_system().is_some() || self.multigrid.is_sewn {
            return self.settle_together(level);
        }
        let table = &self.multigrid.tables[level];
        for (body, part) in table.bodies.iter().enumerate().filter(|&(body, _)| table.ends[body]) {
            if (self.alone || body % self.worker.workers == self.worker.index) && !self.is_done(body) {
                for _ in 0..LAST_PAIRS {
                    self.smooth(level, part, body, From::Z);
                    self.smooth(level, part, body, From::T);
                }
            }
        }
    }

    /// The same on the last level, where contacts join bodies: each step reads what all of them have.
    fn settle_together(&mut self, level: usize) {
        if level + 1 < self.multigrid.tables.len() {
            return;
        }
        for from in [From::Z, From::T].repeat(LAST_PAIRS) {
            let here = &self.shared.levels[level];
            self.take_back(level, if from == From::Z { &here.z } else { &here.t });
            self.each(level, |worker, chunk| worker.smooth(level, &chunk.part, chunk.body, from));
            self.meet();
        }
    }

    /// Adds what the coarser level has found.
    fn interpolate(&self, level: usize, chunk: &Chunk) {
        let table = &self.multigrid.tables[level];
        if !table.goes_on[chunk.body] {
            return;
        }
        // SAFETY: the coarser `t` was found before a barrier; chunks do not overlap.
        let kernel = unsafe {
            Interpolate {
                part: chunk.part.clone(),
                parents: &table.parents,
                hold: self.hold(level),
                coarser: self.shared.levels[level + 1].t.read(),
                out: self.shared.levels[level].z.write(&chunk.part),
            }
        };
        self.worker.nodes.level.run(kernel);
    }

    /// A step of Jacobi's iteration from one approximation to the other.
    fn smooth(&self, level: usize, part: &Range<usize>, body: usize, from: From) {
        if level == 0 {
            self.smooth_of::<FINE>(level, part, body, from);
        } else {
            self.smooth_of::<COARSE>(level, part, body, from);
        }
    }

    fn smooth_of<const C: usize>(&self, level: usize, part: &Range<usize>, body: usize, from: From) {
        let here = &self.shared.levels[level];
        let (vector, out): (&Columns<T>, _) =
            if from == From::Z { (&here.z, &here.t) } else { (&here.t, &here.z) };
        // SAFETY: one is read, the other written, by chunks that do not overlap; or both by one worker alone.
        let kernel = unsafe {
            Smooth::<T, C> {
                part: part.clone(),
                operator: self.operator(level, body),
                inverse: here.inverse.read(),
                right: here.r.read(),
                vector: vector.read(),
                out: out.write(part),
            }
        };
        self.worker.nodes.level.run(kernel);
    }

    /// The matrix of a level, for a product.
    pub fn operator(&self, level: usize, body: usize) -> Operator<'_, T> {
        let contacts = self.contacts_in_system();
        let coarser = contacts.and(level.checked_sub(1)).map(|level| &self.primal.coarse_contacts[level]);
        let (table, here) = (&self.multigrid.tables[level], &self.shared.levels[level]);
        // SAFETY: blocks and diagonals were found before a barrier.
        unsafe {
            Operator {
                starts: &table.slots.starts,
                neighbour: &table.slots.neighbour,
                shifts: &table.slots.shifts[body],
                body: &table.bodies[body],
                blocks: here.blocks.read(),
                own: if level == 0 { Own::Mass(self.masses()) } else { Own::Block(here.own.read()) },
                coupled: self.multigrid.elements.as_ref().map(|elements| elements.coupled(level)),
                contacts: contacts.filter(|_| level == 0).map(TriangleContact::solved_blocks),
                coarse_contacts: coarser.map(|coarser| coarser.blocks()),
            }
        }
    }

    /// What holds the nodes of a level.
    pub fn hold(&self, level: usize) -> Hold<'_, T> {
        if level > 0 {
            return Hold { inverse_mass: &[], predicted: &[] };
        }
        // SAFETY: found before a barrier.
        let predicted = if self.colliders.is_empty() { &[] } else { unsafe { self.shared.predicted.read() } };
        Hold { inverse_mass: &self.worker.nodes.inverse_mass, predicted }
    }

    /// Meets the others, if it does not go on alone.
    fn meet(&self) {
        if !self.alone {
            self.worker.synchronise();
        }
    }

    /// Does something for each chunk of its share of a level, of bodies that are not done.
    pub fn each(&mut self, level: usize, work: impl Fn(&mut Self, &Chunk)) {
        self.each_of_all(level, |worker, chunk| {
            if !worker.is_done(chunk.body) {
                work(worker, chunk);
            }
        });
    }

    /// Does something for each chunk of its share of a level, but for bodies that rest.
    pub fn each_of_all(&mut self, level: usize, work: impl Fn(&mut Self, &Chunk)) {
        let multigrid = self.multigrid;
        let all = &multigrid.tables[level].chunks;
        let mine = if self.alone { 0..all.len() } else { self.worker.part(all.len()) };
        let resting = self.worker.resting;
        for chunk in all[mine].iter().filter(|chunk| !resting.has(chunk.body)) {
            work(self, chunk);
        }
    }
}

/// Where blocks of some places are, `numbers` a slot.
pub fn slots_of<T>(table: &Table<T>, part: &Range<usize>, numbers: usize) -> Range<usize> {
    let at = |place: usize| table.slots.starts[place / LANES] as usize * LANES * numbers;
    at(part.start)..at(part.end)
}
