//! Symplectic Euler.

pub mod cpu;
pub mod euler;
#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(feature = "gpu")]
pub mod gpu_layout;
#[cfg(feature = "gpu")]
pub mod parity;
#[cfg(feature = "gpu")]
pub mod patches;
