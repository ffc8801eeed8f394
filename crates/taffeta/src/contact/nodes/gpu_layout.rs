//! Records of self-contact as kernels see them.

use bytemuck::{Pod, Zeroable};

/// `ContactMaterial` of pair.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ContactMaterial {
    pub thickness: f32,
    pub friction: f32,
    pub restitution: f32,
}

/// `Surface` of broad_phase.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Surface {
    pub first: u32,
    pub count: u32,
    pub cols: u32,
    pub high: u32,
    pub wide: u32,
    pub exclusions: u32,
    pub material: ContactMaterial,
    pub cells_a_metre: f32,
    pub memberships: u32,
    pub met_layers: u32,
}

/// Cells of pairs from the origin to the last layer.
pub const FARTHEST: f32 = 65_536.0;
