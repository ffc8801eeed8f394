//! Forces on single nodes: wind, drag, point loads, torques.

pub mod build;
pub mod cpu;
#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(feature = "gpu")]
pub mod gpu_layout;
pub mod load;
