//! Contacts as part of an implicit step: found where nodes are before it, listed by slices of nodes for the products of a
//! solver, and kept for the rounds after it.

use super::rounds::Asked;
use super::{NO_KEY, Scratch, TriangleContact, positions};
use crate::contact::triangles::cpu::contacts::Carried;
use crate::contact::triangles::solved::{NEAR, SolvedContact, relative, taken_back};
use crate::contact::triangles::surfaces::Corners;
use crate::cpu::cells::{Cells, PerWorker};
use crate::cpu::shared::Shared;
use crate::cpu::simd::Kernel;
use crate::cpu::worker::Worker;
use crate::real::{Real, Symmetric, add, dot, scale, sub};
use crate::topology::LANES;
use atomic_refcell::AtomicRef;
use std::array::from_fn;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

/// No body: what is no part of the system.
pub const NO_BODY: u32 = u32::MAX;

/// The system that contacts become part of.
pub struct System<'a, T> {
    /// By place: its body, or [`NO_BODY`].
    pub bodies: &'a [u32],
    /// The first place of each worker's share.
    pub shares: &'a [u32],
    /// Where nodes would be [m], and their velocities [m/s], by axis.
    pub moved: [&'a [T]; 6],
    /// Step [s].
    pub h: T,
}

/// A node of a contact: the contact by the worker that has found it.
#[derive(Clone, Copy, Debug)]
struct Row<T> {
    place: u32,
    worker: u32,
    contact: u32,
    corner: u32,
    weight: T,
}

/// Which of whose rows are those of a slice of nodes.
#[derive(Clone, Copy, Debug, Default)]
struct Slice {
    worker: u32,
    rows: [u32; 2],
}

/// The contacts of a sub-step in the system.
pub struct Solved<T> {
    /// By worker: those that it has found, and their number.
    contacts: PerWorker<Vec<SolvedContact<T>>>,
    counts: Vec<AtomicUsize>,
    /// By worker: those that act, as products have them; and what each takes back of the vector of the product to come [N·s].
    acting: PerWorker<Vec<Acting<T>>>,
    taken: Shared<Vec<[T; 3]>>,
    /// From each worker to each: their nodes. By worker: those of its share, ascending.
    sent: Cells<Vec<Row<T>>>,
    rows: Shared<Vec<Row<T>>>,
    slices: Shared<Slice>,
    /// By worker: bodies that contacts join; with [`NO_BODY`], those that they hold.
    links: PerWorker<Vec<[u32; 2]>>,
}

/// What contacts add to a product of a system.
#[derive(Clone, Copy)]
pub struct ContactBlocks<'a, T> {
    taken: &'a [Vec<[T; 3]>],
    rows: &'a [Vec<Row<T>>],
    slices: &'a [Slice],
}

/// Sixteen contacts that act, as products have them.
#[derive(Clone, Copy, Debug)]
struct Acting<T> {
    /// Which of the worker's they are.
    numbers: [u32; LANES],
    nodes: [[u32; LANES]; 4],
    /// 1, or 0 for corners of colliders, whose way is no part of the system.
    moves: [[T; LANES]; 4],
    weights: [[T; LANES]; 4],
    normal: [[T; LANES]; 3],
    along: [T; LANES],
    across: [T; LANES],
}

impl<T: Real> Solved<T> {
    /// For so many workers, and nodes of so many places.
    pub fn new(workers: usize, places: usize) -> Self {
        Self {
            contacts: PerWorker::new(workers, |_| Vec::new()),
            counts: (0..workers).map(|_| AtomicUsize::new(0)).collect(),
            acting: PerWorker::new(workers, |_| Vec::new()),
            taken: vec![Vec::new(); workers].into(),
            sent: Cells::new(workers * workers, |_| Vec::new()),
            rows: vec![Vec::new(); workers].into(),
            slices: vec![Slice::default(); places.div_ceil(LANES)].into(),
            links: PerWorker::new(workers, |_| Vec::new()),
        }
    }

