//! Triangle meshes as colliders.

pub mod cache;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod hull;
#[cfg(feature = "gpu")]
pub mod parity_scene;
pub mod surface;
pub mod tree;
pub mod triangle;
