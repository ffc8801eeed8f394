//! The elements of a scene on the CPU, a set for each kind that it has.

use crate::assembly::Assembly;
use crate::cpu::backend::Context;
use crate::cpu::column::Column;
use crate::cpu::feature::{Feature, Flow};
use crate::cpu::shared::Shared;
use crate::cpu::tile::Tile;
use crate::cpu::tiles::TilePlan;
use crate::cpu::worker::Worker;
use crate::elements::aero::{self, cpu::AeroTriangles};
use crate::elements::bending::{self, bending::ShapeOperator};
use crate::elements::cpu::{ByElement, ElementSet};
use crate::elements::element::List;
use crate::elements::hinge::{self, hinge::Bending};
use crate::elements::membrane::{self, membrane::Membrane};
use crate::real::Real;
use crate::report::{ElementEnergy, FrameSums};
use crate::step::Op;
use crate::topology::LANES;
use std::ops::Range;

/// The driver of a kind.
fn set<T: Real>(list: &List, places: usize) -> Box<dyn ElementSet<T>> {
    match list.kind.name {
        hinge::NAME => Box::new(ByElement::<T, Bending, 4, 4>::new(list, places)),
        membrane::NAME => Box::new(ByElement::<T, Membrane, 3, 10>::new(list, places)),
        bending::NAME => Box::new(ByElement::<T, ShapeOperator, 6, 13>::new(list, places)),
        aero::NAME => Box::new(AeroTriangles::new(list, places)),
        other => unreachable!("`{other}` is among the kinds of elements and has no driver"),
    }
}

/// Lists of kinds that the scene has, those that are solved for or the others.
fn lists(assembly: &Assembly, implicit: bool) -> impl Iterator<Item = &List> {
    assembly.elements().iter().filter(move |list| !list.is_empty() && list.implicit == implicit)
}

/// Blocks of the elements of each body.
fn blocks_of(list: &List) -> Vec<Range<usize>> {
    let blocks = |own: &Range<usize>| own.start / LANES..own.end.div_ceil(LANES);
    list.bodies.iter().map(|own| if own.is_empty() { 0..0 } else { blocks(own) }).collect()
}

/// Blocks that a worker finds at least before it goes on to nodes.
const STRIDE: usize = 8;

/// All elements of a scene whose forces are found one by one.
pub struct Elements<T> {
    sets: Vec<Box<dyn ElementSet<T>>>,
    /// Blocks of the elements of each body, by set: of these, and of those that are solved for.
    blocks_of: [Vec<Vec<Range<usize>>>; 2],
    /// Slices of nodes of which one worker finds the forces of all elements around, by worker. It adds these up while they are in
    /// its cache.
    slices: Vec<Vec<u32>>,
    /// By slice: whether it is among those.
    is_summed: Vec<bool>,
    /// Sums of these, by place [N].
    sums: [Shared<T>; 3],
    /// Those that are solved for, which give no forces of their own.
    solved: Vec<Box<dyn ElementSet<T>>>,
}

impl<T: Real> Elements<T> {
    /// Those of a scene, if it has any.
    pub fn new(context: &Context<'_, T>) -> Option<Self> {
        let assembly: &Assembly = context.assembly;
        let of = |implicit: bool| -> Vec<_> {
            lists(assembly, implicit).map(|list| set(list, assembly.places)).collect()
        };
        let mut all = Self {
            sets: of(false),
            blocks_of: [false, true].map(|implicit| lists(assembly, implicit).map(blocks_of).collect()),
            solved: of(true),
            slices: Vec::new(),
            is_summed: vec![false; assembly.places.div_ceil(LANES)],
            sums: [(); 3].map(|()| Vec::new().into()),
        };
        all.share_slices(context.workers());
        if !all.sets.is_empty() {
            all.sums = [(); 3].map(|()| Column::zeros(LANES * all.is_summed.len()).into());
        }
        let any = all.all().next().is_some();
        any.then_some(all)
    }

    /// Finds which of so many workers can add up the forces on each slice.
    fn share_slices(&mut self, workers: usize) {
        self.slices = vec![Vec::new(); workers];
        self.is_summed.fill(false);
        if self.sets.is_empty() {
            return;
        }
        for slice in 0..self.is_summed.len() {
            let within = |worker: usize| {
                self.sets.iter().all(|set| {
                    let (around, part) = (set.around(slice), part(set.blocks(), worker, workers));
                    around.is_empty() || (part.start <= around.start && around.end <= part.end)
                })
            };
            let is_alone = self.sets.iter().all(|set| set.around(slice).is_empty());
            if let Some(worker) = (0..workers).find(|&worker| !is_alone && within(worker)) {
                self.slices[worker].push(slice as u32);
                self.is_summed[slice] = true;
            }
        }
    }

