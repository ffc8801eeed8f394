//! Ear clipping (Meisters, Polygons have ears, 1975), in about n log n steps: only blunt corners can lie within an ear, a
//! tree finds them, and a corner that is no ear is tried again when the one that blocks it is gone.

use super::blunt::Blunt;
use super::plane::Point;
use super::{FLAT, longest, square, turn};
use std::collections::VecDeque;

/// No corner, or the end of a list.
const NONE: u32 = u32::MAX;
/// How often all corners are tried again, without tolerance, before a polygon counts as crossing itself. One time does
/// unless corners touch edges.
const ROUNDS: usize = 4;

/// A polygon that is being cut up.
#[derive(Default)]
pub(super) struct Ears {
    points: Vec<Point>,
    next: Vec<u32>,
    before: Vec<u32>,
    blunt: Blunt,
    /// Area of an ear relative to its longest edge squared, at least.
    flat: f64,
    /// Corners to try, and how often each had been put in by then: only its last entry counts.
    queue: VecDeque<(u32, u32)>,
    entries: Vec<u32>,
    /// The blunt corner that each corner waits for.
    blocker: Vec<u32>,
    /// For each blunt corner, its first in `waits`: a corner that waits for it, and the next entry.
    first_wait: Vec<u32>,
    waits: Vec<(u32, u32)>,
    /// Boxes that may still be looked at. Polygons that cross themselves a thousand times would take them without end.
    pub effort: u64,
}

impl Ears {
    /// Takes the corners of a polygon, at least three, counter-clockwise.
    pub fn load(&mut self, points: impl Iterator<Item = Point>) {
        self.points.clear();
        self.points.extend(points);
        let count = self.points.len() as u32;
        self.next.clear();
        self.next.extend((1..count).chain([0]));
        self.before.clear();
        self.before.extend([count - 1].into_iter().chain(0..count - 1));
        for (list, value) in [(&mut self.entries, 0), (&mut self.blocker, NONE), (&mut self.first_wait, NONE)]
        {
            list.clear();
            list.resize(count as usize, value);
        }
        self.restart(0, FLAT);
    }

    /// Cuts ears off until three corners are left. Whether all triangles are the right way round: a polygon that crosses
    /// itself has no ear in the end. Then this stops, or, by `force`, any corner goes.
    pub fn cut(&mut self, force: bool, mut triangle: impl FnMut([u32; 3])) -> bool {
        let (mut at, mut rounds, mut whole) = (0, 0, true);
        for _ in 3..self.points.len() {
            let mut ear = self.next_ear();
            while ear.is_none() && rounds < ROUNDS {
                rounds += 1;
                self.restart(at, 0.0);
                ear = self.next_ear();
            }
            whole &= ear.is_some() && self.effort > 0;
            if !whole && !force {
                return false;
            }
            let corner = ear.unwrap_or(at);
            triangle(self.corners(corner));
            at = self.next[corner as usize];
            self.remove(corner);
        }
        let [a, b, c] = self.triangle(at);
        triangle(self.corners(at));
        whole && turn(a, b, c) >= -FLAT * longest(a, b, c)
    }

    /// Tries all corners, from `start` on.
    fn restart(&mut self, start: u32, flat: f64) {
        self.flat = flat;
        let mut tree = std::mem::take(&mut self.blunt);
        let around = Around { next: &self.next, start, at: Some(start) };
        tree.hold(&self.points, around.clone().filter(|&corner| !self.bulges(corner)));
        self.blunt = tree;
        self.queue.clear();
        self.waits.clear();
        self.first_wait.fill(NONE);
        for corner in around {
            self.queue.push_back((corner, self.entries[corner as usize]));
        }
    }

    fn corners(&self, corner: u32) -> [u32; 3] {
        [self.before[corner as usize], corner, self.next[corner as usize]]
    }

    fn triangle(&self, corner: u32) -> [Point; 3] {
        self.corners(corner).map(|corner| self.points[corner as usize])
    }

