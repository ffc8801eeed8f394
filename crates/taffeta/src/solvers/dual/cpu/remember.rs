//! What constraints know from one sub-step to the next: handed out, and taken back.

use crate::backend::SolverState;
use crate::cpu::tiles::TilePlan;
use crate::real::Real;
use crate::solvers::dual::cpu::{SolveSetup, SolveWork};

impl<T: Real> SolveWork<T> {
    /// Pulls, if the solver starts from them or surfaces ask for them, and which constraints are active, if that changes.
    pub fn solver_state(&self, setup: &SolveSetup<T>) -> SolverState {
        let asked = setup.solver.ice.warm_start || setup.surfaces;
        SolverState {
            pulls: if asked { self.pull.iter().map(|pull| pull.to_f64()).collect() } else { Vec::new() },
            active: if setup.adaptive { self.active.clone() } else { Vec::new() },
            joints: Vec::new(),
        }
    }

    /// Takes back what [`Self::remembered`] gave. `tiles` are all of the backend's.
    pub fn set_solver_state(&mut self, setup: &SolveSetup<T>, tiles: &[TilePlan], from: &SolverState) {
        for (pull, &from) in self.pull.iter_mut().zip(&from.pulls) {
            *pull = T::from_f64(from);
        }
        if setup.adaptive {
            self.active.copy_from_slice(&from.active);
            // A tile looks again at constraints that were active, and knows by its count that there are some.
            for (tile, counts) in tiles.iter().zip(&mut self.tile_nodes) {
                let here =
                    |place| setup.by_place.row(place).iter().filter(|&&end| from.active[end as usize / 2]);
                let ends = tile.runs().flat_map(|(_, run)| run).map(|place| here(place).count() as u32);
                *counts = ends.fold([0; 2], |[nodes, all], here| [nodes + u32::from(here > 0), all + here]);
            }
        }
    }
}
