//! Elements on the CPU: forces are found element by element, then gathered by node. Nothing scatters.

use crate::cpu::backend::Context;
use crate::cpu::feature::{Feature, Flow};
use crate::cpu::simd::SimdLevel;
use crate::cpu::tile::Tile;
use crate::cpu::worker::Worker;
use crate::diagnostics::FrameSums;
use crate::elements;
use crate::real::Real;
use crate::step::Op;
use crate::topology::LANES;
use std::any::Any;
use std::ops::Range;

/// All elements of one kind.
pub trait ElementSet<T: Real>: Any + Send + Sync {
    /// Finds the forces of a worker's part of them.
    fn find(&self, worker: &Worker<'_, T>);
    /// Adds to the sums of up to [`LANES`] nodes the forces [N] of the elements around them, in order.
    fn gather(&self, level: SimdLevel, nodes: Range<usize>, sum: &mut [[T; LANES]; 3]);
    /// Energy of all of them [J].
    fn energy(&self, _state: [&[T]; 6]) -> f64 {
        0.0
    }
    /// Bytes that they take.
    fn bytes(&self) -> usize;
}

/// All elements of a scene whose forces are found one by one.
pub struct Elements<T> {
    sets: Vec<Box<dyn ElementSet<T>>>,
}

impl<T: Real> Elements<T> {
    /// Those of a scene, if it has any.
    pub fn new(context: &Context<'_, T>) -> Option<Self> {
        let sets = elements::sets(context.assembly);
        (!sets.is_empty()).then_some(Self { sets })
    }

    /// The elements of a kind.
    #[cfg(feature = "gpu")]
    pub fn set<S: ElementSet<T>>(&self) -> Option<&S> {
        self.sets.iter().find_map(|set| (&**set as &dyn Any).downcast_ref())
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
        sums.hinges = self.sets.iter().map(|set| set.energy(state)).sum();
    }

    fn bytes(&self) -> usize {
        self.sets.iter().map(|set| set.bytes()).sum()
    }
}
