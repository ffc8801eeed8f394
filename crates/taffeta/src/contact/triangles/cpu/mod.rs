//! Contact of surfaces on the CPU.

mod broad_phase;
mod carry;
mod contacts;
mod hold;
mod lanes;
mod motion;
mod narrow_phase;
mod pose;
mod rounds;
pub mod solved;
#[cfg(test)]
mod tests;
mod untangle;

use crate::assembly::Assembly;
use crate::backend::{ContactForce, SolverState};
use crate::contact::triangles::carry::Pushed;
use crate::contact::triangles::cpu::broad_phase::{Leaves, Pairs};
use crate::contact::triangles::cpu::carry::Push;
use crate::contact::triangles::cpu::contacts::{Active, Carried, Mail};
use crate::contact::triangles::cpu::narrow_phase::{Close, Memory};
use crate::contact::triangles::cpu::solved::Solved;
use crate::contact::triangles::leaves::Lists;
use crate::contact::triangles::order::Order;
use crate::contact::triangles::slide::UNLIMITED;
use crate::contact::triangles::solved::sustained;
use crate::contact::triangles::surfaces::{Kind, Surfaces};
use crate::contact::triangles::tangle::Tangle;
use crate::cpu::backend::Context;
use crate::cpu::cells::{Cells, PerWorker};
use crate::cpu::feature::{Feature, Flow};
use crate::cpu::numbers::{Number, Numbers};
use crate::cpu::shared::Shared;
use crate::cpu::tile::Tile;
use crate::cpu::tiles::TilePlan;
use crate::cpu::worker::Worker;
use crate::plan::Substep;
use crate::real::{Real, add, scale};
use crate::report::FrameSums;
use crate::step::Op;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};

/// Contact of surfaces.
pub struct TriangleContact<T> {
    surfaces: Surfaces,
    /// The tile of each place, and the worker of each tile.
    tile_of: Vec<u32>,
    worker_of: Vec<u32>,
    /// Positions at the start [m], by axis.
    start: [Vec<T>; 3],
    leaves: Leaves<T>,
    leaves_by_place: Lists,
    mail: Mail<T>,
    /// By kind of pair, and from each worker to each.
    pushes: Cells<Vec<Push<T>>>,
    solved: Solved<T>,
    /// For each place, the number of its contacts.
    counts: Vec<AtomicU32>,
    /// For each place, the part of its motion that it may make before a collider, as the bits of a number from 0 to 1.
    parts: Vec<AtomicU64>,
    /// What limits each place in a round of the filter, and where it slides: see [`slide`](crate::contact::triangles::slide).
    limits: Vec<AtomicU32>,
    /// When each place was last held back, and when each leaf last had such a place: by a number that only grows.
    held: Vec<AtomicU64>,
    marks: Vec<AtomicU64>,
    /// Where nodes and corners of colliders are before the sub-step, or the round of the filter, and after it [m].
    before: [Shared<T>; 3],
    after: [Shared<T>; 3],
    /// Where nodes go in the rounds of the filter that are left [m], and their velocities there [m/s]. Before the filter:
    /// how far colliders have pushed them, and what this round adds [m].
    target: [Shared<T>; 6],
    /// What each worker has found.
    motion: Numbers<4>,
    found: Vec<Found>,
    scratch: PerWorker<Scratch<T>>,
    /// How surfaces pass through each other, where they do.
    tangle: Option<Tangle>,
    /// Whether they may; then it is looked for at the end of each frame, until none does. And whether it must be looked for
    /// before the next frame, too: nodes have been put elsewhere.
    is_tangled: bool,
    is_stale: bool,
    /// Whether all that is known of pairs was forgotten since the last frame.
    is_forgotten: bool,
    /// Whether the filter has taken so much that the frame need not go on.
    is_in_vain: AtomicBool,
}

/// What a worker has found in a sub-step, for all to read after a barrier.
#[derive(Debug, Default)]
struct Found {
    contacts: Number,
    /// Least distance of a contact relative to its thickness; infinite without.
    nearest: Number,
    /// The farthest that a contact would sink in, relative to its thickness, before each of the last two rounds.
    sinks: [Number; 2],
    /// Whether the filter has held nodes back lately.
    is_held: AtomicBool,
    /// What the last round of pushes came to: see [`Pushed`].
    has_moved: AtomicBool,
    waiting: AtomicU32,
    /// The longest way in the last round of the filter of a node that has not arrived, or that it slides in the next one [m].
    progress: Number,
}

impl Found {
    fn all(workers: usize) -> Vec<Self> {
        std::iter::repeat_with(Self::default).take(workers).collect()
    }

