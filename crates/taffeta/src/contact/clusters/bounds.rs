//! Bounds of motion: pairs of groups and pairs of clusters, with the distance that they can move before they are
//! checked again.
//!
//! The relative motion of two clusters since their last check has a bound that needs no node. Until it exceeds their
//! distance at that check, none of their nodes are in contact. No two clusters can have moved more than their groups.
//! So each pair has a due distance of the groups' motion, before which it is not checked.

use crate::contact::clusters::packed::{GROUP, Packed};
use crate::contact::clusters::tree::{Boxes, squared_distance};
use crate::cpu::simd::Kernel;
use crate::real::{Real, dot, sub};

/// A pair of groups, with pairs of their clusters.
pub struct GroupPair<P> {
    /// The groups, the second not before the first.
    pub groups: [u32; 2],
    /// Bound of the relative motion of their nodes since the search [m].
    pub travelled: f64,
    /// The motion at which one of its pairs of clusters is checked [m].
    pub due: f64,
    /// The motion at which clusters outside the list may have come near each other [m].
    pub fresh: f64,
    /// Pairs of clusters that are near each other, ascending.
    pub pairs: Vec<P>,
}

/// A pair of clusters.
#[derive(Clone, Copy, Debug)]
pub struct ClusterPair {
    /// The clusters, the second not before the first.
    pub clusters: [u32; 2],
    /// Number of their exclusion mask.
    pub mask: u32,
    /// Distance of their nodes at the last check, less the contact distance [m].
    gap: f64,
    /// Their relative motion at that check, and its radius [m].
    moved: [f64; 4],
    /// The motion of the groups at which it is checked [m].
    pub due: f64,
}

impl<P> GroupPair<P> {
    /// A pair at the time of a search, with an empty list.
    pub fn new(groups: [u32; 2], pairs: Vec<P>) -> Self {
        Self { groups, travelled: 0.0, due: 0.0, fresh: 0.0, pairs }
    }

    /// Adds the motion of a sub-step. Returns whether a pair has to be checked.
    #[inline]
    pub fn is_due(&mut self, balls: &[[f64; 4]]) -> bool {
        let [a, b] = self.groups.map(|group| &balls[group as usize]);
        self.travelled += approach(a, b);
        is_over(self.travelled, self.due)
    }
}

/// How much nearer nodes come to each other, at most, that move as two balls say [m].
#[inline]
pub fn approach(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    let off = sub([a[0], a[1], a[2]], [b[0], b[1], b[2]]);
    dot(off, off).sqrt() + a[3] + b[3]
}

/// Whether a due distance has been reached. A NaN has reached it.
#[inline]
pub fn is_over(now: f64, due: f64) -> bool {
    let is_later = now < due;
    !is_later
}

impl ClusterPair {
    /// A pair whose nodes are so far [m] from contact.
    pub fn new(clusters: [u32; 2], mask: u32, gap: f64, travelled: f64, moved: &[[f64; 4]]) -> Self {
        let mut pair = Self { clusters, mask, gap, moved: [0.0; 4], due: 0.0 };
        pair.note(gap, travelled, moved);
        pair
    }

    /// What is left of its distance [m]. A NaN leaves none.
    #[inline]
    pub fn left(&self, moved: &[[f64; 4]]) -> f64 {
        let now = self.moved_now(moved);
        let by = [now[0] - self.moved[0], now[1] - self.moved[1], now[2] - self.moved[2]];
        self.gap - dot(by, by).sqrt() - (now[3] - self.moved[3])
    }

    /// Sets how far its nodes are from contact [m].
    pub fn note(&mut self, gap: f64, travelled: f64, moved: &[[f64; 4]]) {
        (self.gap, self.moved, self.due) = (gap, self.moved_now(moved), travelled + gap);
    }

    #[inline]
    fn moved_now(&self, moved: &[[f64; 4]]) -> [f64; 4] {
        let [a, b] = self.clusters.map(|cluster| &moved[cluster as usize]);
        [a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] + b[3]]
    }
}

/// Kernel: squared distances of the boxes of the clusters of two groups [m²].
pub struct Distances<'a, T> {
    pub packed: [&'a [Packed<T>]; 2],
    pub squared: &'a mut [[T; GROUP]; GROUP],
}

impl<T: Real> Kernel for Distances<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let [first, second] = self.packed.map(Boxes::of);
        for (row, squared) in self.squared.iter_mut().enumerate() {
            let bound = first.lane(row);
            for (lane, squared) in squared.iter_mut().enumerate() {
                *squared = squared_distance(&bound, &second.lane(lane));
            }
        }
    }
}
