//! What meshes and grids consist of, found by plain loops, and the angle of a fold by differences.

use super::{V, cross, dot, norm, scale, sub};
use std::collections::{BTreeMap, BTreeSet};

/// Angle between the half-planes on both sides of an edge, less half a turn.
pub fn angle([a, b, c, d]: [V; 4]) -> f64 {
    let along = scale(sub(b, a), 1.0 / norm(sub(b, a)));
    let across = |x: V| sub(sub(x, a), scale(along, dot(along, sub(x, a))));
    let (p, q) = (across(c), scale(across(d), -1.0));
    dot(along, cross(p, q)).atan2(dot(p, q))
}

/// Derivative of the angle by differences of fourth order.
pub fn angle_gradient(x: [V; 4]) -> [V; 4] {
    let step = 2e-4 * norm(sub(x[1], x[0]));
    let moved = |c: usize, i: usize, by: f64| {
        let mut y = x;
        y[c][i] += by * step;
        angle(y)
    };
    let slope = |c, i| {
        let near = moved(c, i, 1.0) - moved(c, i, -1.0);
        (8.0 * near - (moved(c, i, 2.0) - moved(c, i, -2.0))) / (12.0 * step)
    };
    std::array::from_fn(|c| std::array::from_fn(|i| slope(c, i)))
}

/// The pairs of a grid's nodes `down` rows and `across` columns apart, either way across.
pub fn grid_pairs(rows: usize, cols: usize, down: usize, across: usize) -> Vec<[usize; 2]> {
    let mut pairs = BTreeSet::new();
    for (r, c) in (0..rows).flat_map(|r| (0..cols).map(move |c| (r, c))) {
        for to in [c.checked_add(across), c.checked_sub(across)].into_iter().flatten() {
            if r + down < rows && to < cols {
                let (a, b) = (r * cols + c, (r + down) * cols + to);
                pairs.insert([a.min(b), a.max(b)]);
            }
        }
    }
    pairs.into_iter().collect()
}

/// `[a, b, c, d]` for each edge a–b of two triangles, whose other corners are c and d.
pub fn shared_edges(triangles: &[[u32; 3]]) -> Vec<[usize; 4]> {
    let mut sides: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
    for &[a, b, c] in triangles {
        for [a, b, other] in [[a, b, c], [b, c, a], [c, a, b]] {
            sides.entry([a.min(b), a.max(b)]).or_default().push(other);
        }
    }
    let two = sides.into_iter().filter(|(_, others)| others.len() == 2);
    two.map(|([a, b], others)| [a, b, others[0], others[1]].map(|n| n as usize)).collect()
}

/// All edges of triangles.
pub fn edges(triangles: &[[u32; 3]]) -> BTreeSet<[usize; 2]> {
    let sides = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    sides.map(|[a, b]| [a.min(b) as usize, a.max(b) as usize]).collect()
}

/// Mass of each node [kg], a third of each triangle's area to each corner.
pub fn lumped(x: &[V], triangles: &[[u32; 3]], per_area: f64) -> Vec<f64> {
    let mut mass = vec![0.0; x.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|n| x[n as usize]);
        let area = 0.5 * norm(cross(sub(b, a), sub(c, a)));
        triangle.iter().for_each(|&n| mass[n as usize] += per_area * area / 3.0);
    }
    mass
}
