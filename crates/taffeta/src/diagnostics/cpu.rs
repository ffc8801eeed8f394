//! Sums over the state at the end of a frame. Each tile is summed in 16 fixed lanes and f64, tiles in their order,
//! so that a sum does not depend on the number of workers or the vector width.

use crate::assembly::Assembly;
use crate::cpu::backend::Context;
use crate::cpu::cells::Cells;
use crate::cpu::feature::{Feature, Flow};
use crate::cpu::lanes::Lanes;
use crate::cpu::numbers::Numbers;
use crate::cpu::simd::Kernel;
use crate::cpu::tile::Tile;
use crate::cpu::worker::Worker;
use crate::real::{Real, cross, dot, sub};
use crate::report::{FrameSums, StateSums};
use crate::step::Op;
use crate::topology::LANES;

/// Triangles of a chunk at most.
const CHUNK: usize = 4096;

/// Sums over nodes, and the volumes of closed bodies.
pub struct Measures {
    /// By tile.
    nodes: Cells<StateSums>,
    chunks: Vec<VolumeChunk>,
    /// By chunk [m³].
    volumes: Numbers<1>,
}

/// A few triangles of one closed body, by solver index.
struct VolumeChunk {
    body: usize,
    /// A node of the body.
    origin: usize,
    triangles: Vec<[u32; 3]>,
}

impl VolumeChunk {
    /// All closed bodies, cut up.
    fn all(assembly: &Assembly) -> Vec<Self> {
        let mut all = Vec::new();
        for (body, described) in assembly.bodies.iter().enumerate() {
            let (origin, first) = (described.first, described.first as u32);
            let global = |triangle: &[u32; 3]| triangle.map(|node| node + first);
            all.extend(described.closed_triangles.chunks(CHUNK).map(|triangles| Self {
                body,
                origin,
                triangles: triangles.iter().map(global).collect(),
            }));
        }
        all
    }

    /// Volume [m³] under its triangles: Σ (a−o)·((b−o)×(c−o))/6, where o is a node of the body, so that no digits are
    /// lost far from the origin.
    fn volume<T: Real>(&self, state: [&[T]; 6]) -> f64 {
        let position = |node: usize| [0, 1, 2].map(|c| state[c][node].to_f64());
        let origin = position(self.origin);
        let mut six = 0.0;
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|node| sub(position(node as usize), origin));
            six += dot(a, cross(b, c));
        }
        six / 6.0
    }
}

impl Measures {
    /// Of a scene.
    pub fn new<T>(context: &Context<'_, T>) -> Self {
        let chunks = VolumeChunk::all(context.assembly);
        Self {
            nodes: Cells::new(context.nodes.tiles.len(), |_| StateSums::default()),
            volumes: Numbers::new(chunks.len()),
            chunks,
        }
    }

    /// Sums over the tiles that `chosen` says, as last measured.
    pub fn sums_of(&mut self, chosen: impl Fn(usize) -> bool) -> StateSums {
        let mut all = StateSums::default();
        let tiles = self.nodes.iter_mut().enumerate();
        tiles.filter(|(tile, _)| chosen(*tile)).for_each(|(_, sums)| all.add(sums));
        all
    }
}

impl<T: Real> Feature<T> for Measures {
    fn ops(&self) -> &'static [Op] {
        &[Op::MeasureTiles, Op::MeasureBodies]
    }

    fn run(&self, _: Op, worker: &mut Worker<'_, T>) -> Flow {
        let state = worker.old();
        for index in worker.part(self.chunks.len()) {
            self.volumes.set(index, [self.chunks[index].volume(state)]);
        }
        Flow::Go
    }

    fn tile(&self, _: Op, tile: &mut Tile<'_, T>) {
        let mut sums = StateSums::default();
        for (_, run) in tile.plan.runs() {
            sums.add(&tile.nodes.level.run(NodeSums {
                mass: &tile.nodes.mass[run.clone()],
                state: tile.old.map(|column| &column[run.clone()]),
            }));
        }
        *self.nodes.of(tile.index) = sums;
    }

    fn measure(&mut self, _: [&[T]; 6], _: usize, sums: &mut FrameSums) {
        let all = self.sums_of(|_| true);
        let (springs, max_stretch, contacts) = (sums.all.springs, sums.all.max_stretch, sums.all.contacts);
        sums.all = StateSums { springs, max_stretch, contacts, ..all };
        for (chunk, [volume]) in self.chunks.iter().zip(self.volumes.iter()) {
            *sums.volumes[chunk.body].get_or_insert(0.0) += volume;
        }
    }
}

/// Kernel: sums over nodes.
struct NodeSums<'a, T> {
    mass: &'a [T],
    state: [&'a [T]; 6],
}

impl<T: Real> Kernel for NodeSums<'_, T> {
    type Output = StateSums;
    #[inline(always)]
    fn run(self) -> StateSums {
        let n = self.mass.len();
        let mut lanes = [Lanes::ZERO; 10];
        for start in (0..n).step_by(LANES) {
            for (lane, i) in (start..n.min(start + LANES)).enumerate() {
                let m = self.mass[i].to_f64();
                let [x, y, z, u, v, w] = self.state.map(|column| column[i].to_f64());
                let (position, p) = ([x, y, z], [m * u, m * v, m * w]);
                let turning = cross(position, p);
                lanes[0].0[lane] += dot(p, [u, v, w]);
                for axis in 0..3 {
                    lanes[1 + axis].0[lane] += m * position[axis];
                    lanes[4 + axis].0[lane] += p[axis];
                    lanes[7 + axis].0[lane] += turning[axis];
                }
            }
        }
        let three = |first: usize| [0, 1, 2].map(|axis| lanes[first + axis].total());
        StateSums {
            m_v2: lanes[0].total(),
            m_x: three(1),
            momentum: three(4),
            angular_momentum: three(7),
            ..StateSums::default()
        }
    }
}
