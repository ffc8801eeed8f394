//! Self-collision: contact between nodes with a thickness.

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
#[cfg(feature = "gpu")]
pub mod parity_scene;
pub mod self_contact;