    /// So many contacts, the nearest at this distance, and nothing of rounds yet.
    fn begin(&self, contacts: usize, nearest: f64) {
        self.contacts.set(contacts as f64);
        self.nearest.set(nearest);
        self.sinks.iter().for_each(|sinks| sinks.set(0.0));
        self.is_held.store(false, Ordering::Relaxed);
        self.set_pushed(Pushed::default());
        self.progress.set(0.0);
    }

    fn pushed(&self) -> Pushed {
        Pushed {
            moved: self.has_moved.load(Ordering::Relaxed),
            waiting: self.waiting.load(Ordering::Relaxed),
        }
    }

    fn set_pushed(&self, Pushed { moved, waiting }: Pushed) {
        self.has_moved.store(moved, Ordering::Relaxed);
        self.waiting.store(waiting, Ordering::Relaxed);
    }
}

/// The memory of a worker.
struct Scratch<T> {
    pairs: Pairs<T>,
    memory: Memory<T>,
    /// Pairs that come near, by kind, and contacts. The forces of the last sub-step.
    close: [Vec<Close<T>>; 2],
    contacts: Vec<Active<T>>,
    carried: Vec<Carried<T>>,
    /// Whether the solver of this sub-step has found impulses.
    is_solved: bool,
    /// Nodes in contact, tile by tile, and the place of each among them.
    touched: Vec<Touched<T>>,
    slot: Vec<u32>,
    /// Nodes that the next pass moves, tile by tile, and where those of each of the worker's tiles begin.
    responses: Vec<(u32, [T; 6])>,
    tiles: Vec<usize>,
    /// What marks nodes that are held back, and what marked the first in this round of the filter.
    stamp: u64,
    first_stamp: u64,
    /// The longest way that the filter has taken of a node, squared [m²]: in all rounds of the frame that leave nothing of it, and what
    /// the last round has left.
    taken: [f64; 2],
    /// One more than the last node that had no room between colliders in the frame.
    squeezed: u32,
    /// Which round of impulses, and of the filter, is next, if any is.
    round: usize,
    filter_round: Option<usize>,
}

/// A node in contact.
struct Touched<T> {
    node: u32,
    /// Its state before contact.
    base: [T; 6],
    /// Sum of what removes old overlaps [kg·m], and of impulses [N·s].
    push: [T; 3],
    sum: [T; 3],
}

const NO_SLOT: u32 = u32::MAX;
/// The key of contacts that pull surfaces apart: what they carry is not kept.
const NO_KEY: [u32; 2] = [u32::MAX; 2];

impl<T: Real> Scratch<T> {
    fn new(places: usize) -> Self {
        Self {
            pairs: Pairs::new(),
            memory: Memory::new(),
            close: [Vec::new(), Vec::new()],
            contacts: Vec::new(),
            carried: Vec::new(),
            is_solved: false,
            touched: Vec::new(),
            slot: vec![NO_SLOT; places],
            responses: Vec::new(),
            tiles: Vec::new(),
            stamp: 0,
            first_stamp: 0,
            taken: [0.0; 2],
            squeezed: 0,
            round: 0,
            filter_round: None,
        }
    }

    /// Keeps the forces for the next sub-step. That of a short one counts by its part of the longest: what is left of a frame may be
    /// too short to tell a force.
    fn note_forces(&mut self, &Substep { h, longest, .. }: &Substep<T>) {
        let old = (T::ONE - h / longest).max(T::ZERO);
        self.carried.clear();
        for Active { carried, impulse, .. } in &self.contacts {
            let (last, impulse) = (carried.force, add(carried.solved.unwrap_or_default(), *impulse));
            let mut force = add(scale(last, old), scale(impulse, T::ONE / h.max(longest)));
            if self.is_solved {
                force = sustained(force, last);
            }
            if force != [T::ZERO; 3] && carried.key != NO_KEY {
                self.carried.push(Carried { force, solved: None, ..*carried });
            }
        }
        self.is_solved = false;
    }
}

