//! What springs that are solved for by nodes give a tile.

use crate::cpu::tile::CpuTile;
use crate::real::{Real, scale};
use std::ops::Range;

impl<T: Real> CpuTile<'_, T> {
    /// Adds the force that makes of velocities what was solved for, to the forces of a run of nodes, the first of which is the
    /// tile's `at`-th.
    pub(crate) fn add_changes(&mut self, at: usize, run: &Range<usize>) {
        let Some(primal) = &self.setup.primal else { return };
        let pressed = !primal.colliders(self.substep).is_empty();
        // SAFETY: found before a barrier.
        let change = unsafe { self.primal.change.read() };
        for place in run.clone() {
            let mut after: [T; 3] = change.at(place);
            if pressed {
                // SAFETY: as above.
                let (press, surface) =
                    unsafe { (&self.primal.press.read()[place], self.primal.surface.read()[place]) };
                if press.normal != [T::ZERO; 3] {
                    after = self.borne(place, (press, surface), after);
                }
            }
            let force = scale(after, self.setup.mass[place] / self.substep.h);
            for (column, force) in self.scratch.force.iter_mut().zip(force) {
                column[at + place - run.start] += force;
            }
        }
    }
}
