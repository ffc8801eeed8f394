//! S2's programs for a GPU ("CUDA Cloth Simulation"), to compare with: six rungs, each of which goes on from the one before.

mod bins;
#[cfg(test)]
mod tests;
mod timing;

pub use timing::{refuse, run};

use super::serial::{self, Serial};
use super::{NODE_MASS, Rung, THICKNESS, WIND};
use bins::Bins;
use taffeta::taffeta_gpu::bytemuck::{Pod, Zeroable};
use taffeta::taffeta_gpu::{Bindable, Bound, Buffer, DispatchList, Gpu, GpuError};

/// Invocations of a workgroup.
const GROUP: u32 = 64;

const PARTICLE: &str = include_str!("ladder/particle.wgsl");
const CONSTANTS: &str = include_str!("ladder/constants.wgsl");
const BINS: &str = include_str!("ladder/bins.wgsl");

/// A particle as in `particle.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[bytemuck(crate = "taffeta::taffeta_gpu::bytemuck")]
#[repr(C)]
struct Particle {
    x: [f32; 4],
    v: [f32; 4],
}

/// A spring as in `particle.wgsl`.
#[derive(Clone, Copy, Pod, Zeroable)]
#[bytemuck(crate = "taffeta::taffeta_gpu::bytemuck")]
#[repr(C)]
struct Spring {
    other: u32,
    rest: f32,
    k: f32,
    d: f32,
}

/// The world as in `particle.wgsl`.
#[derive(Clone, Copy, Pod, Zeroable)]
#[bytemuck(crate = "taffeta::taffeta_gpu::bytemuck")]
#[repr(C)]
struct World {
    ball: [f32; 4],
    wind: [f32; 3],
    drag: f32,
    floor_y: f32,
    thickness: f32,
    mass: f32,
    gravity: f32,
    h: f32,
    held: u32,
    unused: [u32; 2],
}

/// The bench's sheet on a GPU, by the program of a rung.
pub struct Baseline {
    gpu: Gpu,
    rung: Rung,
    particles: [Buffer<Particle>; 2],
    /// By the buffer of particles that is read, then by the table of bins.
    substeps: [Vec<Bound>; 2],
    bins: Option<Bins>,
    /// Which buffer has the particles.
    now: usize,
}

impl Rung {
    /// S2's rungs on a GPU, in its order.
    pub const LADDER: [Self; 6] =
        [Self::Naive, Self::Constants, Self::Squared, Self::Swapped, Self::Scanned, Self::Refreshed];

    fn has_bins(self) -> bool {
        self >= Self::Scanned
    }

    /// The program of a sub-step, in whole files.
    fn sources(self) -> Vec<&'static str> {
        let bound = if self >= Self::Constants { CONSTANTS } else { include_str!("ladder/naive.wgsl") };
        let near = if self >= Self::Squared {
            include_str!("ladder/squares.wgsl")
        } else {
            include_str!("ladder/roots.wgsl")
        };
        let mut sources = vec![PARTICLE, bound, near, include_str!("ladder/substep.wgsl")];
        if self.has_bins() {
            sources.extend([BINS, include_str!("ladder/binned.wgsl")]);
        } else {
            sources.push(include_str!("ladder/all.wgsl"));
        }
        sources
    }
}

impl Baseline {
    /// Starts from the same state as `serial`.
    pub fn new(gpu: &Gpu, rung: Rung, serial: &Serial) -> Result<Self, GpuError> {
        let particles: Vec<Particle> = serial.now.iter().map(Particle::from).collect();
        let springs: Vec<Spring> = serial.springs.iter().map(Spring::from).collect();
        let particles =
            [gpu.buffer_from("particles", &particles)?, gpu.buffer_from("particles, new", &particles)?];
        let starts = gpu.buffer_from("starts", &serial.starts)?;
        let springs = gpu.buffer_from("springs", &springs)?;
        let world = world(gpu, rung, serial)?;
        let bins = match rung.has_bins() {
            true => Some(Bins::new(gpu, rung, serial, &particles)?),
            false => None,
        };
        let overrides = if rung.has_bins() { &bins::overrides()[..] } else { &[] };
        let kernel = gpu.kernel("substep", &rung.sources(), "substep", overrides)?;
        let bound = |from: usize, table: &[(&str, &dyn Bindable)]| {
            let buffers: [(&str, &dyn Bindable); 5] = [
                ("world", &*world),
                ("starts", &starts),
                ("springs", &springs),
                ("input", &particles[from]),
                ("result", &particles[1 - from]),
            ];
            kernel.bind(gpu, &[&buffers, table].concat())
        };
        let substeps = [0, 1].map(|from| match &bins {
            Some(bins) => bins.seen().iter().map(|table| bound(from, table)).collect(),
            None => vec![bound(from, &[])],
        });
        Ok(Self { gpu: gpu.clone(), rung, particles, substeps, bins, now: 0 })
    }

    /// Records a frame.
    fn frame(&mut self, list: &mut DispatchList, substeps: u32) {
        self.refresh(list);
        (0..substeps).for_each(|_| self.step(list));
    }

    /// Records that bins are filled anew, where there are any.
    fn refresh(&mut self, list: &mut DispatchList) {
        if let Some(bins) = &mut self.bins {
            list.stage("refresh");
            bins.refill(list, self.now);
        }
    }

    /// Records a sub-step.
    fn step(&mut self, list: &mut DispatchList) {
        list.stage("sub-steps");
        let table = self.bins.as_ref().map_or(0, Bins::now);
        let groups = (self.particles[0].len() as u32).div_ceil(GROUP);
        list.dispatch(&self.substeps[self.now][table], &[], groups);
        if self.rung >= Rung::Swapped {
            self.now = 1 - self.now;
        } else {
            list.copy_buffer(&self.particles[1], &self.particles[0]);
        }
    }

    /// The particles, once all that was submitted is done.
    fn particles(&self) -> Result<Vec<Particle>, GpuError> {
        self.particles[self.now].read(&self.gpu)
    }
}

/// What all particles share, where constants lie or in storage.
fn world(gpu: &Gpu, rung: Rung, serial: &Serial) -> Result<Box<dyn Bindable>, GpuError> {
    if rung < Rung::Constants {
        return Ok(Box::new(gpu.buffer_from("world", &[World::of(serial)])?));
    }
    let world = gpu.uniforms("world", 1)?;
    world.write(gpu, &[World::of(serial)]);
    Ok(Box::new(world))
}

impl From<&serial::Particle> for Particle {
    fn from(particle: &serial::Particle) -> Self {
        let padded = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
        Self { x: padded(particle.x), v: padded(particle.v) }
    }
}

impl From<&serial::Spring> for Spring {
    fn from(&serial::Spring { other, rest, k, d }: &serial::Spring) -> Self {
        Self { other, rest, k, d }
    }
}

impl World {
    fn of(serial: &Serial) -> Self {
        let ([x, y, z], radius) = serial.ball;
        Self {
            ball: [x, y, z, radius],
            wind: WIND.0.map(|force| force as f32),
            drag: WIND.1 as f32,
            floor_y: serial.floor,
            thickness: THICKNESS as f32,
            mass: NODE_MASS as f32,
            gravity: 9.81,
            h: serial.h,
            held: serial.held as u32,
            unused: [0; 2],
        }
    }
}
