//! Nodes that touch each other: who is near whom, and what they do to each other.
//!
//! Every sub-step looks at candidates alone: pairs that were nearer than their thickness and a margin when neighbours were
//! last searched for. They are all there are until two nodes have moved by more than the margin against each other, which
//! every sub-step sees before it looks. So nothing depends on when, or in how wide a margin, neighbours were searched for.

use super::backend::Setup;
use super::column::Column;
use super::shared::Shared;
use super::simd::Kernel;
use super::tiles::TilePlan;
use crate::assembly::{Apart, Assembly};
use crate::collision::cells::Cells;
use crate::collision::pair::{self, Meeting};
use crate::real::{Real, dot, sub};
use crate::topology::LANES;
use std::ops::Range;

/// Margin about the thickness at first, at least and at most, by the largest thickness.
const MARGIN: [f64; 3] = [0.5, 0.1, 2.0];
/// Looks at a candidate that take as long as the search for the neighbours of a node, about.
const SEARCH: u64 = 40;

/// What does not change.
pub struct PairSetup<T> {
    /// Half the thickness [m] by place; 0: it touches no other.
    radius: Column<T>,
    /// Body by place.
    body: Vec<u32>,
    /// How the surface of each body meets others.
    surfaces: Vec<Meeting<T>>,
    /// Tile by place.
    tile: Vec<u32>,
    /// Nodes that touch.
    nodes: usize,
    /// The largest thickness [m].
    widest: f64,
}

/// Least and most of some numbers by axis.
pub type Bounds<T> = [[T; 3]; 2];

/// What workers find together.
pub struct PairWork<T> {
    /// Contacts of each place in this sub-step.
    contacts: Vec<u32>,
    /// Where nodes were in the last search [m].
    then: [Column<T>; 3],
    /// How far nodes of each worker have moved since.
    moved: Vec<Bounds<T>>,
    /// What each worker has found.
    found: Vec<Found>,
    /// Nodes by bucket: counts of each worker, bucket by bucket, then where its next node goes.
    counts: Vec<u32>,
    /// Nodes in the buckets of each worker's part of the table.
    totals: Vec<u32>,
    /// Where the nodes of each bucket begin.
    starts: Vec<u32>,
    /// Nodes by bucket, with their places and radii.
    sorted: Vec<(u32, [T; 4])>,
}

/// Contacts that a worker has found in a sub-step.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Pairs, each once for each of its nodes of this worker.
    pub ends: u64,
    /// Candidates, the same way.
    candidates: u64,
    /// Least distance of a pair, by its thickness.
    pub nearest: f64,
}

impl Default for Found {
    fn default() -> Self {
        Self { ends: 0, candidates: 0, nearest: f64::INFINITY }
    }
}

/// The same, lent to all workers.
pub struct SharedPairs<'a, T> {
    contacts: Shared<'a, u32>,
    then: [Shared<'a, T>; 3],
    moved: Shared<'a, Bounds<T>>,
    found: Shared<'a, Found>,
    counts: Shared<'a, u32>,
    totals: Shared<'a, u32>,
    starts: Shared<'a, u32>,
    sorted: Shared<'a, (u32, [T; 4])>,
}

/// Lists of nodes, one for each of some owners.
#[derive(Default)]
pub struct Lists {
    /// Owners, each with where its list begins.
    owners: Vec<(u32, u32)>,
    /// Lists, one after the other.
    nodes: Vec<u32>,
}

/// What a worker keeps for itself.
pub struct PairScratch<T> {
    /// Margin of the last search [m]; below 0: there was none.
    margin: f64,
    /// Candidates that all workers have looked at since.
    looked: u64,
    /// Searches in this frame.
    pub searches: u64,
    /// Bucket of each of its nodes, in their order.
    buckets: Vec<u32>,
    /// Candidates of each of its nodes that has some, ascending.
    candidates: Lists,
    /// The same of nodes in contact.
    near: Lists,
    /// Place and velocity after contact, for each owner in `near`.
    answers: Vec<[T; 6]>,
    /// Owners in `near` by tile: those of its tile number `t` are from `owners_of_tile[t]` on in `by_tile`.
    by_tile: Vec<u32>,
    owners_of_tile: Vec<u32>,
    /// The last node for which each place was marked as one that it does not touch.
    marks: Vec<u32>,
    /// What surrounds a cell.
    around: Around<T>,
}

