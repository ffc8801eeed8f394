//! The engine: a scene in, positions out. No window, no clock, no file system.
//!
//! Build a [`scene::Scene`] from [`scene::Body`] and [`scene::Collider`], make a [`Simulation`] of it, and call
//! [`Simulation::step`] once a frame. `examples/first_cloth.rs` does that in forty lines. Scenes and meshes from files
//! are read by the crate `taffeta-io`. Units are SI, y is up; a `[m]` in these pages is a unit.

mod attachments;
mod backend;
mod build;
mod contact;
mod cpu;
pub mod diagnostics;
mod elements;
mod features;
#[cfg(feature = "gpu")]
mod gpu;
mod motion;
mod plan;
mod real;
pub mod scene;
mod simulation;
mod solvers;
mod step;
pub mod topology;
mod volume;

pub use elements::spring::listed::springs_of;
pub use elements::spring::lists as springs;
#[cfg(feature = "gpu")]
#[doc(hidden)]
pub use gpu::parity;
#[cfg(feature = "gpu")]
pub use gpu::{ConstraintProduct, GpuCost, GpuKernels, GpuOptions, VertexTarget, View};
pub use simulation::{
    BodyInfo, ColliderInfo, Diverged, Options, Pose, Precision, Simulation, Snapshot, StepError,
};
pub use step::Stage;
#[cfg(feature = "gpu")]
pub use taffeta_gpu;

/// The vector instructions that the CPU backend uses on this machine.
pub fn simd_level() -> String {
    cpu::SimdLevel::detect().to_string()
}
