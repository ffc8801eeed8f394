//! Constraint forces on a tile.

use crate::contact::colliders::predicted_contact::PredictedContact;
use crate::cpu::tile::Tile;
use crate::real::Real;
use crate::solvers::dual::cpu::Dual;
use crate::solvers::dual::cpu::kernels::gather;
use crate::solvers::waiting;

impl<T: Real> Dual<T> {
    /// Adds constraint forces to the forces on a tile.
    pub(crate) fn add_constraint_forces(&self, tile: &mut Tile<'_, T>) {
        for (at, run) in tile.plan.runs() {
            if !self.adaptive {
                for place in run.clone() {
                    self.add_node_forces(tile, (at + place - run.start, place), place);
                }
                continue;
            }
            let layout = &self.scratch.read(tile.worker).layout;
            // A tile may wait although no constraint has become active.
            let Some(nodes) = layout.nodes_of_tile.get(tile.number).cloned() else { return };
            // SAFETY: listed before a barrier; the nodes of a tile ascend.
            let places = &unsafe { self.work.places.read() }[nodes.clone()];
            let within = |place: usize| places.partition_point(|&one| (one as usize) < place);
            let (from, to) = (within(run.start), within(run.end));
            for (&place, node) in places[from..to].iter().zip(nodes.start + from..) {
                let place = place as usize;
                self.add_node_forces(tile, (at + place - run.start, place), node);
            }
        }
    }

    /// Adds the constraint forces at a node of the system to the `at`-th force of a tile.
    fn add_node_forces(&self, tile: &mut Tile<'_, T>, (at, place): (usize, usize), node: usize) {
        let work = &self.work;
        // SAFETY: listed, and found, before a barrier.
        let (span, entries, row_forces) =
            unsafe { (work.spans.read()[node], work.entries.read(), work.row_forces.read()) };
        let [x, y, z, _] = gather(&entries[span[0] as usize..span[1] as usize], row_forces).0;
        let mut force = [-x, -y, -z];
        if self.surfaces {
            force = self.force_in_contact(tile, (place, node), force);
        }
        tile.add_force(at, force);
    }

    /// The constraint force on a node in contact.
    fn force_in_contact(&self, tile: &Tile<'_, T>, (place, node): (usize, usize), force: [T; 3]) -> [T; 3] {
        // SAFETY: found before a barrier.
        let (predicted, collider): (&PredictedContact<T>, _) =
            unsafe { (&self.work.predicted.read()[node], self.work.collider.read()[node]) };
        if !predicted.in_contact() {
            return force;
        }
        let kick = tile.substep.h * tile.nodes.inverse_mass[place];
        let surface = &self.colliders(tile.substep).at(place)[collider as usize].surface;
        predicted.force_with_contact(waiting::free_velocity(tile, place), force, kick, surface)
    }
}