/// Nodes around a cell, by axis, with their radii.
struct Around<T> {
    nodes: Vec<u32>,
    place: [Vec<T>; 3],
    radius: Vec<T>,
    /// Which of them are near a node.
    near: Vec<bool>,
}

impl<T: Real> PairSetup<T> {
    /// Of a scene; `None` where no nodes touch.
    pub fn new(assembly: &Assembly, tiles: &[TilePlan]) -> Option<Self> {
        let number = T::from_f64;
        let (mut radius, mut body_of) = (Column::zeros(assembly.places), vec![0; assembly.places]);
        let (mut surfaces, mut nodes, mut widest) = (Vec::new(), 0, 0.0_f64);
        for (index, body) in assembly.bodies.iter().enumerate() {
            let surface = body.touching.as_ref().map(|touching| touching.surface);
            let [thickness, friction, restitution] =
                surface.map_or([0.0; 3], |s| [s.thickness, s.friction, s.restitution]);
            surfaces.push(Meeting {
                thickness: number(thickness),
                friction: number(friction),
                restitution: number(restitution),
            });
            if surface.is_some() {
                let places = body.first..body.first + body.nodes;
                radius[places.clone()].fill(number(thickness) * number(0.5));
                body_of[places].fill(index as u32);
                nodes += body.nodes;
                widest = widest.max(thickness);
            }
        }
        let mut tile = vec![0; if nodes > 0 { assembly.places } else { 0 }];
        for (number, plan) in tiles.iter().enumerate().filter(|_| nodes > 0) {
            plan.runs().for_each(|(_, run)| tile[run].fill(number as u32));
        }
        (nodes > 0).then_some(Self { radius, body: body_of, surfaces, tile, nodes, widest })
    }

    /// Whether nodes of a body touch any.
    pub fn has(&self, body: usize) -> bool {
        self.surfaces[body].thickness > T::ZERO
    }

    fn meeting(&self, a: usize, b: usize) -> Meeting<T> {
        let [a, b] = [a, b].map(|place| &self.surfaces[self.body[place] as usize]);
        pair::meeting(a, b)
    }

    fn cells(&self, margin: f64) -> Cells {
        Cells::new(self.nodes, self.widest + margin)
    }
}

impl<T: Real> PairWork<T> {
    /// Room for the pairs of a scene.
    pub fn new(setup: Option<&PairSetup<T>>, workers: usize) -> Self {
        let places = setup.map_or(0, |setup| setup.radius.len());
        let buckets = setup.map_or(0, |setup| setup.cells(0.0).buckets());
        Self {
            contacts: vec![0; places],
            then: std::array::from_fn(|_| Column::zeros(places)),
            moved: vec![[[T::ZERO; 3]; 2]; workers],
            found: vec![Found::default(); workers],
            counts: vec![0; workers * buckets],
            totals: vec![0; workers],
            starts: vec![0; buckets + 1],
            sorted: vec![(0, [T::ZERO; 4]); setup.map_or(0, |setup| setup.nodes)],
        }
    }

    /// Lends it.
    pub fn share(&mut self) -> SharedPairs<'_, T> {
        SharedPairs {
            contacts: Shared::new(&mut self.contacts),
            then: self.then.each_mut().map(|column| Shared::new(column)),
            moved: Shared::new(&mut self.moved),
            found: Shared::new(&mut self.found),
            counts: Shared::new(&mut self.counts),
            totals: Shared::new(&mut self.totals),
            starts: Shared::new(&mut self.starts),
            sorted: Shared::new(&mut self.sorted),
        }
    }

    /// What all workers have found in the last sub-step.
    pub fn found(&self) -> Found {
        self.found.iter().fold(Found::default(), |all, one| Found {
            ends: all.ends + one.ends,
            candidates: all.candidates + one.candidates,
            nearest: all.nearest.min(one.nearest),
        })
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        let numbers = self.contacts.len() + self.counts.len() + self.starts.len() + self.sorted.len();
        4 * numbers + (3 * self.then[0].len() + 4 * self.sorted.len()) * size_of::<T>()
    }
}

