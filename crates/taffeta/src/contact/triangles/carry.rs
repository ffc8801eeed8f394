//! Colliders that move: what is in their way goes along, before nodes go where they would end.
//!
//! A collider goes all its way, so a plane between it and cloth that stands still may not exist. Here its motion is made first,
//! in parts, with all nodes at rest but those in its way: these are pushed along the normal as far as they must, and push others
//! in their way in turn. Afterwards colliders are at rest, and the filter keeps nodes apart from them as from all else. Only
//! what is pinned, or between two colliders, cannot give way.

use crate::contact::triangles::filter::reach_together;
use crate::contact::triangles::surfaces::Corners;
use crate::real::{Real, add, dot, sub};
use std::ops::Range;

/// How far corners go in one part of their motion, relative to the least thickness, and how many parts there are at most.
const PART: f64 = 0.5;
const PARTS: f64 = 64.0;
/// The longest way along an axis that nodes are pushed in a part, relative to the longest way of a corner in it.
const LONGEST: f64 = 2.0;
/// How often nodes that are pushed push others in one part.
pub const PUSHES: usize = 64;

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
    fn corners_go_in_parts_of_half_the_least_thickness() {
        assert_eq!(parts_of(0.0, 0.01), 0);
        assert_eq!(parts_of(1e-9, 0.01), 1);
        assert_eq!(parts_of(0.0051, 0.01), 2);
        assert_eq!(parts_of(9.0, 0.01), 64);
    }
}