    /// For another number of workers.
    pub fn again(&self, workers: usize) -> Self {
        Self::new(workers, self.slices.len() * LANES)
    }

    /// Bytes that it takes, but for its lists.
    pub fn bytes(&self) -> usize {
        self.slices.bytes()
    }
}

impl<T: Real> ContactBlocks<'_, T> {
    /// Adds what contacts take back, on a slice of nodes.
    #[inline(always)]
    pub fn add_product(&self, slice: usize, sum: &mut [[T; LANES]; 3]) {
        let Slice { worker, rows: [from, to] } = self.slices[slice];
        for row in &self.rows[worker as usize][from as usize..to as usize] {
            let taken = scale(self.taken[row.worker as usize][row.contact as usize], row.weight);
            for axis in 0..3 {
                sum[axis][row.place as usize % LANES] += taken[axis];
            }
        }
    }
}

impl<T: Real> Acting<T> {
    /// Of up to sixteen contacts by number, at least one, in a scene of so many places; the last fills the lanes that are left.
    fn of(numbers: &[u32], contacts: &[SolvedContact<T>], places: usize) -> Self {
        let number = |lane: usize| numbers[lane.min(numbers.len() - 1)];
        let at = |lane: usize| &contacts[number(lane) as usize];
        let is_node = |node: u32| (node as usize) < places;
        // Some node of the contact itself stands for a corner: what has blown up elsewhere is none of its.
        let node = |one: &SolvedContact<T>, corner: usize| {
            let nodes = one.nodes;
            let any = nodes.into_iter().find(|&node| is_node(node)).unwrap_or(0);
            if is_node(nodes[corner]) { nodes[corner] } else { any }
        };
        let moves = |moves: bool| if moves { T::ONE } else { T::ZERO };
        Self {
            numbers: from_fn(number),
            nodes: from_fn(|corner| from_fn(|lane| node(at(lane), corner))),
            moves: from_fn(|corner| from_fn(|lane| moves(is_node(at(lane).nodes[corner])))),
            weights: from_fn(|corner| from_fn(|lane| at(lane).weights[corner])),
            normal: from_fn(|axis| from_fn(|lane| at(lane).normal[axis])),
            along: from_fn(|lane| at(lane).along),
            across: from_fn(|lane| at(lane).across),
        }
    }
}

/// Kernel: what contacts take back of a vector, whose columns are by place.
struct TakeBack<'a, T> {
    acting: &'a [Acting<T>],
    vector: [&'a [T]; 3],
    places: usize,
    taken: &'a mut [[T; 3]],
}

impl<T: Real> Kernel for TakeBack<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { acting, vector, places, taken } = self;
        let vector = vector.map(|column| &column[..places]);
        for lanes in acting {
            let mut of = [[[T::ZERO; LANES]; 3]; 4];
            for ((of, nodes), moves) in of.iter_mut().zip(&lanes.nodes).zip(&lanes.moves) {
                for (of, column) in of.iter_mut().zip(vector) {
                    for lane in 0..LANES {
                        debug_assert!((nodes[lane] as usize) < places);
                        // SAFETY: nodes are places of the scene, which columns have.
                        of[lane] = unsafe { *column.get_unchecked(nodes[lane] as usize) } * moves[lane];
                    }
                }
            }
            let mut all = [[T::ZERO; LANES]; 3];
            for lane in 0..LANES {
                let nodes = from_fn(|corner| from_fn(|axis| of[corner][axis][lane]));
                let velocity = relative(nodes, from_fn(|corner| lanes.weights[corner][lane]));
                let normal = from_fn(|axis| lanes.normal[axis][lane]);
                let by = taken_back(velocity, normal, [lanes.along[lane], lanes.across[lane]]);
                for axis in 0..3 {
                    all[axis][lane] = if lanes.along[lane] > T::ZERO { by[axis] } else { T::ZERO };
                }
            }
            for (lane, &number) in lanes.numbers.iter().enumerate() {
                taken[number as usize] = from_fn(|axis| all[axis][lane]);
            }
        }
    }
}

