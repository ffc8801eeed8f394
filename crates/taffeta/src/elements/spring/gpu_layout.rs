//! Records of springs as kernels see them.

use bytemuck::{Pod, Zeroable};

/// `Along` of grid.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Along {
    pub k: f32,
    pub damping: f32,
    pub rest_length: f32,
    pub there: u32,
}

/// `Grid` of grid.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Grid {
    pub first: u32,
    pub rows: i32,
    pub cols: i32,
    pub along: [Along; 6],
}

/// `Tile` of grid_stages.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Tile {
    pub grid: u32,
    pub row: i32,
    pub col: i32,
}

/// `ResidentMesh` of mesh_patches.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ResidentMesh {
    pub first: u32,
    pub count: u32,
}

/// `Run` of mesh.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Run {
    pub start: u32,
    pub count: u32,
    pub k: f32,
    pub damping: f32,
}

/// In [`Run::count`]: the slice belongs to a grid.
pub const NOT_A_MESH: u32 = u32::MAX;

/// In [`Run::count`]: the entries are a ring of a body that keeps its volume.
pub const IS_RING: u32 = 1 << 31;

/// `Entry` of mesh.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Entry {
    pub neighbour: u32,
    pub rest_length: f32,
}

/// Rows and columns of a tile; together [`GROUP`].
pub const TILE: [usize; 2] = [8, 32];