    fn bulges(&self, corner: u32) -> bool {
        let [a, b, c] = self.triangle(corner);
        turn(a, b, c) > self.flat * longest(a, b, c)
    }

    fn next_ear(&mut self) -> Option<u32> {
        while let Some((corner, entry)) = self.queue.pop_front() {
            if self.entries[corner as usize] != entry {
                continue;
            }
            let triangle = self.triangle(corner);
            if !self.bulges(corner) {
                // At the end of all means, what goes back along itself is cut without an area.
                if self.flat == 0.0 && is_spike(triangle) {
                    return Some(corner);
                }
                continue;
            }
            let seed = (corner ^ entry.rotate_left(16)).wrapping_mul(0x9E37_79B9);
            let mut effort = self.effort;
            let found = self.blunt.find(triangle, seed, &mut effort, |blunt| self.blocks(blunt, triangle));
            self.effort = effort;
            let Some(blocker) = found else { return Some(corner) };
            self.blocker[corner as usize] = blocker;
            self.waits.push((corner, self.first_wait[blocker as usize]));
            self.first_wait[blocker as usize] = self.waits.len() as u32 - 1;
        }
        None
    }

    /// Whether a blunt corner forbids to cut the triangle off along its edge `c` to `a`.
    fn blocks(&self, blunt: u32, [a, b, c]: [Point; 3]) -> bool {
        let at = self.points[blunt as usize];
        let [ab, bc, ca] = [turn(a, b, at), turn(b, c, at), turn(c, a, at)];
        // A corner almost on the new edge would be left with a flat triangle.
        let near = self.flat * square(c, a);
        if ab < 0.0 || bc < 0.0 || ca < -near || at == a || at == c {
            return false;
        }
        if ab > 0.0 && bc > 0.0 {
            return true;
        }
        // It touches the polygon's own edges: from within?
        let [before, _, next] = self.triangle(blunt);
        [before, next].iter().any(|&p| (ab > 0.0 || turn(a, b, p) > 0.0) && (bc > 0.0 || turn(b, c, p) > 0.0))
    }

    fn remove(&mut self, corner: u32) {
        let [before, _, next] = self.corners(corner);
        (self.next[before as usize], self.before[next as usize]) = (next, before);
        self.entries[corner as usize] += 1;
        self.blocker[corner as usize] = NONE;
        if self.blunt.holds(corner) {
            self.unblock(corner);
        }
        for neighbour in [before, next] {
            if self.blunt.holds(neighbour) && self.bulges(neighbour) {
                self.unblock(neighbour);
            }
            self.enqueue(neighbour);
        }
    }

    /// Puts a corner last, so that ears are taken all around before any is taken at the same place again.
    fn enqueue(&mut self, corner: u32) {
        self.entries[corner as usize] += 1;
        self.blocker[corner as usize] = NONE;
        self.queue.push_back((corner, self.entries[corner as usize]));
    }

    /// Takes a corner out of the blunt ones; those that waited for it are tried again.
    fn unblock(&mut self, blunt: u32) {
        self.blunt.remove(blunt);
        let mut wait = std::mem::replace(&mut self.first_wait[blunt as usize], NONE);
        while wait != NONE {
            let (corner, next) = self.waits[wait as usize];
            if self.blocker[corner as usize] == blunt {
                self.enqueue(corner);
            }
            wait = next;
        }
    }
}

/// Whether the path turns back at `b`, or stays there.
fn is_spike([a, b, c]: [Point; 3]) -> bool {
    turn(a, b, c) == 0.0 && (a[0] - b[0]) * (c[0] - b[0]) + (a[1] - b[1]) * (c[1] - b[1]) >= 0.0
}

/// The corners that are left, once around.
#[derive(Clone)]
struct Around<'a> {
    next: &'a [u32],
    start: u32,
    at: Option<u32>,
}

impl Iterator for Around<'_> {
    type Item = u32;

    fn next(&mut self) -> Option<u32> {
        let at = self.at?;
        let next = self.next[at as usize];
        self.at = (next != self.start).then_some(next);
        Some(at)
    }
}