impl<T: Real> TriangleContact<T> {
    /// Finds the contacts that may come about. All workers call it.
    pub fn find_solved(&self, worker: &Worker<'_, T>, system: &System<'_, T>) {
        self.take_start(worker);
        worker.synchronise();
        let scratch = &mut *self.scratch.of(worker.index);
        scratch.is_solved = true;
        scratch.contacts.clear();
        self.lead_out(worker, &mut scratch.contacts);
        self.pull(worker, &mut scratch.contacts);
        let beyond = (NEAR - 1.0) * self.surfaces.thickest;
        let asked = Asked { h: worker.substep.h, within: T::from_f64(NEAR), leads: true };
        self.look(worker, scratch, Some(asked), beyond);
        let mut own = self.solved.contacts.of(worker.index);
        own.clear();
        own.extend(scratch.contacts.iter().map(|one| SolvedContact {
            nodes: one.nodes,
            weights: one.weights,
            normal: one.contact.normal,
            gap: one.contact.gap,
            lead: if one.carried.key == NO_KEY { one.contact.lead(worker.substep.h) } else { T::ZERO },
            friction: one.contact.friction,
            first: scale(one.carried.force, system.h),
            body: NO_BODY,
            ..SolvedContact::default()
        }));
        self.solved.counts[worker.index].store(own.len(), Ordering::Relaxed);
        self.send_rows(worker, system, &mut own);
        drop(own);
        worker.synchronise();
        self.take_rows(worker, system);
        worker.synchronise();
    }

    /// Sets where a worker's nodes and corners are.
    fn take_start(&self, worker: &Worker<'_, T>) {
        let old = positions(worker.old());
        let corners = worker.substep.extensions.get::<Corners<T>>();
        for columns in [&self.before, &self.after] {
            self.each_run(worker, |run| {
                for (column, old) in columns.iter().zip(old) {
                    // SAFETY: its own places; others read after a barrier.
                    unsafe { column.write(run.clone()) }.copy_from_slice(&old[run.clone()]);
                }
            });
            for place in self.corners_of(worker) {
                let at = corners.and_then(|corners| corners.before.get(place - self.surfaces.places));
                self.put(columns, place, at.copied().unwrap_or_else(|| self.get(&self.after, place)));
            }
        }
    }

    /// Sends the nodes of a worker's contacts to whoever has them, and notes which bodies these join.
    fn send_rows(&self, worker: &Worker<'_, T>, system: &System<'_, T>, contacts: &mut [SolvedContact<T>]) {
        let (workers, places) = (self.found.len(), self.surfaces.places);
        let mut links = self.solved.links.of(worker.index);
        links.clear();
        let mut sent: Vec<_> =
            (0..workers).map(|to| self.solved.sent.of(worker.index * workers + to)).collect();
        sent.iter_mut().for_each(|rows| rows.clear());
        for (number, one) in (0..).zip(contacts) {
            let corners = (0..4).filter(|&corner| one.weights[corner] != T::ZERO);
            let bodies = corners.clone().map(|corner| system.bodies.get(one.nodes[corner] as usize).copied());
            if bodies.clone().any(|body| body == Some(NO_BODY)) {
                continue;
            }
            // One that rests has no system to be done with.
            let awake = bodies.clone().flatten().find(|&body| !worker.resting.has(body as usize));
            let Some(first) = awake.or_else(|| bodies.clone().flatten().next()) else { continue };
            one.body = first;
            for other in bodies.map(|body| body.unwrap_or(NO_BODY)).filter(|&body| body != first) {
                if links.last() != Some(&[first, other]) {
                    links.push([first, other]);
                }
            }
            for corner in corners.filter(|&corner| (one.nodes[corner] as usize) < places) {
                let place = one.nodes[corner];
                let to = system.shares.partition_point(|&first| first <= place) - 1;
                sent[to].push(Row {
                    place,
                    worker: worker.index as u32,
                    contact: number,
                    corner: corner as u32,
                    weight: one.weights[corner],
                });
            }
        }
    }

