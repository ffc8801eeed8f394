//! Records of volumes as kernels see them.

use bytemuck::{Pod, Zeroable};

/// `VolumeGroup` of volume.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct VolumeGroup {
    pub first: u32,
    pub count: u32,
    pub gradients: u32,
    pub origin: u32,
    pub first_group: u32,
    pub groups: u32,
    pub goal: u32,
    pub form: u32,
    pub flags: u32,
}

/// In [`VolumeGroup::flags`]: nodes have weights.
pub const WEIGHTED: u32 = 1;

/// In [`VolumeGroup::flags`]: nodes are moved after contact.
pub const RESTORED: u32 = 2;

/// Vectors of each group in `volume_sums` of volume.wgsl.
pub const VOLUME_PARTS: usize = 7;

/// `Chunk` of measure_volumes.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Chunk {
    pub origin: u32,
    pub first: u32,
    pub count: u32,
}
