//! Constraint forces on a tile.

use crate::contact::colliders::predicted_contact::PredictedContact;
use crate::cpu::tile::Tile;
use crate::real::Real;
use crate::solvers::dual::cpu::kernels::gather;
use crate::solvers::dual::cpu::{Dual, Quad};
use crate::solvers::waiting;

/// What nodes of the system have, to read.
struct Found<'a, T> {
    places: &'a [u32],
    spans: &'a [[u32; 2]],
    entries: &'a [u32],
    row_forces: &'a [Quad<T>],
    predicted: &'a [PredictedContact<T>],
    collider: &'a [u32],
}

impl<T: Real> Dual<T> {
    /// Adds constraint forces to the forces on a tile.
    pub(crate) fn add_constraint_forces(&self, tile: &mut Tile<'_, T>) {
        let found = self.found();
        for (at, run) in tile.plan.runs() {
            if let Some(bands) = &self.bands[tile.plan.body] {
                let forces = self.band_state.response(bands);
                for place in run.clone() {
                    let force = forces.map(|column| -column[place - bands.first]);
                    self.add_force(tile, &found, (at + place - run.start, place), (place, force));
                }
                continue;
            }
            if !self.adaptive {
                for place in run.clone() {
                    self.add_node_forces(tile, &found, (at + place - run.start, place), place);
                }
                continue;
            }
            let layout = &self.scratch.read(tile.worker).layout;
            // A tile may wait although no constraint has become active.
            let Some(nodes) = layout.nodes_of_tile.get(tile.number).cloned() else { return };
            // The nodes of a tile ascend.
            let places = &found.places[nodes.clone()];
            let within = |place: usize| places.partition_point(|&one| (one as usize) < place);
            let (from, to) = (within(run.start), within(run.end));
            for (&place, node) in places[from..to].iter().zip(nodes.start + from..) {
                let place = place as usize;
                self.add_node_forces(tile, &found, (at + place - run.start, place), node);
            }
        }
    }

    /// What was listed, and found, before a barrier.
    fn found(&self) -> Found<'_, T> {
        let work = &self.work;
        // SAFETY: no worker writes any of it before the next barrier.
        unsafe {
            Found {
                places: work.places.read(),
                spans: work.spans.read(),
                entries: work.entries.read(),
                row_forces: work.row_forces.read(),
                predicted: work.predicted.read(),
                collider: work.collider.read(),
            }
        }
    }

    /// Adds the constraint forces at a node of the system to the `at`-th force of a tile.
    fn add_node_forces(&self, tile: &mut Tile<'_, T>, found: &Found<'_, T>, to: (usize, usize), node: usize) {
        let span = found.spans[node];
        let [x, y, z, _] = gather(&found.entries[span[0] as usize..span[1] as usize], found.row_forces).0;
        self.add_force(tile, found, to, (node, [-x, -y, -z]));
    }

    /// Adds the force on a node of the system to the `at`-th force of a tile.
    fn add_force(
        &self,
        tile: &mut Tile<'_, T>,
        found: &Found<'_, T>,
        (at, place): (usize, usize),
        (node, force): (usize, [T; 3]),
    ) {
        let predicted = &found.predicted[node];
        let force = if self.surfaces && predicted.in_contact() {
            let kick = tile.substep.h * tile.nodes.inverse_mass[place];
            let surface = &self.colliders(tile.substep).at(place)[found.collider[node] as usize].surface;
            predicted.force_with_contact(waiting::free_velocity(tile, place), force, kick, surface)
        } else {
            force
        };
        tile.add_force(at, force);
    }
}