impl<T: Real> PairScratch<T> {
    /// For a worker with so many tiles.
    pub fn new(places: usize, tiles: usize) -> Self {
        Self {
            margin: -1.0,
            looked: 0,
            searches: 0,
            buckets: Vec::new(),
            candidates: Lists::default(),
            near: Lists::default(),
            answers: Vec::new(),
            by_tile: Vec::new(),
            owners_of_tile: vec![0; tiles + 1],
            marks: vec![u32::MAX; places],
            around: Around::none(),
        }
    }

    /// Nodes of its tile number `tile` that are in contact, with their place and velocity after it.
    pub fn answers(&self, tile: usize) -> impl ExactSizeIterator<Item = (usize, &[T; 6])> {
        let range = self.owners_of_tile[tile] as usize..self.owners_of_tile[tile + 1] as usize;
        self.by_tile[range].iter().map(|&owner| {
            let owner = owner as usize;
            (self.near.owners[owner].0 as usize, &self.answers[owner])
        })
    }
}

impl Lists {
    fn clear(&mut self) {
        self.owners.clear();
        self.nodes.clear();
    }

    /// The list of an owner by its number.
    fn of(&self, number: usize) -> &[u32] {
        let end = self.owners.get(number + 1).map_or(self.nodes.len(), |next| next.1 as usize);
        &self.nodes[self.owners[number].1 as usize..end]
    }
}

/// A worker's part in what all do about pairs.
pub struct PairWorker<'a, T> {
    pub setup: &'a Setup<T>,
    pub pairs: &'a PairSetup<T>,
    pub shared: &'a SharedPairs<'a, T>,
    pub scratch: &'a mut PairScratch<T>,
    /// Its tiles, which worker it is, and of how many.
    pub share: Range<usize>,
    pub index: usize,
    pub workers: usize,
    /// State after the sub-step.
    pub next: &'a [Shared<'a, T>; 6],
}

impl<'a, T: Real> PairWorker<'a, T> {
    /// State after the sub-step, of all nodes.
    fn state(&self) -> [&'a [T]; 6] {
        // SAFETY: all have written their nodes before a barrier, and change them again after another.
        self.next.each_ref().map(|column| unsafe { column.read() })
    }

    /// Its tiles whose nodes touch others.
    fn tiles(&self) -> impl Iterator<Item = (usize, &TilePlan)> {
        let plans = self.setup.tiles[self.share.clone()].iter().enumerate();
        plans.filter(|(_, plan)| self.pairs.has(plan.body))
    }

    /// Runs of places of its tiles.
    fn runs(&self) -> impl Iterator<Item = Range<usize>> {
        self.tiles().flat_map(|(_, plan)| plan.runs().map(|(_, run)| run))
    }

    fn place(&self, node: usize) -> [T; 3] {
        let [x, y, z, ..] = self.state();
        [x[node], y[node], z[node]]
    }

    /// Notes how far its nodes have moved since the last search.
    pub fn note_moves(&self) {
        // SAFETY: they are written between barriers, in a search.
        let then = self.shared.then.each_ref().map(|column| unsafe { column.read() });
        let mut bounds = [[T::FAR; 3], [-T::FAR; 3]];
        for axis in 0..3 {
            for run in self.runs() {
                // SAFETY: others do not touch this worker's nodes.
                let now = unsafe { self.next[axis].write(run.clone()) };
                let [least, most] = self.setup.level.run(Moves { now, then: &then[axis][run] });
                let [low, high] = [bounds[0][axis], bounds[1][axis]];
                bounds[0][axis] = if least < low { least } else { low };
                bounds[1][axis] = if most > high { most } else { high };
            }
        }
        // SAFETY: each worker has its own; all read after a barrier.
        let slot = unsafe { self.shared.moved.write(self.index..self.index + 1) };
        slot[0] = bounds;
    }

