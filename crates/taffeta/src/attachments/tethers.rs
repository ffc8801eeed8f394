//! Geodesic distances along a surface from its nodes to pinned ones, and a search for the nearest position.

use crate::real::hypot;
use crate::topology::Csr;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

/// Most tethers of a node: one to each of the nearest connected parts of pinned nodes.
pub const MAX_TETHERS: usize = 4;

/// A straight edge of the surface between two nodes, and its length [m].
pub type Edge = ([u32; 2], f64);

/// The shortest path from a node to a pinned one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeodesicPath {
    /// Its first node.
    pub node: u32,
    /// The pinned node at its end.
    pub anchor: u32,
    /// Its length [m].
    pub length: f64,
}

/// The shortest paths along `pieces` from every free node to the nearest node of each connected part of pinned nodes;
/// at most [`MAX_TETHERS`] of them. Ascending by node, then by length (Dijkstra, "A Note on Two Problems in Connexion
/// with Graphs", 1959, from all pinned nodes at once).
pub fn geodesic_paths(pieces: &[Edge], held: &[bool]) -> Vec<GeodesicPath> {
    let pairs: Vec<[u32; 2]> = pieces.iter().map(|(pair, _)| *pair).collect();
    let by_node = Csr::corners(held.len(), &pairs);
    let next = |node: u32| {
        by_node.row(node as usize).iter().map(|&end| {
            let (pair, length) = pieces[end as usize / 2];
            (pair[1 - end as usize % 2], length)
        })
    };
    let part = parts(held, next);
    let mut known: Vec<Vec<GeodesicPath>> = vec![Vec::new(); held.len()];
    let mut queue: BinaryHeap<_> =
        (0..held.len() as u32).filter(|&n| held[n as usize]).map(|n| Reverse((0_u64, n, n))).collect();
    while let Some(Reverse((bits, node, anchor))) = queue.pop() {
        // Bits of positive numbers have the order of the numbers.
        let length = f64::from_bits(bits);
        let (own, to) = (&mut known[node as usize], part[anchor as usize]);
        if own.len() >= MAX_TETHERS || own.iter().any(|way| part[way.anchor as usize] == to) {
            continue;
        }
        own.push(GeodesicPath { node, anchor, length });
        queue.extend(next(node).map(|(other, piece)| Reverse(((length + piece).to_bits(), other, anchor))));
    }
    known.into_iter().flatten().filter(|way| !held[way.node as usize]).collect()
}

/// The connected part of each pinned node.
fn parts<I: Iterator<Item = (u32, f64)>>(held: &[bool], next: impl Fn(u32) -> I) -> Vec<u32> {
    let mut part = vec![u32::MAX; held.len()];
    let mut stack = Vec::new();
    for first in (0..held.len() as u32).filter(|&node| held[node as usize]) {
        if part[first as usize] == u32::MAX {
            stack.push(first);
        }
        while let Some(node) = stack.pop() {
            part[node as usize] = first;
            stack.extend(
                next(node)
                    .map(|(other, _)| other)
                    .filter(|&other| held[other as usize] && part[other as usize] == u32::MAX),
            );
        }
    }
    part
}

/// Length of the straight line between the corners opposite an edge, in the plane of both unfolded triangles, if it
/// crosses the edge. `edge` is its length, `left` and `right` those of the sides from its first and its second end
/// [m].
pub fn across(edge: f64, left: [f64; 2], right: [f64; 2]) -> Option<f64> {
    let corner = |[a, b]: [f64; 2]| {
        let along = (a * a - b * b + edge * edge) / (2.0 * edge);
        (along, (a * a - along * along).max(0.0).sqrt())
    };
    let ((l, above), (r, below)) = (corner(left), corner(right));
    let crossing = l + (r - l) * above / (above + below);
    (crossing > 0.0 && crossing < edge).then(|| hypot(l - r, above + below))
}

