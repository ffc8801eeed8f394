//! Contact of nodes with colliders.

pub mod cpu;
pub mod faces;
#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(feature = "gpu")]
pub mod gpu_layout;
pub mod lift;
pub mod met;
pub mod moving;
pub mod predicted_contact;
pub mod response;
pub mod rigid;
pub mod run;
pub mod shape;
pub mod start;
