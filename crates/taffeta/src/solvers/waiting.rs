//! Tiles that wait for a solver, and the storage of their forces.

use crate::cpu::tile::Tile;
use crate::motion::cpu::Pins;
use crate::real::Real;
use crate::solvers::explicit::cpu::Euler;

/// Stores the forces on a tile, and the velocity that they alone would give. The state after holds both: the velocity
/// is where positions will be, the force where velocities will be.
pub fn suspend<T: Real>(tile: &Tile<'_, T>) {
    Euler::apply(tile);
    if let Some(pins) = tile.features.get::<Pins>() {
        pins.apply(tile);
    }
    for (at, run) in tile.plan.runs() {
        let [x, y, z, u, v, w] = tile.after(&run);
        for (axis, (velocity, force)) in [(x, u), (y, v), (z, w)].into_iter().enumerate() {
            velocity.copy_from_slice(force);
            force.copy_from_slice(&tile.scratch.force[axis][at..at + run.len()]);
        }
    }
}

/// Restores the stored forces.
pub fn resume<T: Real>(tile: &mut Tile<'_, T>) {
    for (at, run) in tile.plan.runs() {
        let [_, _, _, force @ ..] = tile.after(&run);
        for (to, from) in tile.scratch.force.iter_mut().zip(force) {
            to[at..at + run.len()].copy_from_slice(from);
        }
    }
}

/// The velocity of a place of a waiting tile, without the forces of the solver.
pub fn free_velocity<T: Real>(tile: &Tile<'_, T>, place: usize) -> [T; 3] {
    // SAFETY: waits where the state after will be, for this tile alone.
    [0, 1, 2].map(|axis| unsafe { *tile.next[axis].item(place) })
}
