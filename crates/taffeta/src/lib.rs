//! The engine: a scene in, positions out. No window, no clock, no file system.

mod assembly;
mod collision;
mod cpu;
pub mod diagnostics;
mod forces;
mod integrate;
mod real;
pub mod scene;
mod simulation;
mod step;
pub mod topology;

pub use simulation::{BodyInfo, Diverged, Options, Precision, Simulation, Snapshot};

/// The vector instructions that the CPU backend uses on this machine.
pub fn simd_level() -> String {
    cpu::SimdLevel::detect().to_string()
}