    /// Lists the nodes of a worker's share by slices.
    fn take_rows(&self, worker: &Worker<'_, T>, system: &System<'_, T>) {
        let workers = self.found.len();
        let first = |share: usize| {
            system.shares.get(share).map_or(self.solved.slices.len(), |&place| place as usize / LANES)
        };
        let own = first(worker.index)..first(worker.index + 1);
        // SAFETY: its own rows and slices, which others read after the next barrier.
        let (rows, slices) =
            unsafe { (self.solved.rows.item(worker.index), self.solved.slices.write(own.clone())) };
        rows.clear();
        for from in 0..workers {
            rows.extend_from_slice(&self.solved.sent.read(from * workers + worker.index));
        }
        // A stable sort: the sums of a node are in the order of contacts, whoever has found them.
        rows.sort_by_key(|row| row.place);
        let mut from = 0;
        for (number, slice) in own.zip(slices) {
            let to = from + rows[from..].partition_point(|row| row.place as usize / LANES <= number);
            *slice = Slice { worker: worker.index as u32, rows: [from as u32, to as u32] };
            from = to;
        }
    }

    /// Pairs of bodies that contacts join; with [`NO_BODY`], bodies that they hold. Known after [`Self::find_solved`].
    pub fn solved_links(&self) -> impl Iterator<Item = [u32; 2]> {
        self.solved.links.iter().flat_map(|links| links.clone())
    }

    /// Whether any contact is part of the system. All workers answer the same after [`Self::find_solved`].
    pub fn has_solved(&self) -> bool {
        self.solved.counts.iter().any(|count| count.load(Ordering::Relaxed) > 0)
    }

    /// The contacts that a worker has found.
    pub fn solved_of(&self, worker: &Worker<'_, T>) -> AtomicRef<'_, Vec<SolvedContact<T>>> {
        self.solved.contacts.read(worker.index)
    }

    /// The contacts that each worker has found.
    pub fn solved_contacts(&self) -> Vec<AtomicRef<'_, Vec<SolvedContact<T>>>> {
        self.solved.contacts.iter().collect()
    }

    /// Finds what a worker's contacts take back of a vector by place, for a product that follows after a barrier.
    pub fn take_back(&self, worker: &Worker<'_, T>, vector: [&[T]; 3]) {
        let places = self.surfaces.places;
        let acting = &self.solved.acting.read(worker.index)[..];
        // SAFETY: its own; others read it after the next barrier.
        let taken = unsafe { self.solved.taken.item(worker.index) };
        worker.nodes.level.run(TakeBack { acting, vector, places, taken });
    }

