//! On which side of a surface nodes are that are near it.

use crate::contact::triangles::closest::vertex_triangle;
use crate::real::{cross, dot, norm, sub};
use std::collections::HashMap;

/// How much of its distance a node must be off the plane of the nearest triangle to be on one side of it.
const CLEAR: f64 = 0.5;
/// Triangles are equally near if their distances differ by no more than this part.
const ALIKE: f64 = 1e-9;

/// Whether each of some nodes is above the nearest of some triangles, 1, or below, -1; 0 if none is within a reach [m], or if the
/// node is beside it. `x` are all positions [m].
pub fn sides(
    x: &[[f64; 3]],
    reach: f64,
    nodes: &[u32],
    triangles: impl Iterator<Item = [u32; 3]>,
) -> Vec<i8> {
    let cell = |x: f64| (x / (2.0 * reach)).floor();
    let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    for (index, &node) in nodes.iter().enumerate() {
        cells.entry(x[node as usize].map(|x| cell(x) as i64)).or_default().push(index);
    }
    let mut all = vec![Nearest { distance: reach, facing: 0.0, side: 0 }; nodes.len()];
    for triangle in triangles {
        let corners = triangle.map(|corner| x[corner as usize]);
        let bound = |pick: fn(f64, f64) -> f64, by: f64| {
            [0, 1, 2].map(|axis| cell(corners.iter().map(|x| x[axis]).fold(corners[0][axis], pick) + by))
        };
        let (low, high) = (bound(f64::min, -reach), bound(f64::max, reach));
        let mut look = |index: usize| all[index].look(x[nodes[index] as usize], corners);
        let [from, to] = [low, high].map(|bound| bound.map(|x| x as i64));
        // A triangle may be as large as the world.
        let covered: f64 = low.iter().zip(&high).map(|(low, high)| high - low + 1.0).product();
        if covered.is_nan() || covered > cells.len() as f64 {
            let is_in = |key: &[i64; 3]| (0..3).all(|axis| (from[axis]..=to[axis]).contains(&key[axis]));
            cells
                .iter()
                .filter(|(key, _)| is_in(key))
                .flat_map(|(_, all)| all)
                .for_each(|&index| look(index));
            continue;
        }
        for i in from[0]..=to[0] {
            for j in from[1]..=to[1] {
                for k in from[2]..=to[2] {
                    cells.get(&[i, j, k]).into_iter().flatten().for_each(|&index| look(index));
                }
            }
        }
    }
    all.into_iter().map(|one| one.side).collect()
}

/// The nearest triangle of a node.
#[derive(Clone, Copy)]
struct Nearest {
    /// Its distance [m], and how far the way there is along its normal, as a cosine without sign.
    distance: f64,
    facing: f64,
    side: i8,
}

impl Nearest {
    /// Takes a triangle if it is nearer. Of two that meet in the nearest point, that counts which faces the node: the other one may have
    /// it on the wrong side.
    fn look(&mut self, x: [f64; 3], [a, b, c]: [[f64; 3]; 3]) {
        let apart = vertex_triangle([x, a, b, c]).apart;
        let (distance, normal) = (norm(apart), cross(sub(b, a), sub(c, a)));
        let (above, most) = (dot(apart, normal), distance * norm(normal));
        let facing = if most > 0.0 { above.abs() / most } else { 0.0 };
        let is_nearer = distance < self.distance * (1.0 - ALIKE);
        let is_alike = distance <= self.distance * (1.0 + ALIKE) && facing > self.facing;
        if is_nearer || is_alike {
            let side = if facing >= CLEAR { above.signum() as i8 } else { 0 };
            *self = Self { distance, facing, side };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_above_below_beside_or_nowhere_near() {
        let corners = [[0.0, 0.0, 0.0], [0.0, 0.0, 1e6], [1e6, 0.0, 0.0]];
        let nodes =
            [[3.0, 0.4, 2.0], [7.0, -0.4, 90.0], [-0.4, 0.1, 5.0], [3.0, 0.6, 2.0], [-1e300, 0.0, 0.0]];
        let x = [&corners[..], &nodes[..]].concat();
        let found = sides(&x, 0.5, &[3, 4, 5, 6, 7], [[0, 1, 2]].into_iter());
        assert_eq!(found, [1, -1, 0, 0, 0]);
        // The nearest one counts, whatever their order.
        let other = [[0.0, 0.7, 0.0], [0.0, 0.7, 1e6], [1e6, 0.7, 0.0]];
        let x = [&corners[..], &other[..], &nodes[..1]].concat();
        for triangles in [[[0, 1, 2], [3, 4, 5]], [[3, 4, 5], [0, 1, 2]]] {
            assert_eq!(sides(&x, 0.5, &[6], triangles.into_iter()), [-1]);
        }
        // At the edge of a wedge that side counts which faces the node: the other one has it on the wrong side.
        let wedge = [[0.0; 3], [0.0, 0.0, 9.0], [-9.0, 1.0, 0.0], [-9.0, -1.0, 0.0]];
        let x = [&wedge[..], &[[0.03, 0.1, 3.0], [0.03, -0.1, 3.0]]].concat();
        for triangles in [[[0, 1, 2], [1, 0, 3]], [[1, 0, 3], [0, 1, 2]]] {
            let outside = sides(&x, 0.5, &[4, 5], triangles.into_iter());
            assert!(outside[0] != 0 && outside[0] == outside[1], "{outside:?}");
        }
    }
}