impl<T: Real> TriangleContact<T> {
    /// Contact of a scene's surfaces; `None` in a scene without.
    pub fn new(context: &mut Context<'_, T>) -> Option<Self> {
        let surfaces = std::mem::take(context.assembly.surfaces_mut()?);
        let (places, workers) = (context.assembly.places, context.workers());
        let with_corners = || -> [Shared<T>; 3] {
            std::array::from_fn(|axis| {
                let corners = surfaces.corners().iter().map(|x| T::from_f64(x[axis]));
                // The last one stands still.
                std::iter::repeat_n(T::ZERO, places)
                    .chain(corners)
                    .chain([T::ZERO])
                    .collect::<Vec<T>>()
                    .into()
            })
        };
        let solved_places = if context.assembly.solver.is_primal() { places } else { 0 };
        let mut all = Self {
            tile_of: vec![0; places],
            worker_of: Vec::new(),
            start: std::array::from_fn(|axis| surfaces.start.iter().map(|x| T::from_f64(x[axis])).collect()),
            leaves: Leaves::new(&surfaces, workers),
            leaves_by_place: surfaces.leaves_by_place(),
            mail: Mail::new(workers),
            pushes: Cells::new(2 * workers * workers, |_| Vec::new()),
            solved: Solved::new(workers, solved_places),
            counts: std::iter::repeat_with(|| AtomicU32::new(0)).take(surfaces.all_places() + 1).collect(),
            parts: atomics(places, 1_f64.to_bits()),
            limits: std::iter::repeat_with(|| AtomicU32::new(UNLIMITED)).take(places).collect(),
            held: atomics(places, 0),
            marks: atomics(surfaces.leaves.len(), 0),
            before: with_corners(),
            after: with_corners(),
            target: std::array::from_fn(|_| vec![T::ZERO; places].into()),
            motion: Numbers::new(workers),
            found: Found::all(workers),
            scratch: PerWorker::new(workers, |_| Scratch::new(places)),
            tangle: None,
            is_tangled: surfaces.start_tangled,
            is_stale: false,
            is_forgotten: false,
            is_in_vain: AtomicBool::new(false),
            surfaces,
        };
        all.share(&context.nodes.tiles, context.chunks);
        Some(all)
    }

    /// Has so many workers from now on, and shares what they have again.
    fn set_workers(&mut self, workers: usize) {
        let places = self.surfaces.places;
        let mut state = SolverState::default();
        self.save(&mut state);
        self.leaves = Leaves::new(&self.surfaces, workers);
        self.mail = Mail::new(workers);
        self.pushes = Cells::new(2 * workers * workers, |_| Vec::new());
        self.solved = self.solved.again(workers);
        self.motion = Numbers::new(workers);
        self.found = Found::all(workers);
        self.scratch = PerWorker::new(workers, |_| Scratch::new(places));
        // Stamps start again.
        self.held = atomics(places, 0);
        self.marks = atomics(self.surfaces.leaves.len(), 0);
        self.load(&state);
    }

    /// Notes who has which tile.
    fn share(&mut self, tiles: &[TilePlan], chunks: &[Range<usize>]) {
        for (number, plan) in tiles.iter().enumerate() {
            plan.runs().for_each(|(_, run)| self.tile_of[run].fill(number as u32));
        }
        self.worker_of = vec![0; tiles.len()];
        for (worker, chunk) in chunks.iter().enumerate() {
            self.worker_of[chunk.clone()].fill(worker as u32);
        }
    }

    fn worker_of(&self, node: u32) -> usize {
        self.worker_of[self.tile_of[node as usize] as usize] as usize
    }

    /// Where nodes would end [m].
    fn target(&self) -> [&[T]; 3] {
        // SAFETY: written before a barrier, and again after another.
        std::array::from_fn(|axis| unsafe { self.target[axis].read() })
    }

    /// State after the sub-step.
    fn state<'w>(&self, worker: &Worker<'w, T>) -> [&'w [T]; 6] {
        // SAFETY: all have written their nodes before a barrier, and change them again after another.
        worker.next().each_ref().map(|column| unsafe { column.read() })
    }
}

fn atomics(count: usize, value: u64) -> Vec<AtomicU64> {
    std::iter::repeat_with(|| AtomicU64::new(value)).take(count).collect()
}

fn positions<T>([x, y, z, ..]: [&[T]; 6]) -> [&[T]; 3] {
    [x, y, z]
}

fn read<T: Real>(columns: &[Shared<T>; 3]) -> [&[T]; 3] {
    // SAFETY: written before a barrier, and again after another.
    columns.each_ref().map(|column| unsafe { column.read() })
}

