//! Records of loads as kernels see them.

use bytemuck::{Pod, Zeroable};

/// `Load` of load/stages.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Load {
    pub vector: [f32; 3],
    pub kind: u32,
    pub about: [f32; 3],
    pub torque: f32,
    pub first: u32,
    pub count: u32,
    pub factor: f32,
    pub padding: u32,
}

/// In [`Load::kind`].
pub const FORCE: u32 = 0;

/// In [`Load::kind`].
pub const TORQUE: u32 = 1;

/// Marks a load among a node's elements.
pub const IS_LOAD: u32 = 1 << 31;
