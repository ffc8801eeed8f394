//! Sums over the state at the end of a frame. Each tile is summed in 16 fixed lanes and f64, tiles in their order,
//! so that a sum does not depend on the number of workers or the vector width.

use crate::build::Assembly;
use crate::cpu::backend::Setup;
use crate::cpu::simd::Kernel;
use crate::cpu::tiles::{TilePlan, TiledSprings};
use crate::diagnostics::{FrameSums, StateSums};
use crate::elements::hinge::hinge;
use crate::elements::spring::cpu_mesh::{GatheredSprings, gather, lanes_of};
use crate::elements::spring::spring;
use crate::real::{Real, cross, dot, norm, sub};
use crate::topology::LANES;
use std::ops::Range;

/// A few triangles of one closed body.
pub struct VolumeChunk {
    body: usize,
    triangles: Range<usize>,
}

impl VolumeChunk {
    /// All closed bodies, cut up.
    pub fn all(assembly: &Assembly) -> Vec<Self> {
        let cut = |(body, count): (usize, usize)| {
            (0..count).step_by(4096).map(move |i| Self { body, triangles: i..count.min(i + 4096) })
        };
        let counts = assembly.bodies.iter().map(|body| body.closed_triangles.len());
        counts.enumerate().flat_map(cut).collect()
    }
}

/// Volume [m³] under a chunk's triangles: Σ (a−o)·((b−o)×(c−o))/6, where o is a node of the body, so that no digits
/// are lost far from the origin.
pub fn chunk_volume<T: Real>(setup: &Setup<T>, chunk: usize, state: [&[T]; 6]) -> f64 {
    let VolumeChunk { body, triangles } = &setup.volume_chunks[chunk];
    let body = &setup.assembly.bodies[*body];
    let place = |node: u32| [0, 1, 2].map(|c| state[c][body.first + node as usize].to_f64());
    let origin = place(0);
    let mut six = 0.0;
    for triangle in &body.closed_triangles[triangles.clone()] {
        let [a, b, c] = triangle.map(|node| sub(place(node), origin));
        six += dot(a, cross(b, c));
    }
    six / 6.0
}

/// Adds up tiles and chunks in their order.
pub fn frame_sums<T: Real>(
    setup: &Setup<T>,
    state: [&[T]; 6],
    tiles: &[StateSums],
    chunks: &[f64],
) -> FrameSums {
    let mut all = StateSums::default();
    for tile in tiles {
        all.add(tile);
    }
    let mut volumes = setup.assembly.no_volumes();
    for (chunk, volume) in setup.volume_chunks.iter().zip(chunks) {
        *volumes[chunk.body].get_or_insert(0.0) += volume;
    }
    FrameSums { all, hinges: hinge_energy(setup, state), volumes, ..FrameSums::default() }
}

/// Energy of all hinges [J], in their order.
fn hinge_energy<T: Real>(setup: &Setup<T>, state: [&[T]; 6]) -> f64 {
    let hinges = &setup.hinges;
    let mut sum = 0.0;
    for (range, k, _) in &hinges.bodies {
        for i in range.clone() {
            let corners = hinges.corners[i].map(|n| [0, 1, 2].map(|c| state[c][n as usize]));
            sum += hinge::energy(corners, *k, hinges.rest[i].angle).to_f64();
        }
    }
    sum
}

/// Sums of one tile.
pub fn tile_sums<T: Real>(setup: &Setup<T>, plan: &TilePlan, state: [&[T]; 6]) -> StateSums {
    let mut sums = StateSums::default();
    for (_, run) in plan.runs() {
        sums.add(&setup.level.run(NodeSums {
            mass: &setup.mass[run.clone()],
            state: state.map(|column| &column[run.clone()]),
        }));
    }
    let first = setup.assembly.bodies[plan.body].first;
    let state = state.map(|column| &column[first..]);
    match &setup.springs[plan.body] {
        TiledSprings::Grid(grid) => {
            for row in plan.units.clone() {
                for direction in 0..6 {
                    let end = grid.count(direction, row).min(plan.cols.end);
                    let count = end.saturating_sub(plan.cols.start);
                    if let (Some(along), 1..) = (grid.along[direction], count) {
                        let (a, b) = grid.ends(direction, row);
                        let [a, b] = [a + plan.cols.start, b + plan.cols.start];
                        setup.level.run(RowStretch { state, a, b, count, along, sums: &mut sums });
                    }
                }
            }
        }
        TiledSprings::Mesh(sets) => {
            for springs in sets {
                for slice in plan.units.clone() {
                    setup.level.run(SliceStretch { state, springs, slice, sums: &mut sums });
                }
            }
        }
    }
    sums
}

