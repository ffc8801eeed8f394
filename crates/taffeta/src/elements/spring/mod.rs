//! Springs between two nodes, of grids and of meshes.

pub mod cpu;
pub mod cpu_gathers;
pub mod cpu_grid;
pub mod cpu_mesh;
pub mod cpu_narrow;
#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(feature = "gpu")]
pub mod gpu_layout;
pub mod listed;
pub mod spring;
pub mod stencil;
