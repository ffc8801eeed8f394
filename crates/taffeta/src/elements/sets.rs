//! The elements of a scene on the CPU, a set for each kind that it has.

use crate::assembly::Assembly;
use crate::cpu::backend::Context;
use crate::cpu::feature::{Feature, Flow};
use crate::cpu::tile::Tile;
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

/// All elements of a scene whose forces are found one by one.
pub struct Elements<T> {
    sets: Vec<Box<dyn ElementSet<T>>>,
    /// Those that are solved for, which give no forces of their own.
    solved: Vec<Box<dyn ElementSet<T>>>,
}

impl<T: Real> Elements<T> {
    /// Those of a scene, if it has any.
    pub fn new(context: &Context<'_, T>) -> Option<Self> {
        let assembly: &Assembly = context.assembly;
        let of = |implicit: bool| -> Vec<_> {
            let lists =
                assembly.elements().iter().filter(|list| !list.is_empty() && list.implicit == implicit);
            lists.map(|list| set(list, assembly.places)).collect()
        };
        let all = Self { sets: of(false), solved: of(true) };
        let any = all.all().next().is_some();
        any.then_some(all)
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
            self.sets.iter().for_each(|set| set.gather(tile.nodes.level, nodes.clone(), &mut sum));
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

impl<T: Real> Feature<T> for Elements<T> {
    fn ops(&self) -> &'static [Op] {
        &[Op::Elements, Op::Gather]
    }

    fn run(&self, _: Op, worker: &mut Worker<'_, T>) -> Flow {
        self.sets.iter().for_each(|set| set.find(worker));
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
        self.all().map(ElementSet::bytes).sum()
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
            let all = Described { nodes: vec![0; kind.nodes], numbers: vec![1.0; kind.numbers()] };
            let list = List { kind, all, bodies: Vec::new(), implicit: false };
            assert_eq!(set::<f32>(&list, LANES).name(), kind.name);
        }
    }
}
