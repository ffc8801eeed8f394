//! Records of motions as kernels see them.

use crate::gpu::layout::Four;
use crate::motion::pins;
use bytemuck::{Pod, Zeroable};

/// `Motion` of pins.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Motion {
    pub x: Four,
    pub y: Four,
    pub z: Four,
    pub rate_x: Four,
    pub rate_y: Four,
    pub rate_z: Four,
}

/// `Pin` of pins.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Pin {
    pub start: [f32; 3],
    pub node: u32,
    pub goal: [f32; 3],
    pub track: u32,
}

/// In [`Pin::track`]: moved by the program.
pub const MOVED_BY_USER: u32 = u32::MAX;

impl From<&pins::Motion<f32>> for Motion {
    fn from(motion: &pins::Motion<f32>) -> Self {
        let ([x, y, z], [rate_x, rate_y, rate_z]) = (motion.place, motion.rate);
        Self { x, y, z, rate_x, rate_y, rate_z }
    }
}
