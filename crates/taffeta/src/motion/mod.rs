//! Prescribed motion: keyframes and poses, and the nodes that follow them.

pub mod cpu;
#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(feature = "gpu")]
pub mod gpu_layout;
pub mod held;
pub mod held_cpu;
#[cfg(feature = "gpu")]
pub mod held_gpu;
pub mod keyframes;
pub mod moving;
pub mod pins;
pub mod posed;
pub mod poses;
