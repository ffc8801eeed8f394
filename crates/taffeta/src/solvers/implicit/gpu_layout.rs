//! Springs by nodes.

use crate::gpu::layout::Solving;
use crate::solvers::implicit::scheme::Scheme;
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
    pub steps: u32,
    pub before: u32,
    pub is_met: u32,
    pub first: u32,
    pub motion: f32,
    pub kept: PcgState,
    pub next: PcgState,
}

/// `Weight` of sewn.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Weight {
    pub x: [f32; 3],
    pub gap: u32,
    pub y: [f32; 3],
    pub padding: u32,
    pub z: [f32; 3],
    pub end: u32,
}

/// Sorts of sums by group of nodes in `product_sums`.
pub const SUMS: usize = 3;

/// Words of `written_steps` of levels.wgsl, and two of them.
pub const STEP_WORDS: usize = 4;
pub const MOST_OPEN_AT: usize = 2;
pub const IS_LEFT: usize = 3;

/// When workgroups run that are counted, as in levels.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// In iterations.
    Iterated,
    /// Where a further Newton step begins.
    Begun,
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
    Start,
    Free,
    Rate,
    Given,
    Taken,
}

/// How many there are.
pub const VECTORS: usize = Vector::Taken as usize + 1;

impl Solving {
    /// With the numbers of a sub-step of length `h` [s].
    pub fn stepping(self, h: f32, scheme: Option<&Scheme<f32>>) -> Self {
        let Some(scheme) = scheme else {
            return Self { inner: h, mass: 1.0, outer: 1.0, whole: 1.0, ..self };
        };
        Self {
            inner: scheme.h,
            mass: scheme.mass,
            outer: scheme.outer,
            place_of_velocity: scheme.place[0],
            place_of_rate: scheme.place[1],
            velocity_of_rate: scheme.velocity,
            rate_of_change: scheme.rate[0],
            rate_kept: scheme.rate[1],
            whole: scheme.whole,
            is_second: 1,
            ..self
        }
    }
}
