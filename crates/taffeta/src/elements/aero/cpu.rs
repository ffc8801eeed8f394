//! Air on triangles: forces by triangle, then gathered by node. A triangle pushes its three corners alike, so one vector is kept.
//!
//! They have a driver of their own: gusts are sampled and forces found in lanes, sixteen triangles at a time.

use crate::cpu::column::Column;
use crate::cpu::places::Groups;
use crate::cpu::shared::Shared;
use crate::cpu::simd::{Kernel, SimdLevel};
use crate::cpu::worker::Worker;
use crate::elements::aero;
use crate::elements::aero::aero::AirNow;
use crate::elements::cpu::ElementSet;
use crate::elements::element::List;
use crate::elements::gathered::around;
use crate::real::{Real, cross, sub};
use crate::topology::{Csr, LANES};
use std::ops::Range;

/// One number for each node of a slice, or triangle of a block.
type Lanes<T> = [T; LANES];

/// Triangles, [`LANES`] a block; the last block is filled up with its last triangle.
pub struct AeroTriangles<T> {
    /// Corners by solver index, by block and then by corner.
    corners: Groups,
    /// Number of triangles.
    #[cfg(feature = "gpu")]
    count: usize,
    /// 1/M [1/kg].
    lightness: Vec<T>,
    /// The triangles of each place.
    by_node: Csr,
    /// For each slice of places, whether all have as many triangles and those of neighbours follow each other.
    side_by_side: Vec<bool>,
    /// For each slice of places, the blocks of triangles around it.
    around: Vec<Range<u32>>,
    /// Force on each corner of each triangle [N].
    forces: [Shared<T>; 3],
}

impl<T: Real> AeroTriangles<T> {
    /// Those of a list that has some, among so many places.
    pub fn new(list: &List, places: usize) -> Self {
        let aero_triangles = list.all.nodes.as_chunks::<3>().0;
        let last = aero_triangles.len() - 1;
        let by_corner = Csr::corners(places, aero_triangles);
        let items = by_corner.items.iter().map(|corner| corner / 3).collect();
        let by_node = Csr { items, ..by_corner };
        let padded = || (0..aero_triangles.len().next_multiple_of(LANES)).map(|triangle| triangle.min(last));
        let mut corners = Groups::default();
        for first in (0..aero_triangles.len()).step_by(LANES) {
            let triangle = |lane: usize| aero_triangles[(first + lane).min(last)];
            (0..3).for_each(|corner| corners.push(std::array::from_fn(|lane| triangle(lane)[corner])));
        }
        Self {
            #[cfg(feature = "gpu")]
            count: aero_triangles.len(),
            forces: std::array::from_fn(|_| Column::zeros(padded().len()).into()),
            lightness: padded().map(|triangle| T::from_f64(list.all.numbers[triangle])).collect(),
            side_by_side: (0..places / LANES).map(|slice| side_by_side(&by_node, slice)).collect(),
            around: around(&by_node, 1),
            corners,
            by_node,
        }
    }
}

impl<T: Real> ElementSet<T> for AeroTriangles<T> {
    fn name(&self) -> &'static str {
        aero::NAME
    }

    fn blocks(&self) -> usize {
        self.lightness.len() / LANES
    }

    fn around(&self, slice: usize) -> Range<usize> {
        let Range { start, end } = self.around[slice];
        start as usize..end as usize
    }

    fn find(&self, worker: &Worker<'_, T>, blocks: Range<usize>) {
        let places = blocks.start * LANES..blocks.end * LANES;
        // SAFETY: parts of workers do not overlap, and forces are read only after the barrier.
        let force = self.forces.each_ref().map(|column| unsafe { column.write(places.clone()) });
        let Some(air) = worker.substep.air() else {
            // It was taken away while the scene ran.
            return force.into_iter().for_each(|column| column.fill(T::ZERO));
        };
        worker.nodes.level.run(AeroForces { aero_triangles: self, air, state: worker.old(), blocks, force });
    }

    fn gather(&self, level: SimdLevel, nodes: Range<usize>, sum: &mut [Lanes<T>; 3]) {
        // SAFETY: found before a barrier, and found again after the sub-step's last.
        let force = self.forces.each_ref().map(|column| unsafe { column.read() });
        let whole = nodes.start.is_multiple_of(LANES) && nodes.len() == LANES;
        if whole && self.side_by_side[nodes.start / LANES] {
            return level.run(GatherRows { aero_triangles: self.by_node.row(nodes.start), force, sum });
        }
        for (lane, node) in nodes.enumerate() {
            for &triangle in self.by_node.row(node) {
                for axis in 0..3 {
                    sum[axis][lane] += force[axis][triangle as usize];
                }
            }
        }
    }

    fn bytes(&self) -> usize {
        4 * self.lightness.len() * size_of::<T>()
            + self.corners.bytes()
            + 4 * (self.by_node.items.len() + self.by_node.offsets.len())
            + self.side_by_side.len()
    }

    #[cfg(feature = "gpu")]
    fn forces(&self) -> Vec<[T; 3]> {
        // SAFETY: asked for between frames, when no worker works.
        let force = self.forces.each_ref().map(|column| unsafe { column.read() });
        (0..self.count).map(|triangle| force.map(|column| column[triangle])).collect()
    }
}