    /// Whether two nodes may have moved by more than the margin against each other since the last search.
    pub fn is_stale(&self) -> bool {
        if self.scratch.margin < 0.0 {
            return true;
        }
        // SAFETY: written before a barrier.
        let moved = unsafe { self.shared.moved.read() };
        let extent = |axis: usize| {
            let least = moved.iter().map(|bounds| bounds[0][axis].to_f64()).fold(f64::INFINITY, f64::min);
            let most = moved.iter().map(|bounds| bounds[1][axis].to_f64()).fold(f64::NEG_INFINITY, f64::max);
            most - least
        };
        let far = (0..3).map(|axis| extent(axis).powi(2)).sum::<f64>().sqrt();
        // Room for the rounding of what was measured.
        far >= self.scratch.margin * 0.999
    }

    /// Chooses the margin of a search: wider where candidates have cost less than the last search, else narrower.
    fn choose_margin(&mut self) {
        let [first, least, most] = MARGIN.map(|share| share * self.pairs.widest);
        let PairScratch { margin, looked, searches, .. } = &mut *self.scratch;
        *margin = match *margin {
            margin if margin < 0.0 => first,
            margin if *looked < SEARCH * self.pairs.nodes as u64 => (margin * 1.25).min(most),
            margin => (margin * 0.8).max(least),
        };
        (*looked, *searches) = (0, *searches + 1);
    }

    /// Sorts all nodes by bucket and finds candidates; `meet` waits for all workers.
    pub fn search(&mut self, meet: impl Fn()) {
        self.choose_margin();
        let cells = self.pairs.cells(self.scratch.margin);
        self.count(&cells);
        meet();
        self.sum_up(&cells);
        meet();
        self.sort(&cells);
        meet();
        self.list_candidates(&cells);
    }

    /// Counts its nodes by bucket.
    fn count(&mut self, cells: &Cells) {
        let own = self.index * cells.buckets()..(self.index + 1) * cells.buckets();
        // SAFETY: each worker has its own counts until the next barrier.
        let counts = unsafe { self.shared.counts.write(own) };
        counts.fill(0);
        let mut buckets = std::mem::take(&mut self.scratch.buckets);
        buckets.clear();
        let place = |node: usize| self.place(node).map(T::to_f64);
        buckets.extend(self.runs().flatten().map(|node| cells.bucket(cells.cell(place(node))) as u32));
        buckets.iter().for_each(|&bucket| counts[bucket as usize] += 1);
        self.scratch.buckets = buckets;
    }

    /// Part of the table that a worker sums up.
    fn part(&self, cells: &Cells, worker: usize) -> Range<usize> {
        cells.buckets() * worker / self.workers..cells.buckets() * (worker + 1) / self.workers
    }

    /// Turns counts into places, in its part of the table: bucket by bucket, worker by worker.
    fn sum_up(&self, cells: &Cells) {
        let mut sum = 0;
        for bucket in self.part(cells, self.index) {
            // SAFETY: parts of the table do not overlap; others read after the next barrier.
            let start = unsafe { self.shared.starts.write(bucket..bucket + 1) };
            start[0] = sum;
            for worker in 0..self.workers {
                let at = worker * cells.buckets() + bucket;
                // SAFETY: as above.
                let count = &mut unsafe { self.shared.counts.write(at..at + 1) }[0];
                (*count, sum) = (sum, sum + *count);
            }
        }
        // SAFETY: each worker has its own.
        let total = unsafe { self.shared.totals.write(self.index..self.index + 1) };
        total[0] = sum;
    }

