//! Bending between two triangles that share an edge.

pub mod cpu;
pub mod hinge;
