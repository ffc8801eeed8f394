//! Surfaces that pass through each other.

use crate::common::V;
use robust::Coord3D;
use std::collections::BTreeSet;

/// Whether a segment passes through a triangle, without rounding.
fn passes([p, q]: [V; 2], triangle: [V; 3]) -> bool {
    let overlap = |axis: usize| {
        let span =
            |of: &[V]| of.iter().fold([f64::MAX, f64::MIN], |s, x| [s[0].min(x[axis]), s[1].max(x[axis])]);
        let (a, b) = (span(&[p, q]), span(&triangle));
        a[0] <= b[1] && b[0] <= a[1]
    };
    if !(0..3).all(overlap) {
        return false;
    }
    let side = |points: [V; 4]| {
        let [a, b, c, d] = points.map(|[x, y, z]| Coord3D { x, y, z });
        robust::orient3d(a, b, c, d)
    };
    let [a, b, c] = triangle;
    let turns = [[a, b], [b, c], [c, a]].map(|[u, v]| side([p, q, u, v]));
    let one_way = turns.iter().all(|&t| t > 0.0) || turns.iter().all(|&t| t < 0.0);
    one_way && side([a, b, c, p]) * side([a, b, c, q]) < 0.0
}

/// Edges of one that pass through triangles of the other.
pub fn crossings(x: [&[V]; 2], triangles: [&[[u32; 3]]; 2]) -> usize {
    let one_way = |a: usize, b: usize| {
        let sides = triangles[a].iter().flat_map(|&[u, v, w]| [[u, v], [v, w], [w, u]]);
        let edges: BTreeSet<[u32; 2]> = sides.map(|[u, v]| [u.min(v), u.max(v)]).collect();
        let through = |edge: &&[u32; 2]| {
            let ends = edge.map(|n| x[a][n as usize]);
            triangles[b].iter().any(|t| passes(ends, t.map(|n| x[b][n as usize])))
        };
        edges.iter().filter(through).count()
    };
    one_way(0, 1) + one_way(1, 0)
}
