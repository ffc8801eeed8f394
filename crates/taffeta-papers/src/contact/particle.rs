//! What the kernels of the ladder share, as `particle.wgsl` has it.

use super::serial::{self, Serial};
use super::sheet::{NODE_MASS, THICKNESS, WIND};
use taffeta::taffeta_gpu::bytemuck::{Pod, Zeroable};

/// Invocations of a workgroup.
pub const GROUP: u32 = 64;

pub const PARTICLE: &str = include_str!("particle.wgsl");
pub const CONSTANTS: &str = include_str!("constants.wgsl");

/// A particle as in `particle.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[bytemuck(crate = "taffeta::taffeta_gpu::bytemuck")]
#[repr(C)]
pub struct Particle {
    pub x: [f32; 4],
    pub v: [f32; 4],
}

/// A spring as in `particle.wgsl`.
#[derive(Clone, Copy, Pod, Zeroable)]
#[bytemuck(crate = "taffeta::taffeta_gpu::bytemuck")]
#[repr(C)]
pub struct Spring {
    other: u32,
    rest: f32,
    k: f32,
    d: f32,
}

/// The world as in `particle.wgsl`.
#[derive(Clone, Copy, Pod, Zeroable)]
#[bytemuck(crate = "taffeta::taffeta_gpu::bytemuck")]
#[repr(C)]
pub struct World {
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
    /// Of the sheet that `serial` has.
    pub fn of(serial: &Serial) -> Self {
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
