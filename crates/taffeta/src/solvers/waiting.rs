//! Tiles that wait for a solver: where their forces are meanwhile, and how those that were solved for act on nodes that
//! surfaces hold.

use crate::contact::colliders::press::Press;
use crate::cpu::tile::Tile;
use crate::motion::cpu::Pins;
use crate::real::{Real, sub};
use crate::solvers::explicit::cpu::Euler;

/// Keeps the forces on a tile for later, and the velocity that they alone would give. The state after waits for both: the
/// velocity lies where positions will be, the force where velocities will be.
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

/// Takes up the forces that wait.
pub fn resume<T: Real>(tile: &mut Tile<'_, T>) {
    for (at, run) in tile.plan.runs() {
        let [_, _, _, force @ ..] = tile.after(&run);
        for (to, from) in tile.scratch.force.iter_mut().zip(force) {
            to[at..at + run.len()].copy_from_slice(from);
        }
    }
}

/// A change of a node's velocity with what the surface that holds it does about it.
pub fn borne<T: Real>(
    tile: &Tile<'_, T>,
    place: usize,
    (press, surface): (&Press<T>, u32),
    change: [T; 3],
) -> [T; 3] {
    // SAFETY: waits where the state after will be, for this tile alone.
    let free = [0, 1, 2].map(|axis| unsafe { *tile.next[axis].item(place) });
    sub(press.after(free, change, &tile.substep.colliders[surface as usize].touching), free)
}
