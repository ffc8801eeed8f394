//! Records of patches as kernels see them.

use bytemuck::{Pod, Zeroable};

/// `Part` of grid_patches.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Part {
    pub first_row: i32,
    pub first_col: i32,
    pub end_row: i32,
    pub end_col: i32,
}

/// `Patch` of grid_patches.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Patch {
    pub grid: u32,
    pub all: Part,
    pub inner: Part,
}

/// Nodes that an invocation works on in a patch at most.
pub const OWN: usize = 4;

/// Bytes of a node in a patch.
pub const PATCH_NODE_BYTES: u32 = 28;