    /// Puts its nodes where they belong. The order within a bucket tells workers apart; lists are sorted after.
    fn sort(&self, cells: &Cells) {
        // SAFETY: written before the last barrier.
        let totals = unsafe { self.shared.totals.read() };
        let mut before = vec![0; self.workers];
        (1..self.workers).for_each(|worker| before[worker] = before[worker - 1] + totals[worker - 1]);
        let own = self.index * cells.buckets()..(self.index + 1) * cells.buckets();
        // SAFETY: each worker has its own counts.
        let next = unsafe { self.shared.counts.write(own) };
        for worker in 0..self.workers {
            next[self.part(cells, worker)].iter_mut().for_each(|place| *place += before[worker]);
        }
        let part = self.part(cells, self.index);
        // SAFETY: parts of the table do not overlap; others read after the next barrier.
        let starts = unsafe { self.shared.starts.write(part) };
        starts.iter_mut().for_each(|start| *start += before[self.index]);
        if self.index + 1 == self.workers {
            // SAFETY: no part has it.
            let end = unsafe { self.shared.starts.write(cells.buckets()..cells.buckets() + 1) };
            end[0] = self.pairs.nodes as u32;
        }
        for (node, &bucket) in self.runs().flatten().zip(&self.scratch.buckets) {
            let place = &mut next[bucket as usize];
            let ([x, y, z], radius) = (self.place(node), self.pairs.radius[node]);
            let at = *place as usize;
            // SAFETY: no two nodes have one place.
            let slot = unsafe { self.shared.sorted.write(at..at + 1) };
            slot[0] = (node as u32, [x, y, z, radius]);
            *place += 1;
        }
        let state = self.state();
        for run in self.runs() {
            for (then, now) in self.shared.then.iter().zip(state) {
                // SAFETY: runs do not overlap; all read after a barrier.
                unsafe { then.write(run.clone()) }.copy_from_slice(&now[run.clone()]);
            }
        }
    }

    /// Finds the candidates of its nodes, cell by cell.
    fn list_candidates(&mut self, cells: &Cells) {
        // SAFETY: written before the last barrier; each worker has written its own counts.
        let (ends, starts, sorted) =
            unsafe { (self.shared.counts.read(), self.shared.starts.read(), self.shared.sorted.read()) };
        let mut scratch = Search {
            lists: std::mem::take(&mut self.scratch.candidates),
            marks: std::mem::take(&mut self.scratch.marks),
        };
        let mut around = std::mem::replace(&mut self.scratch.around, Around::none());
        scratch.lists.clear();
        for bucket in 0..cells.buckets() {
            // Its own nodes end where it has put the last, and begin where those of the worker before end.
            let end = ends[self.index * cells.buckets() + bucket] as usize;
            let start = match self.index {
                0 => starts[bucket] as usize,
                index => ends[(index - 1) * cells.buckets() + bucket] as usize,
            };
            let mut of = None;
            for &(node, [x, y, z, radius]) in &sorted[start..end] {
                let cell = cells.cell([x, y, z].map(T::to_f64));
                if of != Some(cell) {
                    around.gather(
                        cells
                            .around(cell)
                            .flat_map(|run| &sorted[starts[run.start] as usize..starts[run.end] as usize]),
                    );
                    of = Some(cell);
                }
                let reach = radius + T::from_f64(self.scratch.margin);
                self.setup.level.run(Near { around: &mut around, x: [x, y, z], reach });
                self.add_candidates(node, &around, &mut scratch);
            }
        }
        self.scratch.around = around;
        (self.scratch.candidates, self.scratch.marks) = (scratch.lists, scratch.marks);
    }

    /// Adds the nodes near one that it may touch.
    fn add_candidates(&self, node: u32, around: &Around<T>, search: &mut Search) {
        let Search { lists, marks } = search;
        let body = &self.setup.assembly.bodies[self.pairs.body[node as usize] as usize];
        marks[node as usize] = node;
        if let Some(touching) = &body.touching {
            let apart: &Apart = &touching.apart;
            apart.each(body, node as usize - body.first, |other| marks[body.first + other] = node);
        }
        let from = lists.nodes.len();
        // Each is written, and stays if it belongs: no processor foresees which do.
        lists.nodes.resize(from + around.nodes.len(), 0);
        let found = &mut lists.nodes[from..];
        let mut near = 0;
        for (&other, &is_near) in around.nodes.iter().zip(&around.near) {
            found[near] = other;
            near += usize::from(is_near);
        }
        let mut count = 0;
        for i in 0..near {
            let other = found[i];
            found[count] = other;
            count += usize::from(marks[other as usize] != node);
        }
        lists.nodes.truncate(from + count);
        if count == 0 {
            return;
        }
        lists.nodes[from..].sort_unstable();
        let mut kept = from + 1;
        for i in from + 1..lists.nodes.len() {
            if lists.nodes[i] != lists.nodes[kept - 1] {
                lists.nodes[kept] = lists.nodes[i];
                kept += 1;
            }
        }
        lists.nodes.truncate(kept);
        lists.owners.push((node, from as u32));
    }

