//! Triangle meshes as colliders.

pub mod cache;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod hull;
pub mod poses;
pub mod surface;
pub mod tree;
pub mod triangle;
