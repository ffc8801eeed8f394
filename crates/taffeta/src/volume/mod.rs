//! Closed meshes that keep their volume, or are under a pressure.

pub mod build;
pub mod constraint;
pub mod cpu;
pub mod cpu_rings;
pub mod cpu_sums;
#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(feature = "gpu")]
pub mod gpu_layout;
#[cfg(feature = "gpu")]
pub mod parity;
#[cfg(feature = "gpu")]
pub mod parity_scene;
#[cfg(feature = "paper-forms")]
pub mod printed;
pub mod rings;
pub mod volume;
