//! Contact of nodes of a thickness with each other.

pub mod build;
pub mod cells;
pub mod cpu;
#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(feature = "gpu")]
pub mod gpu_layout;
pub mod pair;
#[cfg(feature = "gpu")]
pub mod parity;
pub mod self_contact;
