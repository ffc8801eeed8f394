//! Edges that pierce triangles: whether cloth passes through cloth, found exactly.

use crate::topology::near_pairs::{Budget, near_pairs};
use crate::topology::predicate::{Point, segment_meets_triangle};
use std::collections::HashSet;

/// Pairs of triangles that are looked at before the count ends: half a minute in a tangle.
const MOST: u64 = 1 << 26;

/// Pairs of an edge and a triangle that have a point in common.
///
/// ```
/// use taffeta::topology::piercings;
///
/// // Two sheets of one triangle each: an edge of the upright one goes through the flat one, and the other way round.
/// let flat = [[0.0, 0.0, 0.0], [0.4, 0.0, 0.0], [0.0, 0.0, 0.4]];
/// let upright = [[0.1, -0.1, 0.1], [0.1, 0.1, 0.1], [0.1, 0.1, 0.5]];
/// let found = piercings(&[flat, upright].concat(), &[[0, 1, 2], [3, 4, 5]], |_| true);
/// assert_eq!(found.pairs, 2);
/// assert!(found.complete);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Piercings {
    /// How many pairs.
    pub pairs: u64,
    /// The first pair in the order of triangles, and of edges by their ends.
    pub first: Option<Piercing>,
    /// Whether all pairs were looked at. If not, there may be more than counted.
    pub complete: bool,
}

/// An edge that pierces a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Piercing {
    /// Corners of the triangle.
    pub triangle: [u32; 3],
    /// Ends of the edge, the lower one first.
    pub edge: [u32; 2],
}

/// Counts the pairs of an edge and a triangle without a common corner that have a point in common; one that touches counts.
/// Corners at exactly one place are common, whether they are one node or several. An edge of several triangles is one edge.
/// `counts` says of two triangles, given by their places in the list, whether pairs of their edges count. The same answer for
/// any number of threads.
pub fn piercings(
    nodes: &[Point],
    triangles: &[[u32; 3]],
    counts: impl Fn([u32; 2]) -> bool + Sync,
) -> Piercings {
    piercings_apart(nodes, triangles, |node| node, counts)
}

/// The same where corners are also common if `point` gives the same number for them: they are one, though at several places.
pub(crate) fn piercings_apart(
    nodes: &[Point],
    triangles: &[[u32; 3]],
    point: impl Fn(u32) -> u32 + Sync,
    counts: impl Fn([u32; 2]) -> bool + Sync,
) -> Piercings {
    let note = |found: &mut Piercings, edge: [u32; 2], triangle: u32| {
        found.pairs += 1;
        let pair = Piercing { triangle: triangles[triangle as usize], edge };
        found.first = Some(found.first.map_or(pair, |first| first.min(pair)));
    };
    let mut all = Piercings::default();
    all.complete = each_piercing((nodes, triangles, point), (counts, note), |found: Piercings| {
        all.pairs += found.pairs;
        all.first = all.first.into_iter().chain(found.first).min();
    });
    all
}

/// Lists the pairs that [`piercings_apart`] counts, ascending: an edge with its lower end first, and the number of a triangle.
pub(crate) fn list_piercings(
    nodes: &[Point],
    triangles: &[[u32; 3]],
    point: impl Fn(u32) -> u32 + Sync,
    counts: impl Fn([u32; 2]) -> bool + Sync,
) -> Vec<([u32; 2], u32)> {
    let note = |found: &mut Vec<([u32; 2], u32)>, edge: [u32; 2], triangle: u32| found.push((edge, triangle));
    let mut all = Vec::new();
    each_piercing((nodes, triangles, point), (counts, note), |found: Vec<_>| all.extend(found));
    all.sort_unstable();
    all
}

/// Notes each pair of an edge and a triangle, by its number, in what is found in a part of the scene, and takes part after
/// part. Returns whether all pairs were looked at.
fn each_piercing<F: Default + Send>(
    (nodes, triangles, point): (&[Point], &[[u32; 3]], impl Fn(u32) -> u32 + Sync),
    (counts, note): (impl Fn([u32; 2]) -> bool + Sync, impl Fn(&mut F, [u32; 2], u32) + Sync),
    take: impl FnMut(F),
) -> bool {
    let owned = owned_edges(triangles);
    let look = |found: &mut F, pair: [u32; 2]| {
        if counts(pair) {
            for [of, with] in [pair, [pair[1], pair[0]]] {
                let corners = [of, with].map(|triangle| triangles[triangle as usize]);
                each_pierced((nodes, &point), owned[of as usize], corners, |edge| note(found, edge, with));
            }
        }
    };
    let budget = Budget { all: MOST, leaf: MOST, ..Budget::of(triangles.len()) };
    near_pairs(budget, nodes, triangles, look, take)
}

