//! Pairs of clusters that are near each other, each with how far its nodes are from touching.
//!
//! What two clusters may have moved against each other since they were looked at is known without looking at their nodes;
//! until that has used up the distance that they had, none of their nodes touch. And no pair can have used up more than
//! all nodes together: each has a time, in metres of that, before which nobody asks for it.

use super::apart::Mask;
use super::clusters::Packed;
use crate::cpu::simd::Kernel;
use crate::real::{Real, dot, sub};
use crate::topology::LANES;

/// Two clusters.
#[derive(Clone, Copy, Debug)]
pub struct Watched {
    /// Which ones, the second not before the first.
    pub clusters: [u32; 2],
    /// Number of the mask of nodes that do not touch.
    pub mask: u32,
    /// Distance of their nodes when they were looked at, less that at which they touch [m].
    gap: f64,
    /// What they had moved against each other by then, and off that [m].
    moved: [f64; 4],
}

/// Pairs, and when each is due.
#[derive(Default)]
pub struct Watch {
    pub pairs: Vec<Watched>,
    due: Vec<f64>,
}

impl Watch {
    pub fn clear(&mut self) {
        self.pairs.clear();
        self.due.clear();
    }

    /// Adds a pair whose nodes have so far to go [m] before they touch. Nothing has moved yet.
    pub fn add(&mut self, clusters: [u32; 2], mask: u32, gap: f64) {
        self.pairs.push(Watched { clusters, mask, gap, moved: [0.0; 4] });
        self.due.push(gap);
    }

    /// What is left of a pair's distance [m], when its clusters have moved. What is no number has none left.
    pub fn left(&self, at: usize, moved: &[[f64; 4]]) -> f64 {
        let pair = &self.pairs[at];
        let now = pair.moved_now(moved);
        let by = [0, 1, 2, 3].map(|i| now[i] - pair.moved[i]);
        pair.gap - dot([by[0], by[1], by[2]], [by[0], by[1], by[2]]).sqrt() - by[3]
    }

    /// Asks for a pair again when all have moved by `left` [m].
    pub fn wait(&mut self, at: usize, travelled: f64, left: f64) {
        self.due[at] = travelled + left;
    }

    /// Notes how far the nodes of a pair are from touching [m].
    pub fn note(&mut self, at: usize, travelled: f64, gap: f64, moved: &[[f64; 4]]) {
        let pair = &mut self.pairs[at];
        (pair.gap, pair.moved) = (gap, pair.moved_now(moved));
        self.wait(at, travelled, gap);
    }
}

impl Watched {
    fn moved_now(&self, moved: &[[f64; 4]]) -> [f64; 4] {
        let [a, b] = self.clusters.map(|cluster| &moved[cluster as usize]);
        [a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] + b[3]]
    }
}

/// Kernel: finds the pairs that are due.
pub struct Due<'a> {
    pub watch: &'a Watch,
    /// How far all have moved against each other [m].
    pub travelled: f64,
    /// Where their numbers go.
    pub found: &'a mut Vec<u32>,
}

impl Kernel for Due<'_> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { watch, travelled, found } = self;
        found.clear();
        // What is no number is due.
        let is_due = |due: f64| {
            let is_later = travelled < due;
            !is_later
        };
        for (chunk, due) in (0..).step_by(LANES).zip(watch.due.chunks(LANES)) {
            let any = due.iter().fold(false, |any, &due| any | is_due(due));
            if any {
                found.extend((chunk..).zip(due).filter(|(_, due)| is_due(**due)).map(|(at, _)| at));
            }
        }
    }
}

/// Kernel: least squared distance of nodes of two clusters that may touch [m²].
pub struct Least<'a, T> {
    pub packed: [&'a Packed<T>; 2],
    pub mask: &'a Mask,
}

impl<T: Real> Kernel for Least<'_, T> {
    type Output = T;
    #[inline(always)]
    fn run(self) -> T {
        let mask = self.mask.map(u32::from);
        let mut least = [T::FAR; LANES];
        for row in 0..LANES {
            let squared = squares(self.packed, row);
            for lane in 0..LANES {
                let nearer = squared[lane] < least[lane] && mask[lane] & (1 << row) == 0;
                least[lane] = if nearer { squared[lane] } else { least[lane] };
            }
        }
        least.into_iter().fold(T::FAR, |all, one| if one < all { one } else { all })
    }
}

/// Kernel: which nodes of two clusters are nearer than `reach` [m].
pub struct Touching<'a, T> {
    pub packed: [&'a Packed<T>; 2],
    pub mask: &'a Mask,
    pub reach: T,
}

impl<T: Real> Kernel for Touching<'_, T> {
    /// By lane of the first, one bit for each lane of the second.
    type Output = [u16; LANES];
    #[inline(always)]
    fn run(self) -> [u16; LANES] {
        let (mask, reach) = (self.mask.map(u32::from), self.reach * self.reach);
        let mut touching = [0_u16; LANES];
        for (row, touching) in touching.iter_mut().enumerate() {
            let squared = squares(self.packed, row);
            let mut bits = 0_u32;
            for lane in 0..LANES {
                let near = squared[lane] < reach && mask[lane] & (1 << row) == 0;
                bits |= u32::from(near) << lane;
            }
            *touching = bits as u16;
        }
        touching
    }
}

/// Squared distances of a node of the first cluster from those of the second [m²].
#[inline(always)]
fn squares<T: Real>([a, b]: [&Packed<T>; 2], row: usize) -> [T; LANES] {
    let own = a.0.each_ref().map(|axis| axis[row]);
    std::array::from_fn(|lane| {
        let d = sub(own, [b.0[0][lane], b.0[1][lane], b.0[2][lane]]);
        dot(d, d)
    })
}
