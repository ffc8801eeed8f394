//! Clusters: up to sixteen neighbouring nodes, whose positions are packed and compared together.
//!
//! Source: Páll and Hess, "A flexible algorithm for calculating pair interactions on SIMD architectures", 2013.

use crate::assembly::Assembly;
use crate::contact::clusters::packed::{GROUP, Packed, about, motion};
use crate::cpu::simd::Kernel;
use crate::cpu::tile::Fields;
use crate::cpu::tiles::TilePlan;
use crate::real::Real;
use crate::topology::LANES;
use crate::topology::boxes::{Bounds, NOWHERE};
use std::ops::Range;

/// Neighbouring nodes of one body and one worker: a block of a grid, or a run of a mesh.
#[derive(Clone, Copy, Debug)]
pub struct Cluster {
    /// The body.
    pub body: u32,
    /// The first of its nodes.
    first: u32,
    /// From one row to the next.
    stride: u32,
    rows: u32,
    cols: u32,
}

impl Cluster {
    /// Number of nodes.
    pub fn len(&self) -> usize {
        (self.rows * self.cols) as usize
    }

    /// Its nodes, lane by lane.
    pub fn nodes(&self) -> impl Iterator<Item = usize> + use<> {
        let Self { first, stride, rows, cols, .. } = *self;
        (0..rows).flat_map(move |row| (0..cols).map(move |col| (first + row * stride + col) as usize))
    }
}

/// A rectangle of a grid, or a run of a mesh as one row.
struct Patch {
    body: usize,
    /// Place of the first column of the first row of all.
    origin: usize,
    stride: usize,
    rows: Range<usize>,
    cols: Range<usize>,
}

/// Cuts the self-colliding nodes of a worker into clusters. Neighbouring clusters are consecutive.
pub fn clusters(assembly: &Assembly, tiles: &[TilePlan]) -> Vec<Cluster> {
    let mut patches: Vec<Patch> = Vec::new();
    for tile in tiles.iter().filter(|tile| assembly.bodies[tile.body].self_contact().is_some()) {
        let body = &assembly.bodies[tile.body];
        match (body.grid_layout, patches.last_mut()) {
            (Some(_), Some(last))
                if (last.body, &last.cols, last.rows.end) == (tile.body, &tile.cols, tile.units.start) =>
            {
                last.rows.end = tile.units.end;
            }
            (Some([_, stride]), _) => {
                let (rows, cols) = (tile.units.clone(), tile.cols.clone());
                patches.push(Patch { body: tile.body, origin: body.first, stride, rows, cols });
            }
            (None, _) => patches.extend(tile.runs().map(|(_, cols)| Patch {
                body: tile.body,
                origin: 0,
                stride: 0,
                rows: 0..1,
                cols,
            })),
        }
    }
    patches.iter().flat_map(Patch::cut).collect()
}

impl Patch {
    /// As square as possible, along a Morton curve (Morton 1966).
    fn cut(&self) -> Vec<Cluster> {
        let [high, wide] = match self.rows.len() {
            1 => [1, LANES],
            2 | 3 => [2, LANES / 2],
            _ => [4, LANES / 4],
        };
        let mut cuts: Vec<(u64, Cluster)> = Vec::new();
        for (row, top) in (0..).zip(self.rows.clone().step_by(high)) {
            for (col, left) in (0..).zip(self.cols.clone().step_by(wide)) {
                let cluster = Cluster {
                    body: self.body as u32,
                    first: (self.origin + top * self.stride + left) as u32,
                    stride: self.stride as u32,
                    rows: (self.rows.end - top).min(high) as u32,
                    cols: (self.cols.end - left).min(wide) as u32,
                };
                cuts.push((spread(row) << 1 | spread(col), cluster));
            }
        }
        cuts.sort_by_key(|(along, _)| *along);
        cuts.into_iter().map(|(_, cluster)| cluster).collect()
    }
}

/// The bits of a number, each followed by a zero.
fn spread(number: u32) -> u64 {
    (0..32).fold(0, |bits, at| bits | u64::from(number >> at & 1) << (2 * at))
}

/// Kernel: packs clusters, and adds up their motion.
///
/// Each node of a cluster has moved by the first three numbers, plus a vector no longer than the fourth [m]. This
/// also holds for the sums of many sub-steps.
pub struct Pack<'a, T> {
    /// Clusters of this worker's nodes.
    pub clusters: &'a [Cluster],
    /// State of all nodes; others may be at theirs.
    pub state: &'a Fields<T>,
    pub packed: &'a mut [Packed<T>],
    pub moved: &'a mut [[f64; 4]],
    /// The same for the nodes of each group, in this sub-step only.
    pub balls: &'a mut [[f64; 4]],
}

impl<T: Real> Kernel for Pack<'_, T> {
    /// Bounds of the motion of all nodes.
    type Output = Bounds;
    #[inline(always)]
    fn run(self) -> Bounds {
        let mut all = NOWHERE;
        let groups = self.clusters.chunks(GROUP).zip(self.packed.chunks_mut(GROUP));
        for (((clusters, packed), moved), ball) in groups.zip(self.moved.chunks_mut(GROUP)).zip(self.balls) {
            let (mut motions, mut least, mut most) = ([[0.0; 4]; GROUP], NOWHERE[0], NOWHERE[1]);
            let each = clusters.iter().zip(packed).zip(moved).zip(&mut motions);
            for (((cluster, packed), moved), by) in each {
                let now = gather(cluster, self.state);
                *by = motion(&now, &packed.0, cluster.len());
                packed.0 = now;
                for axis in 0..4 {
                    moved[axis] += by[axis];
                }
                for axis in 0..3 {
                    let (low, high) = (by[axis] - by[3], by[axis] + by[3]);
                    least[axis] = if low < least[axis] { low } else { least[axis] };
                    most[axis] = if high > most[axis] { high } else { most[axis] };
                }
            }
            *ball = about(&motions[..clusters.len()], least, most);
            for axis in 0..3 {
                all[0][axis] = if least[axis] < all[0][axis] { least[axis] } else { all[0][axis] };
                all[1][axis] = if most[axis] > all[1][axis] { most[axis] } else { all[1][axis] };
            }
        }
        all
    }
}

/// Positions of the nodes of a cluster of this worker.
#[inline(always)]
fn gather<T: Real>(cluster: &Cluster, state: &Fields<T>) -> [[T; LANES]; 3] {
    // The usual sizes of clusters, so that a row is one load.
    match (cluster.rows, cluster.cols) {
        (4, 4) => gather_rows::<T, 4>(cluster, state),
        (1, 16) => gather_rows::<T, 16>(cluster, state),
        _ => gather_rows::<T, 1>(cluster, state),
    }
}

#[inline(always)]
fn gather_rows<T: Real, const N: usize>(cluster: &Cluster, state: &Fields<T>) -> [[T; LANES]; 3] {
    let mut now = [[T::from_f64(f64::NAN); LANES]; 3];
    let mut lane = 0;
    for row in 0..cluster.rows as usize {
        for col in (0..cluster.cols as usize).step_by(N) {
            let from = cluster.first as usize + row * cluster.stride as usize + col;
            for (now, column) in now.iter_mut().zip(state) {
                // SAFETY: these nodes are this worker's, and no other reference to them lives.
                let nodes = unsafe { column.write(from..from + N) };
                now[lane..lane + N].copy_from_slice(nodes);
            }
            lane += N;
        }
    }
    now
}
