//! Moving pins on the CPU.

use crate::cpu::feature::Feature;
use crate::cpu::tile::{Tile, within};
use crate::motion::moving::MovingPin;
use crate::motion::pins::{catching_up, on_the_way};
use crate::real::Real;
use crate::step::Op;

/// Nodes that follow keyframes; those that the user moves come with each frame.
pub struct Pins {
    moving: Vec<MovingPin>,
}

impl Pins {
    /// Those of a scene, ascending by node.
    pub fn new(moving: &[MovingPin]) -> Self {
        Self { moving: moving.to_vec() }
    }

    /// Moves the pinned nodes of a tile.
    pub fn apply<T: Real>(&self, tile: &Tile<'_, T>) {
        if self.moving.is_empty() && tile.input.moves.is_empty() {
            return;
        }
        let motions = tile.substep.motions();
        for (_, run) in tile.plan.runs() {
            for pin in within(&self.moving, &run, |pin| pin.node) {
                let motion = &motions[pin.track as usize];
                let start = pin.start.map(T::from_f64);
                put(tile, pin.node, start, motion.apply(start));
            }
            for &(node, from, to) in within(&tile.input.moves, &run, |&(node, ..)| node) {
                let (fraction, rate) = tile.substep.frame_fraction;
                let [from, to] = [from, to].map(|x| x.map(T::from_f64));
                put(tile, node, from, on_the_way(from, to, fraction, rate));
            }
        }
    }
}

/// Moves a pinned node, with the velocity of its way.
fn put<T: Real>(tile: &Tile<'_, T>, node: u32, start: [T; 3], (position, velocity): ([T; 3], [T; 3])) {
    let node = node as usize;
    let velocity = if tile.substep.pins_may_lag {
        let before = [0, 1, 2].map(|axis| tile.old[axis][node]);
        catching_up((position, velocity), start, before, tile.substep.h)
    } else {
        velocity
    };
    let state = tile.after(&(node..node + 1));
    for axis in 0..3 {
        state[axis][0] = position[axis];
        state[3 + axis][0] = velocity[axis];
    }
}

impl<T: Real> Feature<T> for Pins {
    fn ops(&self) -> &'static [Op] {
        &[Op::Pins]
    }

    fn tile(&self, _: Op, tile: &mut Tile<'_, T>) {
        self.apply(tile);
    }
}
