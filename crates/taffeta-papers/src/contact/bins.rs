//! Bins of fixed room in a box, as S2 has them. It says neither how large they are nor how many go into one: a side of one
//! and a half thicknesses and 32 places are our choice. To fill them from all particles then takes about as many looks
//! as 34 sub-steps by all pairs, as S2's numbers suggest.

use super::particle::{CONSTANTS, GROUP, PARTICLE, Particle};
use super::rung::Rung;
use super::serial::Serial;
use super::sheet::THICKNESS;
use taffeta::taffeta_gpu::bytemuck::{Pod, Zeroable};
use taffeta::taffeta_gpu::{Bindable, Bound, Buffer, DispatchList, Gpu, GpuError, Uniforms};

/// Bins as kernels see them.
pub const SOURCE: &str = include_str!("bins.wgsl");
/// Places of a bin.
pub const CAPACITY: u32 = 32;
/// Side of a bin, in thicknesses.
const SIDE: f64 = 1.5;
/// Bins around the settled sheet on each side of the box.
const MARGIN: f32 = 4.0;

/// Buffers with their names in the kernels.
type Named<'a> = (&'static str, &'a dyn Bindable);

/// The box as in `bins.wgsl`.
#[derive(Clone, Copy, Pod, Zeroable)]
#[bytemuck(crate = "taffeta::taffeta_gpu::bytemuck")]
#[repr(C)]
pub struct Layout {
    pub lowest: [f32; 3],
    pub side: f32,
    pub counts: [u32; 3],
    unused: u32,
}

/// Which particles are in each bin.
pub struct Table {
    pub filled: Buffer<u32>,
    pub members: Buffer<u32>,
}

/// Bins on a GPU.
pub struct Bins {
    layout: Uniforms<Layout>,
    /// One that is filled from all particles; or two, of which each is filled from the other.
    pub tables: Vec<Table>,
    left_out: Buffer<u32>,
    /// By the buffer of particles, then by the table before.
    refills: [Vec<Bound>; 2],
    /// Which table is filled.
    now: usize,
}

/// What bins have lost.
#[derive(Debug, PartialEq, Eq)]
pub struct Lost {
    /// Particles that found no room, in all fillings together.
    pub left_out: u32,
    /// Particles that are in no bin now.
    pub missing: u32,
}

impl Layout {
    /// The box around the particles where they are now, and some bins more.
    pub fn around(serial: &Serial) -> Self {
        let side = (SIDE * THICKNESS) as f32;
        let bound = |from: f32, of: fn(f32, f32) -> f32| {
            [0, 1, 2].map(|axis| serial.now.iter().map(|particle| particle.x[axis]).fold(from, of))
        };
        let lowest = bound(f32::INFINITY, f32::min).map(|x| x - MARGIN * side);
        let highest = bound(f32::NEG_INFINITY, f32::max).map(|x| x + MARGIN * side);
        let counts = [0, 1, 2].map(|axis| ((highest[axis] - lowest[axis]) / side).ceil() as u32);
        Self { lowest, side, counts, unused: 0 }
    }
}

impl Table {
    fn new(gpu: &Gpu, bins: usize) -> Result<Self, GpuError> {
        let members = gpu.buffer("members of bins", bins.saturating_mul(CAPACITY as usize))?;
        Ok(Self { filled: gpu.buffer("filled bins", bins)?, members })
    }
}

impl Bins {
    /// Bins for the `particles`, filled from all of the first buffer.
    pub fn new(
        gpu: &Gpu,
        rung: Rung,
        serial: &Serial,
        particles: &[Buffer<Particle>; 2],
    ) -> Result<Self, GpuError> {
        let (by_neighbours, box_of_all) = (rung == Rung::Refreshed, Layout::around(serial));
        let layout = gpu.uniforms("bins", 1)?;
        layout.write(gpu, &[box_of_all]);
        let bins = box_of_all.counts.iter().map(|&count| count as usize).product();
        let tables = (0..if by_neighbours { 2 } else { 1 }).map(|_| Table::new(gpu, bins));
        let tables = tables.collect::<Result<Vec<_>, _>>()?;
        let left_out = gpu.buffer("left out", 1)?;
        let bind = |entry, from: usize, before: usize, to: usize| {
            let sources = [PARTICLE, CONSTANTS, SOURCE, include_str!("refill.wgsl")];
            let kernel = gpu.kernel(entry, &sources, entry, &overrides())?;
            let buffers: [Named; 7] = [
                ("bins", &layout),
                ("input", &particles[from]),
                ("filled", &tables[before].filled),
                ("members", &tables[before].members),
                ("new_filled", &tables[to].filled),
                ("new_members", &tables[to].members),
                ("left_out", &left_out),
            ];
            Ok(kernel.bind(gpu, &buffers))
        };
        let from = |from: usize| match by_neighbours {
            true => [0, 1].into_iter().map(|before| bind("refresh", from, before, 1 - before)).collect(),
            false => Ok(vec![bind("scan", from, 0, 0)?]),
        };
        let refills = [from(0)?, from(1)?];
        let mut first = DispatchList::new();
        first.dispatch(&bind("scan", 0, 0, 0)?, &[], (bins as u32).div_ceil(GROUP));
        gpu.submit(&first)?;
        Ok(Self { layout, tables, left_out, refills, now: 0 })
    }

    /// What a sub-step sees, by the table that is filled.
    pub fn seen(&self) -> Vec<[Named<'_>; 3]> {
        self.tables
            .iter()
            .map(|table| -> [Named<'_>; 3] {
                [("bins", &self.layout), ("filled", &table.filled), ("members", &table.members)]
            })
            .collect()
    }

    /// Which table is filled.
    pub fn now(&self) -> usize {
        self.now
    }

    /// Records that they are filled again from buffer `from` of the particles.
    pub fn refill(&mut self, list: &mut DispatchList, from: usize) {
        let bins = self.tables[0].filled.len() as u32;
        list.dispatch(&self.refills[from][self.now], &[], bins.div_ceil(GROUP));
        self.now = (self.now + 1) % self.tables.len();
    }

    /// What they have lost of `count` particles, once all that was submitted is done.
    pub fn lost(&self, gpu: &Gpu, count: usize) -> Result<Lost, GpuError> {
        let held: u32 = self.tables[self.now].filled.read(gpu)?.iter().sum();
        let left_out = self.left_out.read(gpu)?[0];
        Ok(Lost { left_out, missing: (count as u32).saturating_sub(held) })
    }
}

/// What kernels with bins are told when they are compiled.
pub fn overrides() -> [(&'static str, f64); 1] {
    [("CAPACITY", f64::from(CAPACITY))]
}

impl Lost {
    /// For people: what the bins of `rung` lack.
    pub fn words(&self, rung: Rung) -> String {
        let nodes = |count: u32| format!("{count} {}", if count == 1 { "node" } else { "nodes" });
        if rung == Rung::Scanned {
            return format!("{} found no room in a bin, in all frames together", nodes(self.left_out));
        }
        let verb = if self.missing == 1 { "is" } else { "are" };
        let crossed = self.missing.saturating_sub(self.left_out);
        format!(
            "{} {verb} in no bin any more: {} found no room, {crossed} crossed a whole bin in a frame",
            nodes(self.missing),
            self.left_out
        )
    }
}
