//! Grids, cubes and chains.

use crate::scene::{Chain, Cube};
use crate::topology::Surface;
use crate::topology::shapes::{from_chain, from_faces};

/// A grid as the engine sees it, written out: node r·cols + c at x = (c/(cols−1) − ½)·size₀,
/// z = (r/(rows−1) − ½)·size₁ [m], y = 0; a single row or column lies at 0 and is a chain. Each square is a quad
/// and the triangles (i0 i2 i1), (i1 i2 i3), where i1 is the next along x and i2 along z; they look to +y.
///
/// ```
/// use taffeta::topology::shapes::grid_surface;
///
/// let sheet = grid_surface(2, 3, [0.4, 0.1]);
/// assert_eq!(sheet.nodes[0], [-0.2, 0.0, -0.05]);
/// assert_eq!(sheet.triangles, [[0, 3, 1], [1, 3, 4], [1, 4, 2], [2, 4, 5]]);
/// ```
pub fn grid_surface(rows: u32, cols: u32, size: [f64; 2]) -> Surface {
    let along = |i: u32, count: u32, size: f64| match count {
        0 | 1 => 0.0,
        _ => (f64::from(i) / f64::from(count - 1) - 0.5) * size,
    };
    let node = move |r: u32| (0..cols).map(move |c| [along(c, cols, size[0]), 0.0, along(r, rows, size[1])]);
    let nodes: Vec<[f64; 3]> = (0..rows).flat_map(node).collect();
    if rows < 2 || cols < 2 {
        return from_chain(nodes);
    }
    let squares = (0..rows - 1).flat_map(|r| (0..cols - 1).map(move |c| r * cols + c));
    from_faces(nodes, squares.map(|i| vec![i, i + cols, i + cols + 1, i + 1]))
}

/// Nodes in a row along x, centred.
pub(crate) fn chain(chain: Chain) -> Surface {
    let links = f64::from(chain.links);
    from_chain((0..=chain.links).map(|i| [(f64::from(i) / links - 0.5) * chain.length, 0.0, 0.0]).collect())
}

/// A cube of divisions² squares a face: nodes are the points of the lattice (divisions + 1)³ that lie on the
/// surface, by x, then y, then z.
pub(crate) fn cube(cube: Cube) -> Surface {
    let n = cube.divisions;
    let numbers = LatticeShell { n };
    let place = |i: u32| (f64::from(i) / f64::from(n) - 0.5) * cube.size;
    let mut nodes = Vec::new();
    for x in 0..=n {
        for y in 0..=n {
            let step = if x == 0 || x == n || y == 0 || y == n { 1 } else { n };
            nodes.extend((0..=n).step_by(step as usize).map(|z| [x, y, z].map(place)));
        }
    }
    from_faces(nodes, faces(n).map(move |corners| corners.map(|p| numbers.index(p)).to_vec()))
}

/// Corners of the squares of a cube's six faces on the lattice, counter-clockwise from outside.
fn faces(n: u32) -> impl Iterator<Item = [[u32; 3]; 4]> {
    let sides = (0..3).flat_map(move |axis| [(axis, 0), (axis, n)]);
    sides.flat_map(move |(axis, level)| {
        (0..n * n).map(move |square| {
            let [i, j] = [square / n, square % n];
            let turn =
                if level == 0 { [[0, 0], [0, 1], [1, 1], [1, 0]] } else { [[0, 0], [1, 0], [1, 1], [0, 1]] };
            turn.map(|[u, v]| {
                let mut p = [level; 3];
                p[(axis + 1) % 3] = i + u;
                p[(axis + 2) % 3] = j + v;
                p
            })
        })
    })
}

/// Numbers of the points on the surface of a lattice of (n + 1)³.
#[derive(Clone, Copy)]
struct LatticeShell {
    n: u32,
}

impl LatticeShell {
    /// Number of a surface point, counted by x, then y, then z.
    fn index(self, [x, y, z]: [u32; 3]) -> u32 {
        let n = self.n;
        let [end, ring] = [(n + 1) * (n + 1), 4 * n];
        let before_x = if x == 0 { 0 } else { end + (x - 1) * ring };
        if x == 0 || x == n {
            return before_x + y * (n + 1) + z;
        }
        let before_y = if y == 0 { 0 } else { n + 1 + (y - 1) * 2 };
        before_x + before_y + if y == 0 || y == n { z } else { z / n }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_starts_at_minus_x_minus_z_and_looks_up() {
        let grid = grid_surface(2, 3, [4.0, 1.0]);
        assert_eq!(grid.nodes[0], [-2.0, 0.0, -0.5]);
        assert_eq!(grid.nodes[5], [2.0, 0.0, 0.5]);
        assert_eq!(grid.triangles, [[0, 3, 1], [1, 3, 4], [1, 4, 2], [2, 4, 5]]);
        assert_eq!(grid.polygons.iter().next().unwrap(), [0, 3, 4, 1]);
    }

    #[test]
    fn a_single_row_or_column_is_a_chain() {
        let row = grid_surface(1, 3, [2.0, 0.0]);
        assert_eq!(row.nodes, [[-1.0, 0.0, 0.0], [0.0; 3], [1.0, 0.0, 0.0]]);
        assert_eq!((row.links.as_slice(), row.triangles.len()), ([[0, 1], [1, 2]].as_slice(), 0));
        let column = grid_surface(3, 1, [0.0, 2.0]);
        assert_eq!(column.nodes[2], [0.0, 0.0, 1.0]);
    }

    #[test]
    fn a_chain_is_centred_and_starts_at_minus_x() {
        let chain = chain(Chain { links: 4, length: 2.0 });
        assert_eq!(chain.nodes.iter().map(|p| p[0]).collect::<Vec<_>>(), [-1.0, -0.5, 0.0, 0.5, 1.0]);
        assert_eq!(chain.links, [[0, 1], [1, 2], [2, 3], [3, 4]]);
    }
}
