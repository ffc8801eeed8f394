//! Springs as constraints.

use bytemuck::{Pod, Zeroable};

/// `Constraint` of solve.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Constraint {
    pub a: u32,
    pub b: u32,
    pub k: f32,
    pub damping: f32,
    pub rest_length: f32,
    pub is_active: u32,
}

/// `ConstraintGroup` of solve.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct ConstraintGroup {
    pub first: u32,
    pub count: u32,
    pub solve: u32,
    pub first_group: u32,
    pub groups: u32,
}

/// `NodeGroup` of solve.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct NodeGroup {
    pub first: u32,
    pub count: u32,
    pub solve: u32,
    pub first_group: u32,
    pub is_first: u32,
}

/// `Row` of solve.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Row {
    pub direction: [f32; 3],
    pub r: f32,
    pub w: f32,
    pub s: f32,
    pub p: f32,
    pub x: f32,
}

/// `ContactRecord` of solve.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ContactRecord {
    pub normal: [f32; 3],
    pub slides: f32,
    pub velocity: [f32; 3],
    pub collider: u32,
    pub is_constrained: u32,
    pub inside: f32,
    pub surface_speed: f32,
    pub padding: u32,
}

/// `CgState` of solve.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct CgState {
    pub passes: u32,
    pub is_done: u32,
    pub limit: f32,
    pub right: f32,
    pub gamma: f32,
    pub alpha: f32,
    pub beta: f32,
}

/// `Solve` of solve.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Solve {
    pub constraints: u32,
    pub active_constraints: u32,
    pub kept: CgState,
    pub next: CgState,
}

/// `SolveStatistics` of solve.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SolveStatistics {
    pub iterations: u32,
    pub capped: u32,
    pub active_fraction: f32,
    pub residual: f32,
}
