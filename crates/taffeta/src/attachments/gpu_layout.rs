//! Records of joints as kernels see them.

use bytemuck::{Pod, Zeroable};

/// `Joint` of attachments/stages.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Joint {
    pub point: [f32; 3],
    pub track: u32,
    pub a: u32,
    pub b: u32,
    pub start: f32,
    pub end: f32,
    pub compliance: f32,
    pub break_force: f32,
    pub closing: u32,
    pub grouped: u32,
}