/// 16 sums side by side, added up in order at the end.
#[derive(Clone, Copy)]
struct Lanes([f64; LANES]);

impl Lanes {
    const ZERO: Self = Self([0.0; LANES]);

    #[inline(always)]
    fn total(&self) -> f64 {
        let mut sum = 0.0;
        for lane in self.0 {
            sum += lane;
        }
        sum
    }

    #[inline(always)]
    fn largest(&self) -> f64 {
        let mut largest = 0.0;
        for lane in self.0 {
            largest = if lane > largest { lane } else { largest };
        }
        largest
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

/// Kernel: energy and stretch of one row's springs in one direction.
struct RowStretch<'a, T> {
    state: [&'a [T]; 6],
    a: usize,
    b: usize,
    count: usize,
    along: crate::elements::spring::cpu_grid::Direction<T>,
    sums: &'a mut StateSums,
}

impl<T: Real> Kernel for RowStretch<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { state, a, b, count, along, sums } = self;
        let [ax, ay, az] = [0, 1, 2].map(|c| &state[c][a..a + count]);
        let [bx, by, bz] = [0, 1, 2].map(|c| &state[c][b..b + count]);
        let (mut energy, mut longest) = (Lanes::ZERO, Lanes::ZERO);
        for start in (0..count).step_by(LANES) {
            for (lane, i) in (start..count.min(start + LANES)).enumerate() {
                let length = norm([bx[i] - ax[i], by[i] - ay[i], bz[i] - az[i]]);
                energy.0[lane] += spring::energy(length, along.k, along.rest_length).to_f64();
                let length = length.to_f64();
                longest.0[lane] = if length > longest.0[lane] { length } else { longest.0[lane] };
            }
        }
        sums.springs += energy.total();
        let stretch = longest.largest() / along.rest_length.to_f64();
        sums.max_stretch = if stretch > sums.max_stretch { stretch } else { sums.max_stretch };
    }
}

/// Kernel: energy and stretch of one slice's springs. Each is met from both ends: half its energy each time.
struct SliceStretch<'a, T> {
    state: [&'a [T]; 6],
    springs: &'a GatheredSprings<T>,
    slice: usize,
    sums: &'a mut StateSums,
}

impl<T: Real> Kernel for SliceStretch<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { state, springs, slice, sums } = self;
        let own = lanes_of(&state, slice);
        let mut other = [[T::ZERO; LANES]; 6];
        let (mut energy, mut longest) = (Lanes::ZERO, Lanes::ZERO);
        for (neighbours, rest_lengths) in springs.slice(slice) {
            gather(&state, neighbours, &mut other);
            for lane in 0..LANES {
                let rest = rest_lengths[lane];
                let d = [
                    other[0][lane] - own[0][lane],
                    other[1][lane] - own[1][lane],
                    other[2][lane] - own[2][lane],
                ];
                let length = norm(d);
                let (length, rest, k) =
                    if rest > T::ZERO { (length, rest, springs.k) } else { (T::ZERO, T::ONE, T::ZERO) };
                energy.0[lane] += spring::energy(length, k, rest).to_f64() * 0.5;
                let stretch = (length / rest).to_f64();
                longest.0[lane] = if stretch > longest.0[lane] { stretch } else { longest.0[lane] };
            }
        }
        sums.springs += energy.total();
        let stretch = longest.largest();
        sums.max_stretch = if stretch > sums.max_stretch { stretch } else { sums.max_stretch };
    }
}
