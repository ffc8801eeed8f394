//! The backend on the GPU: memory and scheduling. Formulas are in the stages' own folders, as `.wgsl` beside the Rust.

mod attached;
mod backend;
mod boundary;
mod buffers;
mod collider_meshes;
mod cost;
mod drawn;
mod kernels;
mod layout;
#[cfg(test)]
mod layout_tests;
mod levelled;
mod linked;
mod mirror;
mod needed;
mod normals;
mod options;
mod paper;
pub mod parity;
mod patches;
mod primal;
mod recorder;
mod segment;
mod solver;
mod sums;
mod tables;
mod touching;

pub use backend::GpuBackend;
pub use boundary::Boundary;
pub use cost::GpuCost;
pub use drawn::{VertexTarget, View};
pub use options::{GpuKernels, GpuOptions};
pub use paper::ConstraintProduct;