/// For each triangle, which of its edges are looked at with it: each edge once.
fn owned_edges(triangles: &[[u32; 3]]) -> Vec<[bool; 3]> {
    let mut seen = HashSet::with_capacity(2 * triangles.len());
    let mut own = |a: u32, b: u32| seen.insert([a.min(b), a.max(b)]);
    triangles.iter().map(|&[a, b, c]| [own(a, b), own(b, c), own(c, a)]).collect()
}

/// Calls `note` with the owned edges of one triangle that pierce another one.
fn each_pierced(
    (nodes, point): (&[Point], &impl Fn(u32) -> u32),
    owned: [bool; 3],
    [of, triangle]: [[u32; 3]; 2],
    mut note: impl FnMut([u32; 2]),
) {
    let at = |node: u32| nodes[node as usize];
    let corners = triangle.map(at);
    for (a, b) in (0..3).filter(|&i| owned[i]).map(|i| (of[i], of[(i + 1) % 3])) {
        let ends = [at(a), at(b)];
        let is_common =
            |node: u32| triangle.iter().any(|&corner| at(corner) == at(node) || point(corner) == point(node));
        if !is_common(a) && !is_common(b) && segment_meets_triangle(ends, corners) {
            note([a.min(b), a.max(b)]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::random::SplitMix64;
    use crate::topology::triangles_meet;

    fn all(nodes: &[Point], triangles: &[[u32; 3]]) -> u64 {
        let found = piercings(nodes, triangles, |_| true);
        assert!(found.complete);
        assert_eq!(found.first.is_some(), found.pairs > 0);
        found.pairs
    }

    #[test]
    fn an_edge_of_two_triangles_counts_once_and_so_does_one_that_touches() {
        let floor = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 0.0, 4.0]];
        // A roof whose ridge goes through the floor, and the floor's edges pass beside it.
        let roof = |y: f64| [[1.0, -1.0, 1.0], [1.0, y, 1.0], [1.5, 1.0, 0.5], [0.5, 1.0, 0.5]];
        let triangles = [[0, 1, 2], [3, 4, 5], [4, 3, 6]];
        assert_eq!(all(&[&floor[..], &roof(1.0)].concat(), &triangles), 3, "the ridge and two slopes");
        assert_eq!(all(&[&floor[..], &roof(-0.5)].concat(), &triangles), 4, "four slopes");
        let standing = [[1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [1.5, 1.0, 0.5], [0.5, 1.0, 0.5]];
        assert_eq!(all(&[&floor[..], &standing].concat(), &triangles), 3, "its foot is that of three edges");
        let above = standing.map(|[x, y, z]| [x, y + 1e-60, z]);
        assert_eq!(all(&[&floor[..], &above].concat(), &triangles), 0);
    }

    #[test]
    fn what_shares_a_corner_does_not_pierce_and_pairs_may_be_left_out() {
        let nodes = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [1.0, 0.5, 1.0], [1.0, 0.5, -1.0]];
        // A fin that stands on the corner of a triangle and goes through it.
        let fin = [[0, 1, 2], [0, 3, 4]];
        assert_eq!(all(&nodes, &fin), 1, "its far edge");
        assert_eq!(piercings(&nodes, &fin, |pair| pair != [0, 1]).pairs, 0);
        assert_eq!(
            piercings(&nodes, &fin, |_| true).first,
            Some(Piercing { triangle: [0, 1, 2], edge: [3, 4] })
        );
    }

    #[test]
    fn soups_have_pairs_where_triangles_meet_and_nowhere_else() {
        let mut random = SplitMix64::new(11);
        let (nodes, triangles) = (300, 100);
        let nodes: Vec<Point> = (0..nodes).map(|_| [0.0; 3].map(|_: f64| random.unit())).collect();
        let triangles: Vec<[u32; 3]> = (0..triangles).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let corners = |t: &[u32; 3]| t.map(|i| nodes[i as usize]);
        let mut meet = 0;
        for (i, t) in triangles.iter().enumerate() {
            for u in &triangles[..i] {
                let pierced = all(&nodes, &[*t, *u]);
                assert_eq!(pierced > 0, triangles_meet(corners(t), corners(u)), "{t:?} {u:?}");
                // Two triangles in general position share a segment, whose ends are where an edge pierces.
                assert!(pierced == 0 || pierced == 2, "{pierced}");
                meet += pierced;
            }
        }
        assert_eq!(all(&nodes, &triangles), meet);
        assert!(meet > 500, "{meet}");
    }
}