    /// Finds which of its candidates are in contact.
    pub fn find_near(&mut self) {
        let [x, y, z, ..] = self.state();
        let place = |node: usize| [x[node], y[node], z[node]];
        let PairScratch { candidates, near, .. } = &mut *self.scratch;
        let note = |node: u32, count: usize| {
            // SAFETY: the node is in this worker's share; others read after the next barrier.
            let contacts = unsafe { self.shared.contacts.write(node as usize..node as usize + 1) };
            contacts[0] = count as u32;
        };
        near.owners.iter().for_each(|&(node, _)| note(node, 0));
        near.clear();
        let mut least = T::FAR;
        for (number, &(node, _)) in candidates.owners.iter().enumerate() {
            let (at, start) = (node as usize, near.nodes.len());
            let (own, radius) = (place(at), self.pairs.radius[at]);
            for &other in candidates.of(number) {
                let at = other as usize;
                let d = sub(own, place(at));
                let (squared, reach) = (dot(d, d), radius + self.pairs.radius[at]);
                if squared < reach * reach {
                    near.nodes.push(other);
                    let share = squared / (reach * reach);
                    least = if share < least { share } else { least };
                }
            }
            if near.nodes.len() > start {
                near.owners.push((node, start as u32));
                note(node, near.nodes.len() - start);
            }
        }
        let found = Found {
            ends: near.nodes.len() as u64,
            candidates: candidates.nodes.len() as u64,
            nearest: least.to_f64().sqrt(),
        };
        // SAFETY: each worker has its own; all read after a barrier.
        let slot = unsafe { self.shared.found.write(self.index..self.index + 1) };
        slot[0] = found;
    }

    /// Whether any nodes are in contact.
    pub fn any(&mut self) -> bool {
        // SAFETY: written before the last barrier.
        let found = unsafe { self.shared.found.read() };
        self.scratch.looked += found.iter().map(|found| found.candidates).sum::<u64>();
        found.iter().any(|found| found.ends > 0)
    }

    /// Sorts its nodes in contact by tile.
    fn sort_by_tile(&mut self) {
        let PairScratch { near, by_tile, owners_of_tile, .. } = &mut *self.scratch;
        let tile = |node: u32| self.pairs.tile[node as usize] as usize - self.share.start;
        owners_of_tile.fill(0);
        near.owners.iter().for_each(|&(node, _)| owners_of_tile[tile(node)] += 1);
        let mut sum = 0;
        for start in owners_of_tile.iter_mut() {
            (*start, sum) = (sum, sum + *start);
        }
        by_tile.clear();
        by_tile.resize(near.owners.len(), 0);
        for (owner, &(node, _)) in (0..).zip(&near.owners) {
            let next = &mut owners_of_tile[tile(node)];
            by_tile[*next as usize] = owner;
            *next += 1;
        }
        // Each has moved on to where the next one begins.
        owners_of_tile.rotate_right(1);
        owners_of_tile[0] = 0;
    }

