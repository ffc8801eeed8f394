//! Cuts nodes into tiles, and tiles into chunks for workers.

use crate::assembly::Assembly;
use crate::assembly::body::BodyAssembly;
use crate::topology::LANES;
use std::ops::Range;

/// Nodes of a tile: enough to make calls of stages cheap, few enough to stay in the first-level cache.
pub(crate) const TILE_NODES: usize = 512;

/// Most columns of a grid that are swept together, so that the forces of their last rows stay in cache.
const STRIP: usize = 2048;

/// Neighbouring nodes of one body: slices of a mesh, or a rectangle of a grid.
#[derive(Clone, Debug)]
pub struct TilePlan {
    /// The body, and the solver index of its first node.
    pub body: usize,
    pub first: usize,
    /// Its rows (grids) or slices (meshes).
    pub units: Range<usize>,
    /// Its columns, of a grid.
    pub cols: Range<usize>,
    /// Solver indices of its first run of nodes.
    run: Range<usize>,
    /// Number of runs, and the stride from one to the next.
    runs: (usize, usize),
}

impl TilePlan {
    /// The runs of nodes with neighbouring solver indices, each with its place among the tile's nodes.
    pub fn runs(&self) -> impl Iterator<Item = (usize, Range<usize>)> + use<> {
        let (run, (count, stride)) = (self.run.clone(), self.runs);
        (0..count).map(move |i| (i * run.len(), run.start + i * stride..run.end + i * stride))
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.run.len() * self.runs.0
    }

    fn of_mesh(index: usize, body: &BodyAssembly, units: Range<usize>) -> Self {
        let end = (units.end * LANES).min(body.nodes);
        let run = body.first + units.start * LANES..body.first + end;
        Self { body: index, first: body.first, units, cols: 0..0, run, runs: (1, 0) }
    }

    fn of_grid(
        index: usize,
        body: &BodyAssembly,
        all_cols: usize,
        rows: Range<usize>,
        cols: Range<usize>,
    ) -> Self {
        let start = body.first + rows.start * all_cols + cols.start;
        let (run, runs) = if cols.len() == all_cols {
            (start..start + rows.len() * all_cols, (1, 0))
        } else {
            (start..start + cols.len(), (rows.len(), all_cols))
        };
        Self { body: index, first: body.first, units: rows, cols, run, runs }
    }
}

/// Cuts all bodies into tiles: whole slices of meshes; strips of columns of grids, from the top row to the last.
pub fn tiles(assembly: &Assembly) -> Vec<TilePlan> {
    let mut tiles = Vec::new();
    for (index, body) in assembly.bodies.iter().enumerate() {
        match body.grid_layout {
            Some([rows, all_cols]) => {
                let strip = all_cols.div_ceil(all_cols.div_ceil(STRIP)).next_multiple_of(LANES);
                for cols in chunks(all_cols, strip) {
                    let together = (TILE_NODES / cols.len()).max(1);
                    tiles.extend(
                        chunks(rows, together)
                            .map(|rows| TilePlan::of_grid(index, body, all_cols, rows, cols.clone())),
                    );
                }
            }
            None => {
                let slices = body.nodes.div_ceil(LANES);
                tiles.extend(
                    chunks(slices, TILE_NODES / LANES).map(|units| TilePlan::of_mesh(index, body, units)),
                );
            }
        }
    }
    tiles
}

/// 0 to `count` in pieces of `size`.
fn chunks(count: usize, size: usize) -> impl Iterator<Item = Range<usize>> {
    (0..count).step_by(size).map(move |start| start..count.min(start + size))
}

/// The chunk of each worker: neighbouring tiles, with about the same number of nodes.
pub fn chunks_by_nodes(tiles: &[TilePlan], workers: usize) -> Vec<Range<usize>> {
    chunks_by_cost(&tiles.iter().map(|tile| tile.len() as f64).collect::<Vec<_>>(), workers)
}

/// The chunk of each worker: neighbouring tiles, whose `costs` are about the same.
pub fn chunks_by_cost(costs: &[f64], workers: usize) -> Vec<Range<usize>> {
    let total: f64 = costs.iter().sum();
    let mut parts = Vec::with_capacity(workers);
    let (mut start, mut done) = (0, 0.0);
    for worker in 1..=workers {
        let goal = total * worker as f64 / workers as f64;
        let mut end = start;
        while end < costs.len() && (worker == workers || done + costs[end] / 2.0 < goal) {
            done += costs[end];
            end += 1;
        }
        parts.push(start..end);
        start = end;
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Body, Mass, Mesh, Scene};

    #[test]
    fn every_node_is_in_one_tile_and_every_tile_in_one_share() {
        let heavy = |mesh| Body::cloth("", mesh).with_mass(Mass::Node(1.0));
        let scene = Scene::new("")
            .body(heavy(Mesh::grid(37, 2 * STRIP as u32 + 5, [1.0, 1.0])))
            .body(heavy(Mesh::chain(700, 1.0)))
            .body(heavy(Mesh::grid(100, 7, [1.0, 1.0])));
        let assembly = Assembly::new(&scene).unwrap();
        let tiles = tiles(&assembly);
        let mut seen = vec![0; assembly.places];
        for node in tiles.iter().flat_map(|tile| tile.runs().flat_map(|(_, run)| run)) {
            seen[node] += 1;
        }
        for body in &assembly.bodies {
            assert!(seen[body.solver_range()].iter().all(|&count| count == 1));
        }
        for workers in [1, 2, 3, 8, 1000] {
            let parts = chunks_by_nodes(&tiles, workers);
            assert_eq!(parts.len(), workers);
            assert!(parts.windows(2).all(|w| w[0].end == w[1].start));
            assert_eq!((parts[0].start, parts[workers - 1].end), (0, tiles.len()));
        }
    }
}