fn side_by_side(by_node: &Csr, slice: usize) -> bool {
    let first = by_node.row(slice * LANES);
    (1..LANES).all(|lane| {
        let row = by_node.row(slice * LANES + lane);
        row.len() == first.len() && row.iter().zip(first).all(|(&own, &first)| own == first + lane as u32)
    })
}

/// Kernel: forces of blocks of triangles.
struct AeroForces<'a, T> {
    aero_triangles: &'a AeroTriangles<T>,
    air: &'a AirNow<T>,
    state: [&'a [T]; 6],
    blocks: Range<usize>,
    force: [&'a mut [T]; 3],
}

impl<T: Real> Kernel for AeroForces<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { aero_triangles, air, state, blocks, force: [fx, fy, fz] } = self;
        let mut corners = [[[T::ZERO; LANES]; 6]; 3];
        let mut flow = [[T::ZERO; LANES]; 3];
        for (index, block) in blocks.enumerate() {
            let range = block * LANES..(block + 1) * LANES;
            for (corner, lanes) in corners.iter_mut().enumerate() {
                let places = aero_triangles.corners.places(3 * block + corner);
                lanes.iter_mut().zip(state).for_each(|(lanes, column)| places.fetch(column, lanes));
            }
            find_flow(air, &corners, &mut flow);
            let lightness = &aero_triangles.lightness[range];
            let here = index * LANES..(index + 1) * LANES;
            let out = [&mut fx[here.clone()], &mut fy[here.clone()], &mut fz[here]];
            corner_forces(air, &corners, &flow, lightness, out);
        }
    }
}

/// The air's velocity less the mean of the corners', at the triangles' centroids.
#[inline(always)]
fn find_flow<T: Real>(air: &AirNow<T>, corners: &[[Lanes<T>; 6]; 3], flow: &mut [Lanes<T>; 3]) {
    let third = T::from_f64(1.0 / 3.0);
    let [a, b, c] = corners;
    let mut mean = [[T::ZERO; LANES]; 6];
    for axis in 0..6 {
        for lane in 0..LANES {
            mean[axis][lane] = (a[axis][lane] + b[axis][lane] + c[axis][lane]) * third;
        }
    }
    let [x, y, z, velocity @ ..] = mean;
    let blown = air.velocities(&[x, y, z]);
    for axis in 0..3 {
        for lane in 0..LANES {
            flow[axis][lane] = blown[axis][lane] - velocity[axis][lane];
        }
    }
}

/// The force on each corner of the triangles of a block.
#[inline(always)]
fn corner_forces<T: Real>(
    air: &AirNow<T>,
    corners: &[[Lanes<T>; 6]; 3],
    flow: &[Lanes<T>; 3],
    lightness: &[T],
    [fx, fy, fz]: [&mut [T]; 3],
) {
    let (fx, fy, fz) = (&mut fx[..LANES], &mut fy[..LANES], &mut fz[..LANES]);
    let lightness = &lightness[..LANES];
    for lane in 0..LANES {
        let place = |corner: &[Lanes<T>; 6]| [corner[0][lane], corner[1][lane], corner[2][lane]];
        let [a, b, c] = [place(&corners[0]), place(&corners[1]), place(&corners[2])];
        let twice = cross(sub(b, a), sub(c, a));
        let flow = [flow[0][lane], flow[1][lane], flow[2][lane]];
        [fx[lane], fy[lane], fz[lane]] = air.corner_force(twice, flow, lightness[lane]);
    }
}

/// Kernel: sums over triangles that lie side by side, as their nodes do.
struct GatherRows<'a, T> {
    /// Those of the first node.
    aero_triangles: &'a [u32],
    force: [&'a [T]; 3],
    sum: &'a mut [Lanes<T>; 3],
}

impl<T: Real> Kernel for GatherRows<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        for (sum, force) in self.sum.iter_mut().zip(self.force) {
            let mut total = *sum;
            for &triangle in self.aero_triangles {
                for (total, &force) in
                    total.iter_mut().zip(&force[triangle as usize..triangle as usize + LANES])
                {
                    *total += force;
                }
            }
            *sum = total;
        }
    }
}
