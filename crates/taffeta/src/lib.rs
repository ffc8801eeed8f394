//! The engine: a scene in, positions out. No window, no clock, no file system.
//!
//! Build a [`scene::Scene`] from [`scene::Body`] and [`scene::Collider`], make a [`Simulation`] of it, and call
//! [`Simulation::step`] once a frame. `examples/first_cloth.rs` does that in forty lines. Scenes and meshes from files
//! are read by the crate `taffeta-io`. Units are SI, y is up; a `[m]` in these pages is a unit.

mod advice;
mod assembly;
mod attachments;
mod backend;
mod contact;
mod cpu;
pub mod diagnostics;
mod elements;
mod extensions;
mod features;
#[cfg(feature = "gpu")]
mod gpu;
mod motion;
#[cfg(feature = "gpu")]
#[doc(hidden)]
pub mod parity;
mod plan;
mod real;
mod report;
pub mod scene;
mod simulation;
mod solvers;
mod step;
pub mod topology;
mod volume;

pub use advice::{Advice, Refusal, Warning};
pub use assembly::springs;
#[cfg(feature = "gpu")]
pub use backend::{VertexTarget, View};
pub use cpu::team::Pool;
pub use elements::spring::listed::springs_of;
pub use glam;
#[cfg(feature = "gpu")]
#[doc(hidden)]
pub use gpu::GpuKernels;
#[cfg(feature = "gpu")]
pub use gpu::GpuOptions;
pub use rayon;
#[cfg(feature = "gpu")]
pub use simulation::GpuCost;
pub use simulation::{
    BodyHandle, BodyInfo, BuildError, Changes, ColliderHandle, ColliderInfo, Diverged, Frozen, InputError,
    Intersections, OnDivergence, Options, PinHandle, Pose, Precision, Simulation, Snapshot, StepError,
};
pub use step::Stage;
#[cfg(feature = "gpu")]
pub use taffeta_gpu;

/// What kernels of other crates are made with. It changes with the engine.
#[cfg(all(feature = "gpu", feature = "extend"))]
#[doc(hidden)]
pub mod extension {
    pub use crate::assembly::Assembly;
    pub use crate::assembly::body::{BodyAssembly, BodySprings};
    pub use crate::elements::load::gpu::{GIVEN, Loads};
    pub use crate::elements::spring::stencil::GRID_STEPS;
    pub use crate::features::{choices, shaders};
    pub use crate::gpu::bodies::Bodies;
    pub use crate::gpu::feature::{Command, Dispatch, Feature, Features, Groups};
    pub use crate::gpu::kernels::{Kernels, Name, Overrides};
    pub use crate::gpu::options::ParticleKernels;
    pub use crate::gpu::schedule::Fused;
    pub use crate::report::sums::FrameSums;
    pub use crate::step::Op;
}

/// The vector instructions that the CPU backend uses on this machine.
///
/// ```
/// assert!(["base", "sse2", "avx2", "avx512", "simd128"].contains(&taffeta::simd_level().as_str()));
/// ```
pub fn simd_level() -> String {
    cpu::SimdLevel::detect().to_string()
}
