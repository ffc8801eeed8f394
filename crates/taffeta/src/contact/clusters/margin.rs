//! When pairs of groups are searched for: with a margin, that lasts until nodes have moved by it against each other.

use crate::real::{dot, sub};
use crate::topology::boxes::Bounds;
use std::ops::Range;

/// Margin of a search, relative to the size of a group: the first one, the least, the most.
const MARGIN: [f64; 3] = [0.6, 0.3, 3.0];
/// Sub-steps between searches. With fewer the margin grows, with more it shrinks.
const REST: Range<u32> = 16..64;

/// What is left of the last search.
#[derive(Debug, Default)]
pub struct Margin {
    /// Its margin [m]; 0: there was none.
    margin: f64,
    /// Bound of the relative motion of all nodes since then [m].
    travelled: f64,
    /// Sub-steps since then.
    rest: u32,
    /// Searches in this frame.
    pub searches: u64,
}

impl Margin {
    /// The margin [m].
    pub fn margin(&self) -> f64 {
        self.margin
    }

    /// Adds a sub-step whose motion has such bounds [m].
    pub fn add(&mut self, motion: Bounds) {
        self.travelled += extent(motion);
        self.rest += 1;
    }

    /// Whether all pairs of groups are listed that are nearer than `reach` [m] beyond contact.
    pub fn covers(&self, reach: f64) -> bool {
        // With a margin for rounding; a NaN is not covered.
        self.travelled + reach < self.margin * 0.999
    }

    /// Chooses the margin of a search that must cover `reach` [m], for groups of a size [m]. It is wider if searches are frequent.
    pub fn choose(&mut self, size: f64, reach: f64) {
        let [first, least, most] = MARGIN.map(|factor| factor * size);
        let margin = match self.margin {
            margin if margin <= 0.0 => first,
            margin if self.rest < REST.start => (margin * 1.25).min(most),
            margin if self.rest >= REST.end => (margin * 0.8).max(least),
            margin => margin,
        };
        // At least as much again as it must cover now; what is lost is near nothing.
        let wanted = if reach < f64::INFINITY { 2.0 * reach } else { most };
        self.margin = if wanted > margin { wanted } else { margin };
        (self.travelled, self.rest) = (0.0, 0);
        self.searches += 1;
    }

    /// Has the next sub-step search.
    pub fn forget(&mut self) {
        self.margin = 0.0;
    }
}

/// Diagonal of bounds.
pub fn extent([least, most]: Bounds) -> f64 {
    let along = sub(most, least);
    dot(along, along).sqrt()
}
