//! The filter that keeps surfaces from passing through each other: the motion of the nodes of a pair ends before a plane
//! between its sides.
//!
//! Source: Chen et al., "Divide and Truncate", 2026, section 4 (Planar-DAT). The plane is put between the nodes as they are
//! projected on the normal, not between the closest points: so it separates them whatever the rounding of the normal.
//!
//! Ours is a plane that moves: where all four nodes go all their way, and are still apart along the normal at its end, nothing
//! is limited, for a plane that goes along separates them. So cloth that flies fast does not hold itself up. Where a node is
//! held back, its pairs are limited by planes that stand still, which hold for any part of the way of any node.

use crate::contact::triangles::closest::Pair;
use crate::real::{Real, dot, norm, scale, sub};

/// Part of its distance to the plane that a node may use up.
pub const SHARE: f64 = 0.85;
/// Least part of the gap that a side gets.
pub const LEAST: f64 = 0.05;
/// The least distance to the plane that is kept, relative to the extent of a pair. In 32 bits the normal of sides that are d
/// apart is off by about 2e-7 extent / d, and it must not tilt the plane into a side: that is 1 % of d here.
pub const SLENDER: f64 = 4e-3;
/// The least distance that is kept is at most this part of the thickness.
pub const THIN: f64 = 0.25;
/// The least distance to the plane that is kept, in units in the last place of positions.
pub const DIGITS: f64 = 16.0;

/// Part of the gap that must be left for a plane that goes along, beside twice the least distance.
pub const LEFT: f64 = 1.0 - SHARE;

/// Part of the thickness that a collider which moves leaves to what is in its way.
pub const ROOM_BEFORE: f64 = 0.5;

/// Part of its distance, and part of twice the least distance, that a pair keeps which is squeezed. Much nearer than that rounding
/// turns the normal too far to say anything.
pub const SQUEEZED_PART: f64 = 0.5;
pub const SQUEEZED_FLOOR: f64 = 0.25;
/// What it must keep by where a pair that is squeezed goes: so little farther that others keep their room.
pub const SQUEEZED_AHEAD: f64 = 0.98;

/// Stretch up to which the filter keeps its least distance of edges.
pub const STRETCH: f64 = 2.0;
/// How often nodes that are held back may hold back others before planes of all pairs stand still.
pub const JAMS: u32 = 16;
/// The rounds of a sub-step end when no node that has far to go gets farther by this, relative to the longest way of a round, and none
/// slides by as much.
pub const PROGRESS: f64 = 0.02;
/// How much nearer than it would pairs may come by impulses before they are looked at again, relative to the mean edge.
pub const ALLOWANCE: f64 = 0.02;

/// What a pair lets its nodes do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits<T> {
    /// Part of its motion that each node may make, 0 to 1.
    pub parts: [T; 4],
    /// Whether a plane separates the sides. Where they touch or cross, nothing is limited.
    pub apart: bool,
}

