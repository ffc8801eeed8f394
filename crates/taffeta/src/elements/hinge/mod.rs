//! Bending between two triangles that share an edge.

mod build;
pub mod hinge;

use crate::elements::element::{Implicit, Kernel, Kernels, Kind};
use hinge::Bending;

/// The name of hinges in reports and shaders.
pub const NAME: &str = "hinges";

/// Hinges.
pub const KIND: Kind = Kind {
    name: NAME,
    nodes: 4,
    forces: 4,
    cost: 8,
    record: ("Hinge", &["rest_angle", "rest_steepness", "k", "damping"]),
    kernels: Kernels {
        forces: Kernel {
            entry: "bend_hinges",
            software: 0.0,
            hardware: 8192.0,
            why: "sums, products, quotients and roots in the same order; on hardware a fused product turns the normals of slivers",
        },
        energies: Some(Kernel {
            entry: "measure_hinges",
            software: 16.0,
            hardware: 1024.0,
            why: "as a tree in 32 bits, not in order in 64; on hardware a fused product turns the normals of slivers",
        }),
    },
    #[cfg(feature = "gpu")]
    shaders: taffeta_gpu::shaders!("elements/hinge", ["hinge.wgsl", "stages.wgsl"]),
    build: build::hinges,
    modes: Some(Kind::visit::<Bending, 4, 4>),
    implicit: Some(Implicit {
        modes: 1,
        is_tense: false,
        directions: Kernel {
            entry: "hinge_directions",
            software: 0.0,
            hardware: 8192.0,
            why: "sums, products, quotients and roots in the same order; on hardware a fused product turns the normals of slivers",
        },
    }),
};
