//! Nodes that follow keyframes, by solver index.

use crate::assembly::Assembly;
use crate::motion::keyframes::Track;
use crate::motion::pins::Motion;
use crate::plan::Substep;
use crate::real::Real;
use std::collections::BTreeMap;

/// A node that follows keyframes.
#[derive(Clone, Copy, Debug)]
pub struct MovingPin {
    /// Solver index.
    pub node: u32,
    /// Which of the tracks.
    pub track: u32,
    /// Where it starts [m].
    pub start: [f64; 3],
}

/// The pins of a scene that move.
#[derive(Default)]
pub struct MovingPins {
    /// Ascending by solver index, each node once.
    pub pins: Vec<MovingPin>,
    /// The motions that they follow.
    pub tracks: Vec<Track>,
    /// Which of the tracks a pin follows, by body and pin.
    pub track_of_pin: BTreeMap<(usize, usize), usize>,
}

impl Assembly {
    /// Pins that move.
    pub fn moving_pins(&self) -> &[MovingPin] {
        self.extensions.get::<MovingPins>().map_or(&[], |moving| &moving.pins)
    }

    /// The motions that pins follow.
    pub fn tracks(&self) -> &[Track] {
        self.extensions.get::<MovingPins>().map_or(&[], |moving| &moving.tracks)
    }

    pub(crate) fn moving_mut(&mut self) -> &mut MovingPins {
        self.extensions.get_mut()
    }

    /// Which of the tracks a pin follows.
    pub fn track_of_pin(&self, body: usize, pin: usize) -> Option<usize> {
        self.extensions.get::<MovingPins>()?.track_of_pin.get(&(body, pin)).copied()
    }
}

/// The motion of each track over a sub-step.
pub fn parameters<T: Real>(assembly: &Assembly, [t, h]: [f64; 2], substep: &mut Substep<T>) {
    let motion = |track: &Track| Motion::<T>::new(&track.pose(t), &track.pose(t + h), h);
    substep.extensions.insert_list(assembly.tracks().iter().map(motion).collect());
}

impl<T: Real> Substep<T> {
    /// Motion of each track.
    pub fn motions(&self) -> &[Motion<T>] {
        self.extensions.list()
    }
}