    /// Finds forces of a worker's part of all sets, and adds up those on its slices.
    fn find(&self, worker: &Worker<'_, T>) {
        assert_eq!(worker.workers, self.slices.len(), "slices are shared among all workers");
        let parts: Vec<Range<usize>> = self.sets.iter().map(|set| worker.part(set.blocks())).collect();
        let mut next: Vec<usize> = parts.iter().map(|part| part.start).collect();
        for &slice in &self.slices[worker.index] {
            let slice = slice as usize;
            for (index, (part, next)) in parts.iter().zip(&mut next).enumerate() {
                let around = self.sets[index].around(slice);
                if around.end > *next {
                    let to = part.end.min(around.end + STRIDE);
                    self.find_in(index, worker, *next..to);
                    *next = to;
                }
            }
            let (nodes, mut sum) = (slice * LANES..(slice + 1) * LANES, [[T::ZERO; LANES]; 3]);
            self.sets.iter().for_each(|set| set.gather(worker.nodes.level, nodes.clone(), &mut sum));
            for (column, sum) in self.sums.iter().zip(&sum) {
                // SAFETY: each slice is one worker's, and others read after a barrier.
                unsafe { column.write(nodes.clone()) }.copy_from_slice(sum);
            }
        }
        for (index, (part, next)) in parts.iter().zip(next).enumerate() {
            self.find_in(index, worker, next..part.end);
        }
    }

    /// Finds the forces of blocks of a set, but for bodies that rest.
    fn find_in(&self, set: usize, worker: &Worker<'_, T>, blocks: Range<usize>) {
        let of_body = &self.blocks_of[0][set];
        worker.resting.each_awake(blocks, of_body, |awake| self.sets[set].find(worker, awake));
    }

    /// Finds forces and directions of a worker's part of those that are solved for, but for bodies that rest, in a state, over a step
    /// `h` [s].
    pub fn linearise(&self, worker: &Worker<'_, T>, state: &[&[T]; 6], h: T) {
        for (set, of_body) in self.solved.iter().zip(&self.blocks_of[1]) {
            let find = |awake| set.linearise(worker.nodes.level, awake, state, h);
            worker.resting.each_awake(worker.part(set.blocks()), of_body, find);
        }
    }

    /// Those that are solved for, in the order of [`Solved`](crate::solvers::implicit::couplings::Solved).
    pub fn solved(&self) -> &[Box<dyn ElementSet<T>>] {
        &self.solved
    }

    fn all(&self) -> impl Iterator<Item = &dyn ElementSet<T>> {
        self.sets.iter().chain(&self.solved).map(Box::as_ref)
    }

    /// The forces of each element of a kind [N], as last found.
    #[cfg(feature = "gpu")]
    pub fn forces(&self, kind: &str) -> Vec<[T; 3]> {
        self.of(kind).map_or_else(Vec::new, ElementSet::forces)
    }

    /// The elements of a kind.
    #[cfg(feature = "gpu")]
    pub fn of(&self, kind: &str) -> Option<&dyn ElementSet<T>> {
        self.all().find(|set| set.name() == kind)
    }

    /// Adds up the forces on a run of nodes, slices of nodes at a time.
    fn gather(&self, tile: &mut Tile<'_, T>, at: usize, run: &Range<usize>) {
        let mut start = run.start;
        while start < run.end {
            let nodes = start..run.end.min((start / LANES + 1) * LANES);
            let mut sum = [[T::ZERO; LANES]; 3];
            if self.is_summed[start / LANES] {
                for (column, sum) in self.sums.iter().zip(&mut sum) {
                    // SAFETY: added up before a barrier, and added up again after the sub-step's last.
                    sum[..nodes.len()].copy_from_slice(&unsafe { column.read() }[nodes.clone()]);
                }
            } else {
                self.sets.iter().for_each(|set| set.gather(tile.nodes.level, nodes.clone(), &mut sum));
            }
            let here = at + start - run.start;
            for (column, sum) in tile.scratch.force.iter_mut().zip(&sum) {
                for (force, &sum) in column[here..here + nodes.len()].iter_mut().zip(sum) {
                    *force += sum;
                }
            }
            start = nodes.end;
        }
    }
}

/// A worker's even part of `count` things.
fn part(count: usize, worker: usize, workers: usize) -> Range<usize> {
    count * worker / workers..count * (worker + 1) / workers
}

impl<T: Real> Feature<T> for Elements<T> {
    fn redistribute(&mut self, _: &Assembly, _: &[TilePlan], chunks: &[Range<usize>]) {
        if chunks.len() != self.slices.len() {
            self.share_slices(chunks.len());
        }
    }

    fn ops(&self) -> &'static [Op] {
        &[Op::Elements, Op::Gather]
    }

    fn run(&self, _: Op, worker: &mut Worker<'_, T>) -> Flow {
        self.find(worker);
        Flow::Go
    }

    fn tile(&self, _: Op, tile: &mut Tile<'_, T>) {
        for (at, run) in tile.plan.runs() {
            self.gather(tile, at, &run);
        }
    }

    fn measure(&mut self, state: [&[T]; 6], _: usize, sums: &mut FrameSums) {
        let energies = self.all().map(|set| (set.name(), set.energy(state)));
        let some = energies.filter_map(|(kind, energy)| Some(ElementEnergy::new(kind, energy?)));
        sums.elements = some.collect();
    }

    fn bytes(&self) -> usize {
        let sums = self.sums.iter().map(Shared::bytes).sum::<usize>() + 5 * self.is_summed.len();
        self.all().map(ElementSet::bytes).sum::<usize>() + sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::KINDS;
    use crate::elements::element::Described;

    #[test]
    fn every_kind_of_elements_has_a_driver() {
        for kind in KINDS {
            let all = Described {
                nodes: vec![0; kind.nodes],
                numbers: vec![1.0; kind.numbers()],
                ..Default::default()
            };
            let list = List { kind, all, bodies: Vec::new(), implicit: false, warnings: Vec::new() };
            assert_eq!(set::<f32>(&list, LANES).name(), kind.name);
        }
    }
}
