//! Diagnostics: measurements, stability limits, and advice; the report of a frame.

pub mod advice;
mod bending;
pub(crate) mod cpu;
pub mod culprit;
pub(crate) mod digits;
#[cfg(feature = "gpu")]
pub(crate) mod gpu;
pub mod normals;
#[cfg(feature = "gpu")]
pub(crate) mod parity;
pub mod stability;
pub mod tension;
pub(crate) mod wind;

pub use crate::elements::energy_kinds;
pub use crate::report::{ElementEnergy, FabricStrain, FrameReport, PinReaction, SolverReport, Squeezed};
pub use bending::bending_factors;
