//! The interface of a feature on the CPU: operations on the scene and on tiles, and memory of its own.

use crate::assembly::Assembly;
use crate::backend::SolverState;
#[cfg(feature = "gpu")]
use crate::cpu::between::Between;
use crate::cpu::tile::Tile;
use crate::cpu::tiles::TilePlan;
use crate::cpu::worker::Worker;
use crate::real::Real;
use crate::report::FrameSums;
use crate::step::{Line, Marks, Op};
use std::any::Any;
use std::ops::Range;

/// Whether rounds continue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// Continue.
    Go,
    /// Stop.
    Done,
}

/// A feature on the CPU. All workers share it. What it changes in a frame is in
/// [`PerWorker`](crate::cpu::cells::PerWorker), in [`Numbers`](crate::cpu::numbers::Numbers), and in [`Shared`](crate::cpu::shared::Shared)
/// where it is much of each place.
pub trait Feature<T: Real>: Any + Send + Sync {
    /// The operations that it carries out. If several features carry out one, they do so in the order of the list of
    /// features.
    fn ops(&self) -> &'static [Op];

    /// The marks that a tile always has.
    fn marks(&self, _plan: &TilePlan) -> Marks {
        Marks::NONE
    }

    /// Begins a sub-step. Called on each worker before its first pass.
    fn begin(&self, _worker: &mut Worker<'_, T>) {}

    /// A worker's part of an operation on the scene.
    fn run(&self, _op: Op, _worker: &mut Worker<'_, T>) -> Flow {
        Flow::Go
    }

    /// An operation on a tile.
    fn tile(&self, _op: Op, _tile: &mut Tile<'_, T>) {}

    /// Called before single passes run on a tile apart from a sub-step: what they read must not be of another tile.
    #[cfg(feature = "gpu")]
    fn begin_apart(&self, _tile: &Tile<'_, T>) {}

    /// Called when they have run. Adds what they leave to others beside forces.
    #[cfg(feature = "gpu")]
    fn end_apart(&self, _tile: &Tile<'_, T>, _between: &mut Between<T>) {}

    /// Called before each frame, which starts at time `start` [s] with `state`.
    fn prepare(&mut self, _assembly: &Assembly, _start: f64, _state: [&[T]; 6]) {}

    /// Adds its measurements of the frame that ends with `state`, after so many sub-steps.
    fn measure(&mut self, _state: [&[T]; 6], _substeps: usize, _sums: &mut FrameSums) {}

    /// How much of a node's way it has taken at most in a sub-step of the last frame, relative to an edge; none where it never takes
    /// any. Frames in which that is much are repeated in shorter sub-steps.
    fn taken(&mut self) -> Option<f64> {
        None
    }

    /// Whether it is in vain to go on with the frame: it is going to be repeated, or has blown up. The same for all workers at the end of
    /// a sub-step.
    fn is_in_vain(&self) -> bool {
        false
    }

    /// Called where sub-steps are `by` times as long from now on as the last one was: a power of two.
    fn rescale(&mut self, _by: f64) {}

    /// Whether what it keeps of bodies whose nodes are all held stays as it is from the second sub-step on, so that nothing of them
    /// needs to be computed again.
    fn lets_rest(&self) -> bool {
        true
    }

    /// Called when a node has been set from outside, pinned or unpinned.
    fn forget(&mut self, _node: usize) {}

    /// Called when nodes have been put elsewhere from outside, past what may have been in the way.
    fn relocate(&mut self) {}

    /// Whether its work is not evenly distributed over nodes, so that tiles are redistributed now and then.
    fn has_uneven_work(&self) -> bool {
        false
    }

    /// Called when workers have got other chunks of tiles, or when there is another number of them: never more than at the start.
    fn redistribute(&mut self, _assembly: &Assembly, _tiles: &[TilePlan], _chunks: &[Range<usize>]) {}

    /// Adds its state between sub-steps.
    fn save(&self, _state: &mut SolverState) {}

    /// Restores what [`Self::save`] added.
    fn load(&mut self, _state: &SolverState) {}

    /// Bytes of memory that it takes.
    fn bytes(&self) -> usize {
        0
    }
}

/// All features of a scene.
pub struct Features<T> {
    all: Vec<Box<dyn Feature<T>>>,
    /// The features that carry out each operation.
    of_op: Vec<Vec<usize>>,
}

impl<T: Real> Features<T> {
    /// In the order in which they act, for passes of these lists.
    ///
    /// # Errors
    /// Names a pass that none of them carries out.
    pub fn new<'l>(
        all: Vec<Box<dyn Feature<T>>>,
        lists: impl Iterator<Item = &'l Line>,
    ) -> Result<Self, String> {
        let mut of_op = vec![Vec::new(); Op::COUNT];
        for (index, feature) in all.iter().enumerate() {
            feature.ops().iter().for_each(|&op| of_op[op as usize].push(index));
        }
        match lists.flat_map(Line::passes).find(|pass| of_op[pass.op as usize].is_empty()) {
            Some(pass) => Err(format!("no feature carries out the pass {:?}", pass.op)),
            None => Ok(Self { all, of_op }),
        }
    }

    /// The features that carry out an operation.
    pub fn of(&self, op: Op) -> impl Iterator<Item = &dyn Feature<T>> {
        self.of_op[op as usize].iter().map(|&index| &*self.all[index])
    }

    /// A feature by its type, if the scene has it.
    pub fn get<F: Feature<T>>(&self) -> Option<&F> {
        self.all.iter().find_map(|feature| (&**feature as &dyn Any).downcast_ref())
    }

    /// The same, mutable between frames.
    #[cfg(feature = "gpu")]
    pub fn get_mut<F: Feature<T>>(&mut self) -> Option<&mut F> {
        self.all.iter_mut().find_map(|feature| (&mut **feature as &mut dyn Any).downcast_mut())
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = &dyn Feature<T>> {
        self.all.iter().map(|feature| &**feature)
    }

    /// All of them, mutable between frames.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Box<dyn Feature<T>>> {
        self.all.iter_mut()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::step;

    #[test]
    fn a_pass_that_no_feature_carries_out_is_refused_by_name() {
        let made = Features::<f64>::new(Vec::new(), step::frame_end().iter());
        assert_eq!(made.err().as_deref(), Some("no feature carries out the pass MeasureTiles"));
    }
}