/// The limits of a pair. `x` are its nodes before, relative to one of them [m], `moves`
/// their motion [m], `apart` the vector between closest points from the second side to the first [m], `thickness` that of
/// the pair [m], and `far` the largest coordinate of the scene [m]. `together` allows a plane that goes along: if all nodes go
/// all their way.
#[inline(always)]
pub fn limits<T: Real, P: Pair>(
    x: [[T; 3]; 4],
    moves: [[T; 3]; 4],
    apart: [T; 3],
    (thickness, far): (T, T),
    together: bool,
) -> Limits<T> {
    let length = norm(apart);
    let normal = scale(apart, T::ONE / if length > T::TINY { length } else { T::ONE });
    let at = [dot(normal, x[0]), dot(normal, x[1]), dot(normal, x[2]), dot(normal, x[3])];
    // Motion towards the other side.
    let mut towards = [T::ZERO; 4];
    let (mut low, mut high) = (at[0], at[3]);
    let (mut low_end, mut high_end) = (at[0] + dot(normal, moves[0]), at[3] + dot(normal, moves[3]));
    let (mut of_first, mut of_second) = (T::ZERO, T::ZERO);
    let mut extent = T::ZERO;
    for i in 0..4 {
        let way = dot(normal, moves[i]);
        if i < P::FIRST {
            towards[i] = -way;
            low = if at[i] < low { at[i] } else { low };
            low_end = if at[i] + way < low_end { at[i] + way } else { low_end };
            of_first = if of_first > -way { of_first } else { -way };
        } else {
            towards[i] = way;
            high = if at[i] > high { at[i] } else { high };
            high_end = if at[i] + way > high_end { at[i] + way } else { high_end };
            of_second = if of_second > way { of_second } else { way };
        }
        for along in x[i] {
            let along = along.abs();
            extent = if along > extent { along } else { extent };
        }
    }
    let gap = low - high;
    let sum = of_first + of_second;
    let share =
        if sum > T::ZERO { of_second } else { T::ONE } / if sum > T::ZERO { sum } else { T::from_f64(2.0) };
    let (least, most) = (T::from_f64(LEAST), T::from_f64(1.0 - LEAST));
    let share = if share > least { share } else { least };
    let share = if share < most { share } else { most };
    let level = high + share * gap;
    let floor = floor(extent, thickness, far);
    let separated = gap > T::ZERO;
    let left = T::from_f64(LEFT) * gap + T::from_f64(2.0) * floor;
    let limited = separated && !(together && low_end - high_end >= left);
    let mut parts = [T::ONE; 4];
    for i in 0..4 {
        let room = if i < P::FIRST { at[i] - level } else { level - at[i] };
        let kept = if room < floor { room } else { floor };
        let left = room * T::from_f64(LEFT);
        let allowed = room - if kept > left { kept } else { left };
        let held = limited && towards[i] > allowed;
        let allowed = if allowed > T::ZERO { allowed } else { T::ZERO };
        let part = allowed / if held { towards[i] } else { T::ONE };
        parts[i] = if held { part } else { T::ONE };
    }
    Limits { parts, apart: separated }
}

/// By how much of itself, and of the largest coordinate in units in the last place, a distance may differ of nodes that move as one.
pub const AS_ONE: f64 = 1e-3;

/// Whether four nodes that began at `start` [m] are as far from each other at `x` [m] as there.
pub fn keeps_shape<T: Real>(start: [[T; 3]; 4], x: [[T; 3]; 4]) -> bool {
    let far = x.iter().flatten().fold(T::ZERO, |far, x| far.max(x.abs()));
    let digits = T::from_f64(DIGITS) * T::EPSILON * far;
    (0..4).all(|i| {
        (0..i).all(|j| {
            let (wanted, found) = (norm(sub(start[i], start[j])), norm(sub(x[i], x[j])));
            (found - wanted).abs() <= T::from_f64(AS_ONE) * wanted + digits
        })
    })
}

/// The least distance to the plane that is kept [m].
#[inline(always)]
fn floor<T: Real>(extent: T, thickness: T, far: T) -> T {
    let slender = T::from_f64(SLENDER) * extent + T::from_f64(DIGITS) * T::EPSILON * far;
    let thin = T::from_f64(THIN) * thickness;
    if slender < thin { slender } else { thin }
}

/// Where the first side of a pair, given as for [`limits`], must go [m] so that its sides end as far apart along their normal as a
/// plane that goes along needs, and not much nearer than they were if they are nearer than a part of their thickness, nor any nearer
/// than twice the least distance: pushes come in every sub-step. Sides that are `squeezed` come nearer than that, for there is no
/// room. `None` if they do without it.
pub fn push_apart<T: Real, P: Pair>(
    x: [[T; 3]; 4],
    moves: [[T; 3]; 4],
    apart: [T; 3],
    (thickness, far): (T, T),
    squeezed: bool,
) -> Option<[T; 3]> {
    let length = norm(apart);
    let normal = scale(apart, T::ONE / if length > T::TINY { length } else { T::ONE });
    let gap = |at: [T; 4]| {
        let low = at[..P::FIRST].iter().fold(T::FAR, |low, &at| if at < low { at } else { low });
        let high = at[P::FIRST..].iter().fold(-T::FAR, |high, &at| if at > high { at } else { high });
        low - high
    };
    let before = x.map(|x| dot(normal, x));
    let after = [0, 1, 2, 3].map(|i| before[i] + dot(normal, moves[i]));
    let extent = x.iter().flatten().fold(T::ZERO, |most, x| most.max(x.abs()));
    let (before, after) = (gap(before), gap(after));
    let twice = T::from_f64(2.0) * floor(extent, thickness, far);
    let least = T::from_f64(LEFT) * before + twice;
    let kept = T::from_f64(ROOM_BEFORE) * thickness;
    let wanted = if least > kept { least } else { kept };
    let twice = if squeezed { T::from_f64(SQUEEZED_FLOOR) * twice } else { twice };
    let twice = if before < twice { before } else { twice };
    let part = T::from_f64(if squeezed { SQUEEZED_PART } else { SHARE }) * before;
    let as_before = if part > twice { part } else { twice };
    let wanted = if as_before < wanted { as_before } else { wanted };
    // It goes a little farther than it must, so that once is enough.
    let missing = wanted / T::from_f64(if squeezed { SQUEEZED_AHEAD } else { SHARE }) - after;
    (before > T::ZERO && after < wanted).then(|| scale(normal, missing))
}

