//! How the nodes are cut into tiles, and tiles shared among workers.

use super::grid::GridSprings;
use super::mesh::GatheredSprings;
use crate::assembly::{Assembly, BodyAssembly, BodySprings};
use crate::real::Real;
use crate::topology::{Gather, LANES};
use std::ops::Range;

/// Nodes of a tile: enough to make the cost of a stage's call small, few enough to stay in the first cache.
const TILE_NODES: usize = 512;

/// A body's springs in the backend's numbers.
pub enum TiledSprings<T> {
    /// By rows.
    Grid(GridSprings<T>),
    /// By slices.
    Mesh(Vec<GatheredSprings<T>>),
}

/// Neighbouring nodes of one body.
#[derive(Clone, Debug)]
pub struct TilePlan {
    /// The body.
    pub body: usize,
    /// Its nodes, by solver index.
    pub nodes: Range<usize>,
    /// Its rows (grids) or slices (meshes).
    pub units: Range<usize>,
}

impl<T: Real> TiledSprings<T> {
    /// Lays out the springs of a body.
    pub fn new(body: &mut BodyAssembly) -> Result<Self, String> {
        let nodes = body.nodes;
        match &mut body.springs {
            BodySprings::Grid(along) => {
                let grid = body.grid.as_ref().ok_or("a grid's springs without a grid")?;
                Ok(Self::Grid(GridSprings {
                    rows: grid.rows as usize,
                    cols: grid.cols as usize,
                    along: along.map(|direction| direction.map(super::grid::Direction::new)),
                }))
            }
            BodySprings::Mesh(lists) => lists
                .iter()
                .map(|list| {
                    let gather = Gather::new(nodes, &list.pairs, &list.rest)?;
                    Ok(GatheredSprings::new(list.kind, list.pairs.len(), (list.k, list.d), gather, nodes))
                })
                .collect::<Result<_, String>>()
                .map(Self::Mesh),
        }
    }

    /// Bytes that the springs take; a grid's follow from its size.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Grid(_) => 0,
            Self::Mesh(sets) => sets.iter().map(GatheredSprings::bytes).sum(),
        }
    }
}

/// Cuts all bodies into tiles: whole rows of grids, whole slices of meshes.
pub fn tiles(assembly: &Assembly) -> Vec<TilePlan> {
    let mut tiles = Vec::new();
    for (index, body) in assembly.bodies.iter().enumerate() {
        let (unit, units) = match &body.grid {
            Some(grid) => (grid.cols as usize, grid.rows as usize),
            None => (LANES, body.nodes.div_ceil(LANES)),
        };
        let together = (TILE_NODES / unit).max(1);
        for start in (0..units).step_by(together) {
            let units = start..units.min(start + together);
            let last = (units.end * unit).min(body.nodes);
            tiles.push(TilePlan { body: index, nodes: body.first + units.start * unit..body.first + last, units });
        }
    }
    tiles
}

/// Which tiles each worker takes: neighbouring ones, with about the same number of nodes.
pub fn shares(tiles: &[TilePlan], workers: usize) -> Vec<Range<usize>> {
    let total: usize = tiles.iter().map(|tile| tile.nodes.len()).sum();
    let mut shares = Vec::with_capacity(workers);
    let (mut start, mut done) = (0, 0);
    for worker in 1..=workers {
        let goal = total * worker / workers;
        let mut end = start;
        while end < tiles.len() && (worker == workers || done + tiles[end].nodes.len() / 2 < goal) {
            done += tiles[end].nodes.len();
            end += 1;
        }
        shares.push(start..end);
        start = end;
    }
    shares
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tile_is_given_to_one_worker_and_shares_are_even() {
        let tiles: Vec<_> =
            (0..37).map(|i| TilePlan { body: 0, nodes: i * 160..(i + 1) * 160, units: i..i + 1 }).collect();
        for workers in [1, 2, 3, 8, 50] {
            let shares = shares(&tiles, workers);
            assert_eq!(shares.len(), workers);
            assert!(shares.windows(2).all(|w| w[0].end == w[1].start));
            assert_eq!((shares[0].start, shares[workers - 1].end), (0, 37));
            assert!(shares.iter().all(|s| s.len() <= 37_usize.div_ceil(workers) + 1));
        }
    }
}
