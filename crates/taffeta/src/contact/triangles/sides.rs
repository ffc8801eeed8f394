//! On which side of a surface nodes are that are near it.

use crate::contact::triangles::closest::vertex_triangle;
use crate::real::{cross, dot, norm, sub};
use std::collections::HashMap;

/// How much of its distance a node must be off the plane of the nearest triangle to be on one side of it.
const CLEAR: f64 = 0.5;

/// Triangles of a surface by cells of space, each in all that it may be near to.
pub struct Near<'a> {
    x: &'a [[f64; 3]],
    reach: f64,
    cells: HashMap<[i64; 3], Vec<[u32; 3]>>,
}

impl<'a> Near<'a> {
    /// Triangles whose corners are at `x`, for nodes that are within a reach [m] of them.
    pub fn new(x: &'a [[f64; 3]], reach: f64, triangles: impl Iterator<Item = [u32; 3]>) -> Self {
        let mut all = Self { x, reach, cells: HashMap::new() };
        for triangle in triangles {
            let corners = triangle.map(|corner| x[corner as usize]);
            let [low, high] = [f64::min, f64::max].map(|pick: fn(f64, f64) -> f64| {
                [0, 1, 2].map(|axis| corners.iter().map(|x| x[axis]).reduce(pick).unwrap_or(0.0))
            });
            let [low, high] = [low.map(|x| all.cell(x - reach)), high.map(|x| all.cell(x + reach))];
            for i in low[0]..=high[0] {
                for j in low[1]..=high[1] {
                    for k in low[2]..=high[2] {
                        all.cells.entry([i, j, k]).or_default().push(triangle);
                    }
                }
            }
        }
        all
    }

    fn cell(&self, x: f64) -> i64 {
        (x / (2.0 * self.reach)).floor() as i64
    }

    /// Whether a node is above the nearest triangle, 1, or below, -1; 0 if none is near, or if it is beside it.
    pub fn side_of(&self, node: u32) -> i8 {
        let x = self.x[node as usize];
        let Some(triangles) = self.cells.get(&x.map(|x| self.cell(x))) else { return 0 };
        let (mut nearest, mut side) = (self.reach, 0);
        for triangle in triangles.iter().filter(|triangle| !triangle.contains(&node)) {
            let [a, b, c] = triangle.map(|corner| self.x[corner as usize]);
            let apart = vertex_triangle([x, a, b, c]).apart;
            let distance = norm(apart);
            if distance < nearest {
                let normal = cross(sub(b, a), sub(c, a));
                let above = dot(apart, normal);
                nearest = distance;
                let is_clear = above.abs() >= CLEAR * distance * norm(normal);
                side = if is_clear { above.signum() as i8 } else { 0 };
            }
        }
        side
    }
}
