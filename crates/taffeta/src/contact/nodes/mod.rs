//! Contact of nodes of a thickness with each other.

pub mod build;
pub mod cells;
pub mod cpu;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod pair;
#[cfg(feature = "gpu")]
pub mod parity;
pub mod touching;