    /// Finds what contact does to each of its nodes, after a sub-step of `h` [s].
    pub fn answer(&mut self, h: T) {
        let limits = (h, T::from_f64(pair::most_apart(h.to_f64())));
        // SAFETY: written before the last barrier.
        let contacts = unsafe { self.shared.contacts.read() };
        let state = self.state();
        let mut answers = std::mem::take(&mut self.scratch.answers);
        answers.clear();
        for number in 0..self.scratch.near.owners.len() {
            let node = self.scratch.near.owners[number].0 as usize;
            let mut sum = [T::ZERO; 6];
            for &other in self.scratch.near.of(number) {
                let other = other as usize;
                let (a, b) = (node.min(other), node.max(other));
                let [xa, xb] = [a, b].map(|at| [0, 1, 2].map(|axis| state[axis][at]));
                let [va, vb] = [a, b].map(|at| [3, 4, 5].map(|axis| state[axis][at]));
                let mobility = pair::mobility(
                    [a, b].map(|at| self.setup.inverse_mass[at]),
                    [a, b].map(|at| contacts[at]),
                );
                let done =
                    pair::exchange(sub(xa, xb), sub(va, vb), mobility, &self.pairs.meeting(a, b), limits);
                let sign = if node == a { T::ONE } else { -T::ONE };
                for axis in 0..3 {
                    sum[axis] += done.shift[axis] * sign;
                    sum[3 + axis] += done.impulse[axis] * sign;
                }
            }
            let w = self.setup.inverse_mass[node];
            answers.push(std::array::from_fn(|axis| state[axis][node] + sum[axis] * w));
        }
        self.scratch.answers = answers;
        self.sort_by_tile();
    }
}

/// What a search fills and uses.
struct Search {
    lists: Lists,
    marks: Vec<u32>,
}

impl<T: Real> Around<T> {
    fn none() -> Self {
        Self {
            nodes: Vec::new(),
            place: std::array::from_fn(|_| Vec::new()),
            radius: Vec::new(),
            near: Vec::new(),
        }
    }

    /// Takes what surrounds a cell.
    fn gather<'s>(&mut self, nodes: impl Iterator<Item = &'s (u32, [T; 4])>) {
        self.nodes.clear();
        self.radius.clear();
        self.place.iter_mut().for_each(Vec::clear);
        for &(node, [x, y, z, radius]) in nodes {
            self.nodes.push(node);
            self.place[0].push(x);
            self.place[1].push(y);
            self.place[2].push(z);
            self.radius.push(radius);
        }
        self.near.resize(self.nodes.len(), false);
    }
}

/// Kernel: which nodes around are nearer to a place than their radius and `reach`.
struct Near<'a, T> {
    around: &'a mut Around<T>,
    x: [T; 3],
    reach: T,
}

impl<T: Real> Kernel for Near<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { around: Around { place: [x, y, z], radius, near, .. }, x: own, reach } = self;
        let n = near.len();
        let (x, y, z, radius) = (&x[..n], &y[..n], &z[..n], &radius[..n]);
        for i in 0..n {
            let d = sub([x[i], y[i], z[i]], own);
            let reach = radius[i] + reach;
            near[i] = dot(d, d) < reach * reach;
        }
    }
}

/// Kernel: least and most way of some nodes along one axis. One that is no number touches nothing, and does not count.
struct Moves<'a, T> {
    now: &'a [T],
    then: &'a [T],
}

impl<T: Real> Kernel for Moves<'_, T> {
    type Output = [T; 2];
    #[inline(always)]
    fn run(self) -> [T; 2] {
        let mut lanes = [[T::FAR; LANES], [-T::FAR; LANES]];
        let [least, most] = &mut lanes;
        let mut take = |lane: usize, way: T| {
            least[lane] = if way < least[lane] { way } else { least[lane] };
            most[lane] = if way > most[lane] { way } else { most[lane] };
        };
        let (now, then) = (self.now.chunks_exact(LANES), self.then.chunks_exact(LANES));
        let rest = now.remainder().iter().zip(then.remainder());
        for (now, then) in now.zip(then) {
            for lane in 0..LANES {
                take(lane, now[lane] - then[lane]);
            }
        }
        rest.enumerate().for_each(|(lane, (&now, &then))| take(lane, now - then));
        let [least, most] = lanes;
        [
            least.into_iter().fold(T::FAR, |all, one| if one < all { one } else { all }),
            most.into_iter().fold(-T::FAR, |all, one| if one > all { one } else { all }),
        ]
    }
}
