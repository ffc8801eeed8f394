//! The backend on the GPU: memory and scheduling. Formulas are in the stages' own folders, as `.wgsl` beside the Rust.

pub mod backend;
pub mod backup;
pub mod bodies;
pub mod boundary;
pub mod drawn;
pub mod feature;
pub mod kernels;
pub mod layout;
#[cfg(test)]
pub mod layout_tests;
pub mod mirror;
pub mod needed;
pub mod normals;
pub mod options;
pub mod partition;
pub mod schedule;
pub mod sums;

pub use options::{GpuKernels, GpuOptions};
