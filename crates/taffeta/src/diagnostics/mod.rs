//! Diagnostics: sums and reports of frames, stability limits, and advice.

pub mod advice;
pub(crate) mod cpu;
pub(crate) mod digits;
#[cfg(feature = "gpu")]
pub(crate) mod gpu;
pub(crate) mod lanes;
pub mod normals;
#[cfg(feature = "gpu")]
pub(crate) mod parity;
mod report;
pub mod stability;
pub(crate) mod sums;
pub mod tension;
pub(crate) mod wind;

pub use report::{ElementEnergy, FrameReport, SolverReport, energy_kinds};
pub(crate) use sums::{FrameSums, PairSums, StateSums};
