//! The forces on nodes that pins hold, on the CPU.

use crate::assembly::Assembly;
use crate::cpu::feature::Feature;
use crate::cpu::numbers::Numbers;
use crate::cpu::tile::{Tile, within};
use crate::motion::held::HeldNode;
use crate::real::Real;
use crate::report::FrameSums;
use crate::step::Op;

/// Keeps the forces of the last sub-step.
pub struct HeldForces {
    nodes: Vec<HeldNode>,
    /// Of each of them [N].
    forces: Numbers<3>,
}

impl HeldForces {
    /// Of a scene with pins.
    pub fn new(assembly: &Assembly) -> Option<Self> {
        let nodes = assembly.held().to_vec();
        let forces = Numbers::new(nodes.len());
        (!nodes.is_empty()).then_some(Self { nodes, forces })
    }

    /// Solver index of each node, and the force on it [N], as last kept.
    #[cfg(feature = "gpu")]
    pub fn all<T: Real>(&self) -> impl Iterator<Item = (usize, [T; 3])> {
        let forces = self.forces.iter().map(|force| force.map(T::from_f64));
        self.nodes.iter().map(|held| held.node as usize).zip(forces)
    }
}

impl<T: Real> Feature<T> for HeldForces {
    fn ops(&self) -> &'static [Op] {
        &[Op::HeldForces]
    }

    fn tile(&self, _: Op, tile: &mut Tile<'_, T>) {
        for (at, run) in tile.plan.runs() {
            let first = self.nodes.partition_point(|held| (held.node as usize) < run.start);
            for (index, held) in (first..).zip(within(&self.nodes, &run, |held| held.node)) {
                let local = at + held.node as usize - run.start;
                self.forces.set(index, tile.scratch.force.each_ref().map(|column| column[local].to_f64()));
            }
        }
    }

    fn measure(&mut self, _: [&[T]; 6], substeps: usize, sums: &mut FrameSums) {
        if substeps > 0 {
            sums.held = self.forces.iter().collect();
        }
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + 24 * self.forces.len()
    }
}
