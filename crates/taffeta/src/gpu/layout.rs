//! Records as the kernels see them: the same fields in the same order, at the offsets that naga reads from the WGSL
//! (`layout_tests` compares them).

use bytemuck::{Pod, Zeroable};

/// Position or velocity in the first three; inverse mass [1/kg] or mass [kg] in the last.
pub type Four = [f32; 4];

/// `Substep` of substep.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Substep {
    pub gravity: [f32; 3],
    pub h: f32,
    pub wind: [f32; 3],
    pub drag: f32,
    pub first_collider: u32,
    pub colliders: u32,
    pub first_motion: u32,
    pub first_scale: u32,
    pub frame_fraction: f32,
    pub frame_rate: f32,
    pub input_forces: u32,
    pub pins: u32,
    pub solving: Solving,
    pub left: u32,
    pub first_goal: u32,
    pub max_separation: f32,
    pub own: u32,
    pub air: Air,
    pub first_corner: u32,
    pub corner_parts: u32,
    pub longest_push: f32,
    pub led_out: u32,
    pub collider_ranges: u32,
    pub longest_step: f32,
    pub pins_may_lag: u32,
    pub padding: u32,
}

/// `Solving` of substep.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Solving {
    pub activation: f32,
    pub release: f32,
    pub aim: f32,
    pub epsilon: f32,
    pub form: u32,
    pub tolerance_squared: f32,
    pub most_iterations: u32,
    pub is_adaptive: u32,
    pub is_warm: u32,
    pub inner: f32,
    pub mass: f32,
    pub outer: f32,
    pub place_of_velocity: f32,
    pub place_of_rate: f32,
    pub velocity_of_rate: f32,
    pub rate_of_change: f32,
    pub rate_kept: f32,
    pub whole: f32,
    pub is_second: u32,
    pub is_automatic: u32,
}

/// Records of sub-steps that a dispatch sees: its own and those after it.
pub const SUBSTEPS_SEEN: usize = 64;

/// No node, or no surface.
pub const NONE: u32 = u32::MAX;

/// Invocations of a workgroup.
pub const GROUP: usize = 256;

/// `Air` of aero.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Air {
    pub velocity: [f32; 3],
    pub density: f32,
    pub exposure: f32,
    pub drag: f32,
    pub lift: f32,
    pub gap: u32,
    pub gusts: Gusts,
}

/// `Gusts` of gust.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Gusts {
    pub offset: [f32; 3],
    pub cells_a_metre: f32,
    pub keys: [u32; 2],
    pub weights: [f32; 2],
}
