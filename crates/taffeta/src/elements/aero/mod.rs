//! Aerodynamic forces on triangles, and gusts.

pub mod aero;
pub mod build;
pub mod cpu;
#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(feature = "gpu")]
pub mod gpu_layout;
pub mod gust;

use crate::elements::element::{Kernel, Kernels, Kind};

/// The name of triangles in the air in reports and shaders.
pub const NAME: &str = "aero_triangles";

/// Triangles in the air. They have no energy, and set no step: a step takes no more of a velocity than there is.
pub const KIND: Kind = Kind {
    name: NAME,
    nodes: 3,
    forces: 1,
    cost: 0,
    record: ("AeroTriangle", &["lightness"]),
    kernels: Kernels {
        forces: Kernel {
            entry: "aero_forces",
            software: 0.0,
            hardware: 64.0,
            why: "sums, products, quotients and roots in the same order; on hardware a fused product turns the normals of small triangles",
        },
        energies: None,
    },
    #[cfg(feature = "gpu")]
    shaders: taffeta_gpu::shaders!("elements/aero", ["aero.wgsl", "gust.wgsl", "stages.wgsl"]),
    build: build::described,
    modes: None,
    implicit: None,
};
