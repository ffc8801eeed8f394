//! How finely the sub-steps of a scene are cut: where surfaces come so fast that the filter of their contact takes much of a node's
//! way, what it takes shows as stretch. Shorter sub-steps find the contact in time, and the filter has nothing left to do.

use crate::assembly::Assembly;

/// What may be taken of a node's way in a sub-step, relative to an edge, and below which fewer parts may do.
const TOO_MUCH: f64 = 0.1;
const LITTLE: f64 = 0.04;
/// How fast nodes want to go through what they touch only where a scene blows up, and contact holds together what would fly apart: edges a
/// second. Impulses have taken most of what is to be taken in a collision before.
const BLOWN_UP: f64 = 2e5;
/// Frames of which so little is taken before fewer parts are tried.
pub const CALM_FRAMES: u32 = 4;

/// Into how many parts each sub-step of the scene is cut, and for how many frames they have been many enough. It goes from frame to
/// frame, and is part of a snapshot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refinement {
    /// Parts of each sub-step: a power of two.
    pub parts: u32,
    /// Frames of which little was taken, one after the other.
    pub calm: u32,
}

impl Default for Refinement {
    fn default() -> Self {
        Self { parts: 1, calm: 0 }
    }
}

impl Refinement {
    /// Whether a run can have come to it that may cut sub-steps into `most` parts.
    pub fn is_possible(self, most: u32) -> bool {
        self.parts.is_power_of_two() && self.parts <= most && self.calm < CALM_FRAMES
    }

    /// Notes what was `taken` at most of a node's way in a sub-step of a frame, relative to an edge, where sub-steps may be cut into `most`
    /// parts. Returns whether the frame is to be put back and repeated in more.
    pub fn note(&mut self, taken: f64, most: u32) -> bool {
        if taken > TOO_MUCH && self.parts < most {
            *self = Self { parts: 2 * self.parts, calm: 0 };
            return true;
        }
        self.calm = if taken < LITTLE && self.parts > 1 { self.calm + 1 } else { 0 };
        if self.calm == CALM_FRAMES {
            *self = Self { parts: self.parts / 2, calm: 0 };
        }
        false
    }
}

/// When it is in vain to go on with a frame: it is going to be repeated, or the scene has blown up.
#[derive(Clone, Copy, Debug)]
pub struct InVain {
    /// What must not be taken of a node's way in a sub-step, relative to an edge.
    most: f64,
    /// Whether the frame is repeated in more parts if more is taken.
    is_repeated: bool,
    /// Whether pins move, by the scene or by the program.
    pub pins_move: bool,
}

/// How much farther than they can come nodes want to go in a sub-step only where a scene blows up, though pins move: so many edges, and so
/// many times the way of a pin. Impulses between layers that a pin drags through what jams it have flung nodes by a thousand edges.
const FLUNG: [f64; 2] = [1e5, 100.0];

impl InVain {
    /// Every frame goes to its end.
    pub const NEVER: Self = Self { most: f64::INFINITY, is_repeated: false, pins_move: false };

    /// In a frame of which the scene's sub-steps are cut into `parts`.
    pub fn of(assembly: &Assembly, parts: u32, program_moves_pins: bool) -> Self {
        let time = &assembly.time;
        let is_repeated = parts < time.most_parts();
        let most = if is_repeated { TOO_MUCH } else { BLOWN_UP * time.longest_step() / f64::from(parts) };
        Self { most, is_repeated, pins_move: program_moves_pins || !assembly.moving_pins().is_empty() }
    }

    /// What must not be taken of a node's way in a sub-step, relative to an edge. A pin that was held back pulls what is in its way with the
    /// velocity that makes up for it: so where pins move, what is taken tells no blow-up.
    pub fn taken(&self) -> f64 {
        if self.pins_move && !self.is_repeated { f64::INFINITY } else { self.most }
    }

    /// How much farther than it can come a node may want to go in a sub-step [m], where an edge has that length and a pin goes as far
    /// as `pin` at most.
    pub fn farther(&self, edge: f64, pin: f64) -> f64 {
        let [edges, pins] = if self.pins_move && !self.is_repeated { FLUNG } else { [0.0; 2] };
        (self.most + edges) * edge + pins * pin
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_repeated_until_little_is_taken_or_parts_are_many() {
        let mut refinement = Refinement::default();
        let taken = |parts: u32| 0.5 / f64::from(parts);
        let repeats = (0..9).take_while(|_| refinement.note(taken(refinement.parts), 16)).count();
        assert_eq!((repeats, refinement.parts), (3, 8));
        let mut jammed = Refinement::default();
        let repeats = (0..9).take_while(|_| jammed.note(5.0, 16)).count();
        assert_eq!((repeats, jammed.parts), (4, 16));
    }

    #[test]
    fn parts_become_fewer_after_calm_frames_in_a_row() {
        let mut refinement = Refinement { parts: 4, calm: 0 };
        let mut frames = |taken: &[f64]| {
            taken
                .iter()
                .for_each(|&taken| assert!(!refinement.note(taken, 16) && refinement.is_possible(16)));
            refinement.parts
        };
        assert_eq!(frames(&[0.0, 0.0, 0.0, 0.05, 0.0, 0.0, 0.0]), 4);
        assert_eq!(frames(&[0.0]), 2);
        assert_eq!(frames(&[0.0; 9]), 1);
    }

    #[test]
    fn a_scene_that_takes_nothing_stays_as_it_is() {
        let mut refinement = Refinement::default();
        (0..99).for_each(|_| assert!(!refinement.note(0.0, 16)));
        assert_eq!(refinement, Refinement::default());
    }
}
