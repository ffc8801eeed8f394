//! Springs by nodes.

use bytemuck::{Pod, Zeroable};

/// `LevelGroup` of levels.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct LevelGroup {
    pub first: u32,
    pub count: u32,
    pub solve: u32,
    pub first_group: u32,
    pub groups: u32,
}

/// `SlotSpring` of levels.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SlotSpring {
    pub k: f32,
    pub damping: f32,
    pub rest_length: f32,
}

/// `Parents` of levels.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Parents {
    pub nodes: [u32; 4],
    pub weights: [f32; 4],
}

/// `CoarseEdge` of levels.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct CoarseEdge {
    pub slots: [u32; 2],
    pub first: u32,
    pub count: u32,
}

/// `WeightedIndex` of levels.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct WeightedIndex {
    pub at: u32,
    pub weight: f32,
}

/// `Symmetric` of implicit.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Symmetric {
    pub diagonal: [f32; 3],
    pub gap: u32,
    pub mixed: [f32; 3],
    pub padding: u32,
}

/// `Diagonal` of levels.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Diagonal {
    pub own: Symmetric,
    pub inverse: Symmetric,
}

/// `PcgState` of levels.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PcgState {
    pub passes: u32,
    pub is_done: u32,
    pub iterations: u32,
    pub whole: f32,
    pub error: f32,
    pub alpha: f32,
    pub beta: f32,
}

/// `NodeSolve` of levels.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct NodeSolve {
    pub before: u32,
    pub kept: PcgState,
    pub next: PcgState,
}

/// Sorts of vectors by node in `vectors` of levels.wgsl, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vector {
    Residual,
    Cycle,
    Cycled,
    Change,
    Direction,
    DirectionProduct,
    Product,
    Impulse,
    Total,
    SpringChange,
}

/// How many there are.
pub const VECTORS: usize = Vector::SpringChange as usize + 1;
