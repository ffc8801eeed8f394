//! A tile: some hundred neighbouring nodes, and what operations on them read and write.

use crate::backend::FrameInput;
use crate::cpu::column::Column;
use crate::cpu::feature::Features;
use crate::cpu::numbers::TileMarks;
use crate::cpu::shared::Shared;
use crate::cpu::simd::SimdLevel;
use crate::cpu::tiles::TilePlan;
use crate::plan::Substep;
use crate::real::Real;
use std::ops::Range;

/// Position [m] and velocity [m/s] by axis: x, y, z, then their rates.
pub type Fields<T> = [Shared<T>; 6];

/// What is constant during a frame.
pub struct Nodes<T> {
    /// All tiles, in order.
    pub tiles: Vec<TilePlan>,
    /// Inverse mass [1/kg]; 0: pinned, or no node.
    pub inverse_mass: Column<T>,
    /// Mass [kg]; 0: no node.
    pub mass: Column<T>,
    /// Vector instructions in use.
    pub level: SimdLevel,
}

/// The scratch memory of a worker for its tile.
pub struct Scratch<T> {
    /// Forces on its nodes [N].
    pub force: [Column<T>; 3],
    /// Positions of its nodes before a pass moved them once more [m].
    pub before: [Column<T>; 3],
}

impl<T: Real> Scratch<T> {
    /// For tiles of up to so many nodes.
    pub fn new(nodes: usize) -> Self {
        let columns = || std::array::from_fn(|_| Column::zeros(nodes));
        Self { force: columns(), before: columns() }
    }
}

/// Nodes of a tile that a pass has moved since their contact was resolved.
pub enum Moved<T> {
    /// None: their motion starts before the sub-step.
    None,
    /// Some, with the start of each one's motion [m].
    Some(Vec<(usize, [T; 3])>),
    /// Any: the starts of their motion are in the worker's [`Scratch::before`].
    Any,
}

/// A tile and what operations on it read and write.
pub struct Tile<'a, T> {
    /// What does not change.
    pub nodes: &'a Nodes<T>,
    /// All features of the scene.
    pub features: &'a Features<T>,
    /// The user's input for this frame.
    pub input: &'a FrameInput,
    /// The parameters of the sub-step.
    pub substep: &'a Substep<T>,
    /// Which nodes.
    pub plan: &'a TilePlan,
    /// Which of all tiles it is, and which of the worker's.
    pub index: usize,
    pub number: usize,
    /// Which worker.
    pub worker: usize,
    /// State of all nodes before.
    pub old: [&'a [T]; 6],
    /// State after; the tile's own nodes are written, nothing is read by others before the next barrier.
    pub next: &'a Fields<T>,
    /// The worker's scratch memory.
    pub scratch: &'a mut Scratch<T>,
    /// Its marks.
    pub marks: &'a TileMarks,
    /// Nodes that have been moved since contact was resolved.
    pub moved: Moved<T>,
}

impl<'a, T: Real> Tile<'a, T> {
    /// The state after, of some of the tile's nodes. Operations run one after the other and keep nothing of it.
    pub fn after(&self, run: &Range<usize>) -> [&'a mut [T]; 6] {
        debug_assert!(self.plan.runs().any(|(_, own)| own.start <= run.start && run.end <= own.end));
        // SAFETY: tiles do not overlap, each is in one worker's chunk, and nobody reads this buffer before the barrier
        // after the passes over tiles. Within an operation the parts asked for do not overlap.
        self.next.each_ref().map(|column| unsafe { column.write(run.clone()) })
    }

    /// The places of a tile of a mesh, which are one run.
    pub fn run(&self) -> Range<usize> {
        self.plan.runs().next().map_or(0..0, |(_, run)| run)
    }

    /// Whether colliders act on its nodes.
    pub fn has_contact(&self) -> bool {
        !self.substep.colliders().is_empty()
    }

    /// Sets the state of nodes after it, by solver index, and stores where they were for colliders.
    pub fn move_nodes(&mut self, states: impl Iterator<Item = (usize, [T; 6])>) {
        let mut moved = match std::mem::replace(&mut self.moved, Moved::None) {
            Moved::Some(moved) => moved,
            _ => Vec::new(),
        };
        for (node, state) in states {
            let after = self.after(&(node..node + 1));
            moved.push((node, [0, 1, 2].map(|axis| after[axis][0])));
            for (column, number) in after.into_iter().zip(state) {
                column[0] = number;
            }
        }
        self.moved = Moved::Some(moved);
    }

    /// Where operations list nodes that they move, with the start of each one's motion [m]; if colliders act on them.
    pub fn moved_nodes(&mut self) -> Option<&mut Vec<(usize, [T; 3])>> {
        if !self.has_contact() {
            return None;
        }
        if !matches!(self.moved, Moved::Some(_)) {
            self.moved = Moved::Some(Vec::new());
        }
        match &mut self.moved {
            Moved::Some(moved) => Some(moved),
            _ => None,
        }
    }

    /// Adds a force [N] to that on the `at`-th of its nodes.
    #[inline]
    pub fn add_force(&mut self, at: usize, force: [T; 3]) {
        for (column, force) in self.scratch.force.iter_mut().zip(force) {
            column[at] += force;
        }
    }
}

/// The items of a list, ascending by node, whose nodes are in `run`.
pub fn within<'a, I>(items: &'a [I], run: &Range<usize>, node: impl Fn(&I) -> u32) -> &'a [I] {
    let start = items.partition_point(|item| (node(item) as usize) < run.start);
    let end = items.partition_point(|item| (node(item) as usize) < run.end);
    &items[start..end]
}
