//! The forces on nodes that pins hold, on the CPU.

use crate::assembly::Assembly;
use crate::cpu::feature::Feature;
use crate::cpu::shared::Shared;
use crate::cpu::tile::{Tile, within};
use crate::motion::held::HeldNode;
use crate::real::Real;
use crate::report::FrameSums;
use crate::step::Op;

/// Keeps the forces of the last sub-step.
pub struct HeldForces<T> {
    nodes: Vec<HeldNode>,
    /// Of each of them [N].
    forces: Shared<[T; 3]>,
}

impl<T: Real> HeldForces<T> {
    /// Of a scene with pins.
    pub fn new(assembly: &Assembly) -> Option<Self> {
        let nodes = assembly.held().to_vec();
        let forces = vec![[T::ZERO; 3]; nodes.len()].into();
        (!nodes.is_empty()).then_some(Self { nodes, forces })
    }

    /// Solver index of each node, and the force on it [N], as last kept.
    #[cfg(feature = "gpu")]
    pub fn all(&mut self) -> impl Iterator<Item = (usize, [T; 3])> {
        self.nodes.iter().map(|held| held.node as usize).zip(self.forces.get_mut().iter().copied())
    }
}

impl<T: Real> Feature<T> for HeldForces<T> {
    fn ops(&self) -> &'static [Op] {
        &[Op::HeldForces]
    }

    fn tile(&self, _: Op, tile: &mut Tile<'_, T>) {
        for (at, run) in tile.plan.runs() {
            let first = self.nodes.partition_point(|held| (held.node as usize) < run.start);
            for (index, held) in (first..).zip(within(&self.nodes, &run, |held| held.node)) {
                let local = at + held.node as usize - run.start;
                // SAFETY: each node is one tile's, and forces are read after the frame.
                *unsafe { self.forces.item(index) } =
                    tile.scratch.force.each_ref().map(|column| column[local]);
            }
        }
    }

    fn measure(&mut self, _: [&[T]; 6], substeps: usize, sums: &mut FrameSums) {
        if substeps > 0 {
            sums.held = self.forces.get_mut().iter().map(|force| force.map(T::to_f64)).collect();
        }
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + self.forces.bytes()
    }
}
