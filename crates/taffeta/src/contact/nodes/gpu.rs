//! Tables of the bodies whose nodes touch each other.

use crate::build::Assembly;
use crate::build::body::BodyAssembly;
use crate::contact::nodes::build::Apart;
use crate::gpu::layout::{Meeting, NONE, Surface};
use crate::gpu::tables::Tables;
use crate::topology::{Csr, LANES};
use std::ops::Range;

/// Edge of a cell by the largest thickness: so much more that rounding in 32 bits hides no neighbour.
pub const CELL: f64 = 1.0 + 1.0 / 64.0;

/// Bytes of the arrays that a body needs to touch others, and what they hold.
pub fn arrays(body: &BodyAssembly) -> Vec<(u64, &'static str)> {
    let Some(touching) = &body.touching else { return Vec::new() };
    let apart = match &touching.apart {
        Apart::Grid(ways) => ways.len(),
        Apart::Mesh(rows) => rows.offsets.len() + rows.items.len(),
    };
    // Four buckets a node at most, and three numbers.
    vec![
        (body.places() as u64 * 28, "lists of nodes that touch"),
        (apart as u64 * 4, "nodes that do not touch"),
    ]
}

/// Refuses bodies that touch each other in several segments.
pub fn check_together(assembly: &Assembly, segments: &[Range<usize>], limit: u64) -> Result<(), String> {
    let touches = |index: &usize| assembly.bodies[*index].touching.is_some();
    let mut with = segments.iter().filter_map(|segment| segment.clone().find(touches));
    let (Some(one), Some(other)) = (with.next(), with.next()) else { return Ok(()) };
    Err(format!(
        "bodies `{}` and `{}` have self_collision and may touch each other, and the GPU does not give a kernel enough to hold \
         both: {limit} bytes in one piece; --backend cpu or coarser meshes would do",
        assembly.bodies[one].name, assembly.bodies[other].name
    ))
}

impl Tables {
    /// Adds the surfaces of bodies that touch others.
    pub(crate) fn add_surfaces(&mut self, bodies: &[BodyAssembly]) -> Result<(), String> {
        let touching = || bodies.iter().filter_map(|body| Some((body, body.touching.as_ref()?)));
        let widest = touching().map(|(_, touching)| touching.surface.thickness).fold(0.0, f64::max);
        if widest == 0.0 {
            return Ok(());
        }
        self.apart = vec![NONE; self.len() / LANES];
        for (number, (body, touching)) in (0..).zip(touching()) {
            let first = self.local(body.first);
            let slices = first as usize / LANES..(first as usize + body.places()) / LANES;
            self.apart[slices].fill(number);
            let apart = u32::try_from(self.apart.len());
            let apart = apart.map_err(|_| "too many nodes that do not touch for 32 bits".to_owned())?;
            let [high, wide] = match &touching.apart {
                Apart::Grid(ways) => self.add_ways(ways),
                Apart::Mesh(rows) => self.add_rows(rows),
            };
            let surface = touching.surface;
            self.surfaces.push(Surface {
                first,
                count: body.nodes as u32,
                cols: body.grid_layout.map_or(0, |[_, cols]| cols as u32),
                high,
                wide,
                apart,
                meeting: Meeting {
                    thickness: surface.thickness as f32,
                    friction: surface.friction as f32,
                    restitution: surface.restitution as f32,
                },
                cells_a_metre: (1.0 / (widest * CELL)) as f32,
            });
        }
        Ok(())
    }

    /// A bit for each way within the largest ones, and these.
    fn add_ways(&mut self, ways: &[[i32; 2]]) -> [u32; 2] {
        let [high, wide] =
            [0, 1].map(|axis| ways.iter().map(|way| way[axis].unsigned_abs()).max().unwrap_or(0));
        let mut bits = vec![0_u32; ((2 * high + 1) * (2 * wide + 1)).div_ceil(32) as usize];
        for &[row, col] in ways {
            let bit = (row + high as i32) * (2 * wide as i32 + 1) + col + wide as i32;
            bits[bit as usize / 32] |= 1 << (bit % 32);
        }
        self.apart.extend(bits);
        [high, wide]
    }

    fn add_rows(&mut self, rows: &Csr) -> [u32; 2] {
        self.apart.extend(rows.offsets.iter().chain(&rows.items));
        [0; 2]
    }

    /// Buckets of nodes that touch, a power of two; 0: there are none.
    pub fn buckets(&self) -> usize {
        let nodes: usize = self.surfaces.iter().map(|surface| surface.count as usize).sum();
        if nodes == 0 { 0 } else { (2 * nodes).next_power_of_two().max(64) }
    }

    /// Numbers in the lists of nodes that touch, with contacts and distances.
    pub fn pair_words(&self) -> usize {
        if self.surfaces.is_empty() { 0 } else { self.buckets() + 3 * self.len() }
    }
}