/// A bound of a way by its squared length in 32 bits [m].
pub fn bound_of(squared: f64) -> f64 {
    squared.sqrt() * (1.0 + 1e-5)
}

/// Distance beyond 1.05 times their thickness up to which pairs may be limited whose sides come nearer by up to `approach` [m], if
/// all nodes go all their way: twice the least distance is no more than half the thickness.
pub fn reach_together(approach: f64) -> f64 {
    approach / SHARE
}

/// Distance up to which pairs may be limited where nodes go up to `most` [m], no pair is thicker than `thickness` [m], no edge
/// longer than `edge` [m], and the last place of coordinates is worth `digit` [m]. A side that stands still leaves the other 0.95
/// of the gap, of which it may use 0.85.
pub fn reach(most: f64, thickness: f64, edge: f64, digit: f64) -> f64 {
    let floor = (SLENDER * edge + DIGITS * digit).min(THIN * thickness);
    2.0 * most / (SHARE * (1.0 - LEAST)) + 2.0 * floor / (1.0 - LEAST)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::triangles::closest::{EdgeEdge, Pair, VertexTriangle};
    use crate::real::add;
    use crate::topology::random::SplitMix64;

    const THICK: f64 = 0.1;

    fn held<P: Pair>(x: [[f64; 3]; 4], moves: [[f64; 3]; 4]) -> Limits<f64> {
        limits::<f64, P>(x, moves, P::closest(x).apart, (THICK, 1.0), false)
    }

    /// A vertex 0.1 above the middle of a triangle.
    fn above() -> [[f64; 3]; 4] {
        [[0.3, 0.1, 0.3], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    }

    #[test]
    fn motion_along_the_plane_and_away_from_it_is_free() {
        let aside = [[3.0, 0.0, -2.0], [-4.0, 0.0, 1.0], [0.0; 3], [0.0, 0.0, 9.0]];
        assert_eq!(held::<VertexTriangle>(above(), aside).parts, [1.0; 4]);
        let apart = [[0.0, 5.0, 0.0], [0.0, -3.0, 0.0], [0.0, -3.0, 0.0], [0.0, -3.0, 0.0]];
        assert_eq!(held::<VertexTriangle>(above(), apart).parts, [1.0; 4]);
        // One side flees faster than the other follows: only who follows is held, for the other may be held by a third.
        let chased = [[0.0, -0.3, 0.0], [0.0, -3.0, 0.0], [0.0, -3.0, 0.0], [0.0, -3.0, 0.0]];
        let parts = held::<VertexTriangle>(above(), chased).parts;
        assert!(parts[0] < 1.0 && parts[1..] == [1.0; 3], "{parts:?}");
    }

    #[test]
    fn who_goes_together_is_free_unless_they_end_too_near() {
        let x = above();
        let parts = |down: f64| {
            let moves = [[0.0, -3.0 - down, 0.0], [0.2, -3.0, 0.0], [0.2, -3.0, 0.0], [0.2, -3.0, 0.0]];
            let apart = VertexTriangle::closest(x).apart;
            limits::<f64, VertexTriangle>(x, moves, apart, (THICK, 1.0), true).parts
        };
        assert_eq!(parts(0.0), [1.0; 4]);
        // Of 0.1, 0.015 must be left, and twice the least distance of sides whose extent is 1.
        let left = 0.015 + 2.0 * SLENDER;
        assert_eq!(parts(0.1 - left - 1e-6), [1.0; 4]);
        let late = parts(0.1 - left + 1e-6);
        assert!(
            late[0] < 0.1 && late[1..] == [1.0; 3],
            "a plane that stands still holds the follower: {late:?}"
        );
    }

    #[test]
    fn sides_share_the_gap_by_their_motion_and_keep_a_part_of_it() {
        let down = |by: f64| [0.0, -by, 0.0];
        let mut x = above();
        x[0][1] = 0.4;
        let alone = held::<VertexTriangle>(x, [down(1.0), [0.0; 3], [0.0; 3], [0.0; 3]]);
        assert!((alone.parts[0] - SHARE * 0.95 * 0.4).abs() < 1e-12, "{alone:?}");
        let up = [0.0, 1.0, 0.0];
        let both = held::<VertexTriangle>(x, [down(3.0), up, up, up]);
        assert!((both.parts[0] * 3.0 - SHARE * 0.75 * 0.4).abs() < 1e-12, "{both:?}");
        assert!((both.parts[1] - SHARE * 0.25 * 0.4).abs() < 1e-12, "{both:?}");
    }

    #[test]
    fn nearer_than_the_least_distance_nobody_comes_closer() {
        let mut x = above();
        x[0][1] = 1e-3;
        let parts = held::<VertexTriangle>(x, [[1.0, -1e-6, 0.0], [0.0; 3], [0.0; 3], [0.0; 3]]).parts;
        assert_eq!(parts, [0.0, 1.0, 1.0, 1.0]);
        x[0][1] = 0.0;
        let touching = held::<VertexTriangle>(x, [[1.0, -1e-6, 0.0]; 4]);
        assert_eq!((touching.parts, touching.apart), ([1.0; 4], false));
    }

    #[test]
    fn what_ends_apart_is_what_a_plane_that_goes_along_allows() {
        let mut random = SplitMix64::new(8);
        let mut apart = 0;
        for _ in 0..20_000 {
            let x = crate::contact::triangles::closest::tests::four(&mut random);
            let moves = [[0.0; 3]; 4].map(|way| way.map(|_: f64| 0.2 * (random.unit() - 0.5)));
            let between = EdgeEdge::closest(x).apart;
            let push = push_apart::<f64, EdgeEdge>(x, moves, between, (THICK, 1.0), false);
            let ends = push.is_none();
            let found = limits::<f64, EdgeEdge>(x, moves, between, (THICK, 1.0), true);
            apart += u32::from(ends);
            if let Some(push) = push {
                let pushed = [add(moves[0], push), add(moves[1], push), moves[2], moves[3]];
                let again = push_apart::<f64, EdgeEdge>(x, pushed, between, (THICK, 1.0), false);
                assert_eq!(again, None, "once is enough: {x:?} {moves:?}");
            }
            if let Some(squeezed) = push_apart::<f64, EdgeEdge>(x, moves, between, (THICK, 1.0), true) {
                assert!(push.is_some_and(|push| norm(squeezed) < norm(push)), "{x:?} {moves:?}");
                let pushed = [add(moves[0], squeezed), add(moves[1], squeezed), moves[2], moves[3]];
                let again = push_apart::<f64, EdgeEdge>(x, pushed, between, (THICK, 1.0), true);
                assert_eq!(again, None, "once is enough: {x:?} {moves:?}");
            }
            // Who is nearer than the least distance already only must not come nearer.
            assert!(!ends || norm(between) < 0.05 || found.parts == [1.0; 4], "{x:?} {moves:?}");
        }
        assert!((10_000..19_900).contains(&apart), "{apart}");
        // Nearer than half the thickness, it must stay about as far, and as far where next to nothing is left: colliders push in
        // every sub-step, and a part of what is left each time would soon be nothing.
        let squeezed = |height: f64, down: f64, squeezed: bool| {
            let mut x = above();
            x[0][1] = height;
            let moves = [[0.0, -down, 0.0], [0.0; 3], [0.0; 3], [0.0; 3]];
            let apart = VertexTriangle::closest(x).apart;
            push_apart::<f64, VertexTriangle>(x, moves, apart, (THICK, 1.0), squeezed).is_none()
        };
        let apart = |height: f64, down: f64| squeezed(height, down, false);
        assert!(apart(0.04, 0.0059) && !apart(0.04, 0.0061));
        assert!(apart(1e-3, -1e-7) && !apart(1e-3, 1e-7));
        // The least distance here is 4e-3. Without room half of each distance may be lost, down to half the least.
        assert!(squeezed(0.04, 0.0199, true) && !squeezed(0.04, 0.0201, true));
        assert!(squeezed(3e-3, 0.99e-3, true) && !squeezed(3e-3, 1.01e-3, true));
        assert!(squeezed(1e-3, -1e-7, true) && !squeezed(1e-3, 1e-7, true));
    }

    /// Pairs that are driven at random, in 32 bits and far from the origin, never meet: a plane parts them before and after
    /// every step, so it parts them in between.
    fn never_meet<P: Pair>(seed: u64, offset: f32) {
        let mut random = SplitMix64::new(seed);
        let mut unit = || random.unit() as f32;
        for _ in 0..300 {
            let mut x: [[f32; 3]; 4] =
                std::array::from_fn(|_| std::array::from_fn(|_| offset + unit() * 0.04));
            let relative = |x: [[f32; 3]; 4]| x.map(|one| sub(one, x[3]));
            let distance = |x: [[f32; 3]; 4]| norm(P::closest(relative(x)).apart);
            if distance(x) < 1e-3 {
                continue;
            }
            for _ in 0..60 {
                let drive = unit() * 0.1;
                let moves: [[f32; 3]; 4] =
                    std::array::from_fn(|_| std::array::from_fn(|_| drive * (unit() - 0.5)));
                let apart = P::closest(relative(x)).apart;
                let (thickness, together) = ((0.005, offset + 0.1), unit() < 0.5);
                let found = limits::<f32, P>(relative(x), moves, apart, thickness, together);
                assert!(found.apart, "{x:?}");
                let to: [[f32; 3]; 4] = std::array::from_fn(|i| add(x[i], scale(moves[i], found.parts[i])));
                let along =
                    |x: [f32; 3]| (0..3).map(|axis| f64::from(apart[axis]) * f64::from(x[axis])).sum::<f64>();
                let [low, high] =
                    [&to[..P::FIRST], &to[P::FIRST..]].map(|side| side.iter().map(|&x| along(x)));
                let (low, high) = (low.fold(f64::INFINITY, f64::min), high.fold(f64::NEG_INFINITY, f64::max));
                let (before, after) = (
                    x[..P::FIRST].iter().map(|&x| along(x)).fold(f64::INFINITY, f64::min),
                    x[P::FIRST..].iter().map(|&x| along(x)).fold(f64::NEG_INFINITY, f64::max),
                );
                // One plane has the first side above it before and after, and the second below.
                assert!(low.min(before) > high.max(after) || low > high && before > after, "{x:?} {to:?}");
                x = to;
            }
        }
    }

    #[test]
    fn pairs_that_are_driven_against_each_other_never_meet() {
        for (seed, offset) in [(1, 0.0), (2, 1.0), (3, 30.0)] {
            never_meet::<VertexTriangle>(seed, offset);
            never_meet::<EdgeEdge>(seed, offset);
        }
    }

    #[test]
    fn who_goes_together_and_is_farther_apart_than_the_reach_is_free() {
        let mut random = SplitMix64::new(4);
        let mut limited = 0;
        for _ in 0..20_000 {
            let x = crate::contact::triangles::closest::tests::four(&mut random);
            let (common, most) = ([0, 1, 2].map(|_| random.unit() - 0.5), 0.2 * random.unit());
            let moves: [[f64; 3]; 4] = std::array::from_fn(|_| {
                let way: [f64; 3] = std::array::from_fn(|_| random.unit() - 0.5);
                add(common, scale(way, 0.5 * most / norm(way)))
            });
            let apart = EdgeEdge::closest(x).apart;
            let found = limits::<f64, EdgeEdge>(x, moves, apart, (THICK, 1.0), true);
            let is_free = found.parts == [1.0; 4];
            limited += u32::from(!is_free);
            assert!(is_free || norm(apart) < 1.05 * THICK + reach_together(most), "{x:?} {moves:?}");
        }
        assert!(limited > 300, "{limited}");
    }

    #[test]
    fn who_is_farther_apart_than_the_reach_is_free() {
        let mut random = SplitMix64::new(9);
        let mut limited = 0;
        for _ in 0..20_000 {
            let x = crate::contact::triangles::closest::tests::four(&mut random);
            let most = random.unit() * 0.5;
            let moves: [[f64; 3]; 4] = std::array::from_fn(|_| {
                let way: [f64; 3] = std::array::from_fn(|_| random.unit() - 0.5);
                scale(way, most / norm(way))
            });
            let distance = norm(VertexTriangle::closest(x).apart);
            let is_free = held::<VertexTriangle>(x, moves).parts == [1.0; 4];
            limited += u32::from(!is_free);
            assert!(is_free || distance < reach(most, THICK, 4.0, 0.0), "{distance} {most}");
        }
        assert!(limited > 1000, "{limited}");
    }
}
