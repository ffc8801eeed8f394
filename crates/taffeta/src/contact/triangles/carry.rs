//! Colliders that move: what is in their way goes along, before nodes go where they would end.
//!
//! A collider goes all its way, so a plane between it and cloth that stands still may not exist. Here its motion is made first,
//! in parts, with all nodes at rest but those in its way: these are pushed along the normal as far as they must, and push others
//! in their way in turn. Afterwards colliders are at rest, and the filter keeps nodes apart from them as from all else.
//!
//! Where pushes come to no end, layers lie between colliders, and have to come nearer to each other than pushes keep them: all
//! nodes are put back, and pushed again with half of each distance left ([`Phase`]). What is pinned, or has no room even then, cannot
//! give way. There nodes that would pass through another surface of nodes stop, those that come behind them too, and a collider
//! may pierce what is before it.

use crate::contact::triangles::filter::reach_together;
use crate::contact::triangles::surfaces::Corners;
use crate::real::{Real, add, dot, sub};
use std::ops::Range;

/// How far corners go in one part of their motion, relative to the least thickness, and how many parts there are at most.
const PART: f64 = 0.5;
const PARTS: f64 = 64.0;
/// The longest way along an axis that nodes are pushed in a part, relative to the longest way of a corner in it.
const LONGEST: f64 = 2.0;
/// Rounds of pushes in one part at most; after how many less of each distance is kept, and after how many nodes stop.
pub const PUSHES: usize = 64;
pub const FIRST_PUSHES: usize = 32;
pub const FIRST_STOP: usize = 48;

/// What is done in a round of pushes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Nodes are pushed so that most of each distance is left.
    Push = 0,
    /// Nodes are put back, for that came to no end.
    Restart = 1,
    /// Nodes are pushed so that half of each distance is left.
    Squeeze = 2,
    /// Nodes that would pass through another surface of nodes stop, for that came to no end. In the last round all that might do.
    Stop = 3,
    Over = 4,
}

/// What a round of pushes came to.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pushed {
    /// Whether some nodes went on, or stopped.
    pub moved: bool,
    /// One more than the last node of a side that was pushed and is not pinned; 0 if there is none. What is pinned in part never
    /// gives way, so it is not waited for.
    pub waiting: u32,
}

impl Pushed {
    /// What two workers came to.
    pub fn join(self, other: Self) -> Self {
        Self { moved: self.moved || other.moved, waiting: self.waiting.max(other.waiting) }
    }
}

impl Phase {
    /// What is done after a round of this, by its number.
    pub fn next(self, round: usize, pushed: Pushed) -> Self {
        let after = |rounds: usize, next: Self| match pushed.moved && round + 1 < rounds {
            true => self,
            false if pushed.waiting > 0 => next,
            false => Self::Over,
        };
        match self {
            Self::Push => after(FIRST_PUSHES, Self::Restart),
            Self::Restart => Self::Squeeze,
            Self::Squeeze => after(FIRST_STOP, Self::Stop),
            Self::Stop if pushed.moved && round + 1 < PUSHES => Self::Stop,
            Self::Stop | Self::Over => Self::Over,
        }
    }
}

/// The longest way of some corners [m].
pub fn longest_way<T: Real>(corners: &Corners<T>, some: Range<usize>) -> f64 {
    let way = |corner: usize| sub(corners.after[corner], corners.before[corner]);
    some.map(|corner| dot(way(corner), way(corner)).to_f64()).fold(0.0, f64::max).sqrt()
}

/// In how many parts corners go that go up to `most` [m], where surfaces are at least `thinnest` [m] apart.
pub fn parts_of(most: f64, thinnest: f64) -> u32 {
    if most > 0.0 { (most / (PART * thinnest)).ceil().clamp(1.0, PARTS) as u32 } else { 0 }
}

/// The longest way along each axis that nodes are pushed in one of these parts [m].
pub fn longest_push(most: f64, parts: u32) -> f64 {
    LONGEST * most / f64::from(parts)
}

/// How much nearer than by their own motion pairs may come by pushes up to `longest` along each axis [m]: both sides may be pushed.
pub fn reach_of_pushes(longest: f64) -> f64 {
    reach_together(2.0 * 3_f64.sqrt() * longest)
}

/// What two pushes [m] come to: along each axis the longer one, and of two that are as long that towards +. So their order does
/// not matter.
pub fn farther<T: Real>(one: [T; 3], other: [T; 3]) -> [T; 3] {
    std::array::from_fn(|axis| {
        let (one, other) = (one[axis], other[axis]);
        let is_longer = other.abs() > one.abs() || other.abs() == one.abs() && other > one;
        if is_longer { other } else { one }
    })
}

/// A way with a push behind it, along each axis no longer than `most` [m].
pub fn go_on<T: Real>(way: [T; 3], push: [T; 3], most: T) -> [T; 3] {
    add(way, push).map(|along| {
        let along = if along < most { along } else { most };
        if along > -most { along } else { -most }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pushes_come_to_the_same_in_any_order() {
        let [a, b, c] = [[0.1, -0.3, 0.0], [-0.1, 0.2, -0.0], [0.05, -0.3, 0.2]];
        assert_eq!(farther(farther(a, b), c), [0.1, -0.3, 0.2]);
        assert_eq!(farther(c, farther(b, a)), [0.1, -0.3, 0.2]);
        assert_eq!(farther(b, a), farther(a, b));
    }

    #[test]
    fn pushes_that_come_to_no_end_are_over_in_time() {
        let moved = |moved: bool, waiting: u32| Pushed { moved, waiting };
        for (pushed, counts) in [(moved(true, 3), [32, 1, 15, 16]), (moved(false, 3), [1, 1, 1, 1])] {
            let mut phases = vec![Phase::Push];
            while phases[phases.len() - 1] != Phase::Over {
                let round = phases.len() - 1;
                phases.push(phases[round].next(round, pushed));
            }
            let count = |phase| phases.iter().filter(|&&one| one == phase).count();
            assert_eq!([Phase::Push, Phase::Restart, Phase::Squeeze, Phase::Stop].map(count), counts);
            assert!(phases.len() - 1 <= PUSHES, "{}", phases.len());
        }
        assert_eq!(Phase::Push.next(5, moved(false, 0)), Phase::Over);
        assert_eq!(Phase::Squeeze.next(40, moved(false, 0)), Phase::Over);
        // Neighbours of pins may go on, but are not waited for.
        assert_eq!(Phase::Push.next(5, moved(true, 0)), Phase::Push);
        assert_eq!(Phase::Push.next(31, moved(true, 0)), Phase::Over);
    }

    #[test]
    fn corners_go_in_parts_of_half_the_least_thickness() {
        assert_eq!(parts_of(0.0, 0.01), 0);
        assert_eq!(parts_of(1e-9, 0.01), 1);
        assert_eq!(parts_of(0.0051, 0.01), 2);
        assert_eq!(parts_of(9.0, 0.01), 64);
    }
}
