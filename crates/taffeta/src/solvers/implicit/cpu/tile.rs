//! What springs that are integrated implicitly give a tile.

use crate::cpu::tile::Tile;
use crate::real::{Real, scale};
use crate::solvers::implicit::cpu::Implicit;
use crate::solvers::waiting;

impl<T: Real> Implicit<T> {
    /// Adds to the forces on a tile what makes of its velocities those that were solved for.
    pub(crate) fn add_changes(&self, tile: &mut Tile<'_, T>) {
        let colliders = self.colliders(tile.substep);
        // That of the system, whose impulses pins hold against.
        let h = tile.substep.scheme().map_or(tile.substep.h, |scheme| scheme.h);
        // SAFETY: found before a barrier.
        let (change, impulse) = unsafe { (self.work.change.read(), self.work.impulse.read()) };
        for (at, run) in tile.plan.runs() {
            for place in run.clone() {
                if tile.nodes.inverse_mass[place] <= T::ZERO {
                    let impulse: [T; 3] = impulse.at(place);
                    tile.add_force(at + place - run.start, scale(impulse, T::ONE / h));
                    continue;
                }
                let mut after: [T; 3] = change.at(place);
                if !colliders.is_empty() {
                    // SAFETY: as above.
                    let (predicted, collider) =
                        unsafe { (&self.work.predicted.read()[place], self.work.collider.read()[place]) };
                    if predicted.in_contact() {
                        let surface = &colliders.at(place)[collider as usize].surface;
                        after = predicted.with_contact(waiting::free_velocity(tile, place), after, surface);
                    }
                }
                let force = scale(after, tile.nodes.mass[place] / tile.substep.h);
                tile.add_force(at + place - run.start, force);
            }
        }
    }
}