    /// What contacts add to the product for which they have been asked last.
    pub fn solved_blocks(&self) -> ContactBlocks<'_, T> {
        let Solved { taken, rows, slices, .. } = &self.solved;
        // SAFETY: written before a barrier, and again after another.
        unsafe { ContactBlocks { taken: taken.read(), rows: rows.read(), slices: slices.read() } }
    }

    /// Finds the impulses of a worker's contacts where a Newton step starts, but for those of bodies that take none. `block`: the
    /// inverse of the diagonal block of a place [1/kg], and whether a collider holds it.
    pub fn linearise_solved(
        &self,
        worker: &Worker<'_, T>,
        system: &System<'_, T>,
        (is_first, is_met): (bool, impl Fn(usize) -> bool),
        block: impl Fn(usize) -> (Symmetric<T>, bool),
    ) {
        let corners = worker.substep.extensions.get::<Corners<T>>();
        let corner_way = |corner: usize| {
            let at = |all: &[[T; 3]]| all.get(corner).copied();
            let ends = corners.and_then(|all| at(&all.before).zip(at(&all.after)));
            ends.map_or([T::ZERO; 3], |(from, to)| sub(to, from))
        };
        let places = self.surfaces.places;
        let (old, moved, step) = (positions(worker.old()), system.moved, worker.substep.h);
        let way = |node: u32| match node as usize {
            place if place < places => [0, 1, 2].map(|axis| moved[axis][place] - old[axis][place]),
            corner => corner_way(corner - places),
        };
        let velocity = |node: u32| match node as usize {
            place if place < places => [3, 4, 5].map(|axis| moved[axis][place]),
            corner => corner_way(corner - places).map(|way| way / step),
        };
        let own = &mut *self.solved.contacts.of(worker.index);
        for one in own.iter_mut() {
            if one.body == NO_BODY || is_met(one.body as usize) {
                continue;
            }
            if is_first {
                one.stiffen(|node| match node as usize {
                    place if place < places => {
                        let (inverse, is_held) = block(place);
                        (worker.nodes.inverse_mass[place], inverse, is_held)
                    }
                    _ => (T::ZERO, [T::ZERO; 6], false),
                });
            }
            let gap = one.gap + dot(one.relative(way), one.normal);
            one.linearise(gap, one.relative(velocity), system.h);
        }
        // SAFETY: its own; others read it after a barrier.
        let taken = unsafe { self.solved.taken.item(worker.index) };
        let mut acting = self.solved.acting.of(worker.index);
        acting.clear();
        let (mut numbers, mut count) = ([0; LANES], 0);
        for (number, one) in (0..).zip(own.iter()) {
            if one.along > T::ZERO {
                numbers[count % LANES] = number;
                count += 1;
                if count % LANES == 0 {
                    acting.push(Acting::of(&numbers, own, places));
                }
            }
        }
        if count % LANES > 0 {
            acting.push(Acting::of(&numbers[..count % LANES], own, places));
        }
        taken.clear();
        taken.resize(own.len(), [T::ZERO; 3]);
    }

    /// Calls `job` with each of the `contacts` that workers have found of the nodes of some places, whole slices, the place and which
    /// of the contact's nodes it is.
    pub fn each_solved(
        &self,
        contacts: &[AtomicRef<'_, Vec<SolvedContact<T>>>],
        part: &Range<usize>,
        mut job: impl FnMut(usize, &SolvedContact<T>, usize),
    ) {
        let ContactBlocks { rows, slices, .. } = self.solved_blocks();
        for slice in &slices[part.start / LANES..part.end / LANES] {
            for row in &rows[slice.worker as usize][slice.rows[0] as usize..slice.rows[1] as usize] {
                let one = &contacts[row.worker as usize][row.contact as usize];
                job(row.place as usize, one, row.corner as usize);
            }
        }
    }

    /// Notes what impulses have become by a Newton step that changes velocities by `step` [m/s].
    pub fn apply_solved(
        &self,
        worker: &Worker<'_, T>,
        is_met: impl Fn(usize) -> bool,
        step: impl Fn(usize) -> [T; 3],
    ) {
        let places = self.surfaces.places;
        let of = |node: u32| if (node as usize) < places { step(node as usize) } else { [T::ZERO; 3] };
        for one in self.solved.contacts.of(worker.index).iter_mut() {
            if one.body != NO_BODY && !is_met(one.body as usize) {
                one.applied = add(one.impulse, scale(one.times(one.relative(of)), -T::ONE));
            }
        }
    }

    /// Tells the rounds after the solver which impulses it has found.
    pub fn keep_solved(&self, worker: &Worker<'_, T>) {
        let Scratch { contacts, carried, .. } = &mut *self.scratch.of(worker.index);
        carried.clear();
        for (active, one) in contacts.iter().zip(self.solved_of(worker).iter()) {
            let solved = (one.body != NO_BODY).then_some(one.applied);
            let acts = solved.unwrap_or(active.carried.force) != [T::ZERO; 3];
            if acts && active.carried.key != NO_KEY {
                carried.push(Carried { solved, ..active.carried });
            }
        }
    }
}
