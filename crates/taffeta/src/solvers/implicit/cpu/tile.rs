//! What springs that are integrated implicitly give a tile.

use crate::cpu::tile::Tile;
use crate::real::{Real, scale};
use crate::solvers::implicit::cpu::Implicit;
use crate::solvers::waiting;

impl<T: Real> Implicit<T> {
    /// Adds to the forces on a tile what makes of its velocities those that were solved for.
    pub(crate) fn add_changes(&self, tile: &mut Tile<'_, T>) {
        let pressed = !self.colliders(tile.substep).is_empty();
        // SAFETY: found before a barrier.
        let change = unsafe { self.work.change.read() };
        for (at, run) in tile.plan.runs() {
            for place in run.clone() {
                let mut after: [T; 3] = change.at(place);
                if pressed {
                    // SAFETY: as above.
                    let (press, surface) =
                        unsafe { (&self.work.press.read()[place], self.work.surface.read()[place]) };
                    if press.is_pressed() {
                        let touching = &tile.substep.colliders[surface as usize].touching;
                        after = press.borne(waiting::free_velocity(tile, place), after, touching);
                    }
                }
                let force = scale(after, tile.nodes.mass[place] / tile.substep.h);
                tile.add_force(at + place - run.start, force);
            }
        }
    }
}