impl<T: Real> Feature<T> for TriangleContact<T> {
    fn ops(&self) -> &'static [Op] {
        &[
            Op::SurfaceContacts,
            Op::SurfaceImpulses,
            Op::ApplySurfaceImpulses,
            Op::SurfaceFilter,
            Op::ApplySurfaceFilter,
        ]
    }

    fn run(&self, op: Op, worker: &mut Worker<'_, T>) -> Flow {
        let scratch = &mut *self.scratch.of(worker.index);
        match op {
            Op::SurfaceContacts => {
                self.find(worker, scratch);
                Flow::Go
            }
            Op::SurfaceImpulses => self.round(worker, scratch),
            _ => self.filter(worker, scratch),
        }
    }

    fn tile(&self, _: Op, tile: &mut Tile<'_, T>) {
        let scratch = self.scratch.read(tile.worker);
        let responses = &scratch.responses[scratch.tiles[tile.number]..scratch.tiles[tile.number + 1]];
        tile.move_nodes(responses.iter().map(|&(node, state)| (node as usize, state)));
    }

    fn prepare(&mut self, assembly: &Assembly, start: f64, state: [&[T]; 6]) {
        (self.is_forgotten, self.is_in_vain) = (false, AtomicBool::new(false));
        for scratch in self.scratch.iter_mut() {
            (scratch.taken, scratch.squeezed) = ([0.0; 2], 0);
        }
        if std::mem::take(&mut self.is_stale) {
            self.set_corners(assembly, start);
            if self.is_tangled {
                self.find_tangle(state);
            }
        }
    }

    fn measure(&mut self, state: [&[T]; 6], substeps: usize, sums: &mut FrameSums) {
        if self.is_tangled {
            self.find_tangle(state);
            sums.intersections = Some(self.tangle.as_ref().map_or(0, |tangle| tangle.pairs));
        }
        let searches =
            self.scratch.iter_mut().map(|scratch| std::mem::take(&mut scratch.pairs.search.searches)).max();
        if substeps == 0 {
            return;
        }
        for found in &self.found {
            sums.pairs.pairs += found.contacts.get() as u64;
            sums.pairs.nearest = sums.pairs.nearest.min(found.nearest.get());
        }
        sums.pairs.searches += searches.unwrap_or(0);
        let squeezed = self.scratch.iter_mut().map(|scratch| scratch.squeezed).max();
        sums.squeezed = squeezed.and_then(|node| node.checked_sub(1));
    }

    fn taken(&mut self) -> Option<f64> {
        let most = self.scratch.iter_mut().flat_map(|scratch| scratch.taken).fold(0.0, f64::max);
        Some(self.by_edge(most))
    }

    fn is_in_vain(&self) -> bool {
        self.is_in_vain.load(Ordering::Relaxed)
    }

    fn forget(&mut self, _: usize) {
        // Once is enough where all nodes are set.
        if !std::mem::replace(&mut self.is_forgotten, true) {
            self.leaves.forget();
            self.scratch.iter_mut().for_each(|scratch| scratch.pairs.forget());
        }
    }

    fn relocate(&mut self) {
        (self.is_tangled, self.is_stale) = (true, true);
    }

    fn redistribute(&mut self, _: &Assembly, tiles: &[TilePlan], chunks: &[Range<usize>]) {
        if chunks.len() != self.found.len() {
            self.set_workers(chunks.len());
        }
        self.share(tiles, chunks);
        self.counts.iter_mut().for_each(|count| *count.get_mut() = 0);
        for scratch in self.scratch.iter_mut() {
            scratch.touched.clear();
            scratch.slot.fill(NO_SLOT);
        }
    }

    fn save(&self, state: &mut SolverState) {
        state.is_tangled |= self.is_tangled;
        for scratch in self.scratch.iter() {
            state.contacts.extend(scratch.carried.iter().map(|one| ContactForce {
                kind: one.kind as u8,
                pair: one.key,
                force: one.force.map(T::to_f64),
            }));
        }
    }

    fn load(&mut self, state: &SolverState) {
        self.forget(0);
        (self.is_tangled, self.is_stale) = (state.is_tangled, true);
        self.tangle = None;
        // A frame that was stopped may have held nodes back, and have counted.
        self.parts.iter_mut().for_each(|part| *part.get_mut() = 1_f64.to_bits());
        self.limits.iter_mut().for_each(|limit| *limit.get_mut() = UNLIMITED);
        for scratch in self.scratch.iter_mut() {
            scratch.pairs.search.searches = 0;
            scratch.carried.clear();
            scratch.contacts.clear();
        }
        let mut all: Vec<Carried<T>> = Vec::with_capacity(state.contacts.len());
        let firsts = self.surfaces.firsts();
        for &ContactForce { kind, pair, force } in &state.contacts {
            let kind = Kind::ALL[usize::from(kind).min(1)];
            let order = Order::of_key(&firsts, kind, pair);
            all.push(Carried { order, kind, key: pair, force: force.map(T::from_f64), solved: None });
        }
        all.sort_unstable_by_key(|one| one.order);
        for one in all {
            let worker = self.leaves.worker_of(one.order.leaf());
            if let Some(scratch) = self.scratch.iter_mut().nth(worker) {
                scratch.carried.push(one);
            }
        }
    }

    fn bytes(&self) -> usize {
        self.scratch.iter().map(|scratch| scratch.pairs.bytes()).sum::<usize>()
            + 8 * (self.parts.len() + self.held.len() + self.marks.len())
            + 4 * (self.limits.len() + self.tile_of.len() + self.worker_of.len() + self.counts.len())
            + self.start.iter().map(|column| size_of_val(&column[..])).sum::<usize>()
            + size_of_val(&self.surfaces.leaves[..])
            + self.surfaces.rings.bytes()
            + self.surfaces.corners_at.bytes()
            + self.leaves.bytes()
            + self.leaves_by_place.bytes()
            + self.solved.bytes()
            + self.before.iter().chain(&self.after).chain(&self.target).map(Shared::bytes).sum::<usize>()
    }
}
