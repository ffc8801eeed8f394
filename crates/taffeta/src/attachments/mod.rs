//! Seams, breakable pins, and tethers.

pub mod attach;
pub mod build;
pub mod constraints;
pub mod cpu;
pub mod cpu_tethers;
#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(feature = "gpu")]
pub mod gpu_layout;
pub mod joints;
#[cfg(feature = "gpu")]
pub mod parity;
pub mod pins;
pub mod tethers;