/// Positions in cells of the size of a reach.
pub struct PlacesByCell<'a> {
    places: &'a [[f64; 3]],
    reach: f64,
    cells: HashMap<[i64; 3], Vec<u32>>,
}

impl<'a> PlacesByCell<'a> {
    /// Sorts positions into cells of `reach` [m].
    pub fn new(places: &'a [[f64; 3]], reach: f64) -> Self {
        let mut near = Self { places, reach, cells: HashMap::new() };
        for (number, &place) in (0..).zip(places) {
            near.cells.entry(near.cell(place)).or_default().push(number);
        }
        near
    }

    fn cell(&self, place: [f64; 3]) -> [i64; 3] {
        place.map(|x| (x / self.reach).floor() as i64)
    }

    /// The nearest of the wanted positions within the reach; of several the first.
    pub fn nearest(&self, at: [f64; 3], wanted: impl Fn(usize) -> bool) -> Option<usize> {
        let [x, y, z] = self.cell(at);
        let around = (0..27).map(|n| [x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1]);
        let near = around.filter_map(|cell| self.cells.get(&cell)).flatten().map(|&number| number as usize);
        let squared = |number: usize| (0..3).map(|i| (self.places[number][i] - at[i]).powi(2)).sum::<f64>();
        near.filter(|&number| wanted(number) && squared(number) <= self.reach * self.reach)
            .min_by(|&a, &b| squared(a).total_cmp(&squared(b)).then(a.cmp(&b)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of five nodes, 1 m apart.
    fn chain() -> Vec<Edge> {
        (0..4).map(|n| ([n, n + 1], 1.0)).collect()
    }

    #[test]
    fn each_part_of_held_nodes_has_one_way() {
        let ends = geodesic_paths(&chain(), &[true, true, false, false, true]);
        let way = |node, anchor, length| GeodesicPath { node, anchor, length };
        assert_eq!(ends, [way(2, 1, 1.0), way(2, 4, 2.0), way(3, 4, 1.0), way(3, 1, 2.0)]);
    }

    #[test]
    fn no_node_has_more_ways_than_the_most() {
        // A star: node 0 and six held ones around it, at 1 m to 6 m.
        let pieces: Vec<Edge> = (1..7).map(|n| ([0, n], f64::from(n))).collect();
        let held = [false, true, true, true, true, true, true];
        let found = geodesic_paths(&pieces, &held);
        assert_eq!(found.iter().map(|way| way.anchor).collect::<Vec<_>>(), [1, 2, 3, 4]);
    }

    #[test]
    fn nodes_that_hang_on_nothing_have_no_way() {
        assert_eq!(geodesic_paths(&[([0, 1], 1.0)], &[true, false, false]).len(), 1);
        assert_eq!(geodesic_paths(&chain(), &[false; 5]), []);
    }

    #[test]
    fn triangles_are_laid_flat() {
        // Two halves of a unit square, and a corner that the straight way passes by.
        let side = 1.0;
        assert!((across(2_f64.sqrt(), [side; 2], [side; 2]).unwrap() - 2_f64.sqrt()).abs() < 1e-15);
        let far = [10_f64.hypot(1.0), 9_f64.hypot(1.0)];
        assert_eq!(across(1.0, far, far), None);
    }

    #[test]
    fn the_nearest_within_reach_is_found() {
        let places = [[0.0; 3], [0.3, 0.0, 0.0], [-0.2, 0.0, 0.0], [5.0, 5.0, 5.0]];
        let near = PlacesByCell::new(&places, 0.5);
        assert_eq!(near.nearest([0.16, 0.0, 0.0], |_| true), Some(1));
        assert_eq!(near.nearest([0.16, 0.0, 0.0], |other| other != 1), Some(0));
        assert_eq!(near.nearest([0.0, 0.51, 0.0], |_| true), None);
        assert_eq!(near.nearest([5.0, 5.0, 4.5], |_| true), Some(3));
    }
}
