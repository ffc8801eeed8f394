//! Prescribed motion: keyframes, and the nodes that follow them.

pub mod cpu;
#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(feature = "gpu")]
pub mod gpu_layout;
pub mod keyframes;
pub mod moving;
pub mod pins;
