//! How a fabric resists bending.

mod balance;
pub mod bending;
pub mod build;
mod curvature;
mod system;

use crate::elements::element::{Implicit, Kernel, Kernels, Kind};
use bending::ShapeOperator;

/// The name of bending elements in reports and shaders.
pub const NAME: &str = "bends";

const FUSED: &str = "sums, products, quotients and roots in the same order, but that lavapipe's compiler takes common factors out of \
                     sums; on hardware a fused product turns the normals of slivers";

/// Shape operators, one for each triangle.
pub const KIND: Kind = Kind {
    name: NAME,
    nodes: 6,
    forces: 6,
    cost: 16,
    record: (
        "Bend",
        &[
            "rest_a",
            "rest_b",
            "rest_c",
            "steepest_a",
            "steepest_b",
            "steepest_c",
            "l11",
            "l21",
            "l31",
            "l22",
            "l32",
            "l33",
            "damping",
        ],
    ),
    kernels: Kernels {
        forces: Kernel { entry: "bend_triangles", software: 4.0, hardware: 8192.0, why: FUSED },
        energies: Some(Kernel {
            entry: "measure_bends",
            software: 64.0,
            hardware: 1024.0,
            why: "as a tree in 32 bits, not in order in 64; on hardware a fused product turns the normals of slivers",
        }),
    },
    #[cfg(feature = "gpu")]
    shaders: taffeta_gpu::shaders!("elements/bending", ["bending.wgsl", "stages.wgsl"]),
    build: build::bends,
    modes: Some(Kind::visit::<ShapeOperator, 6, 13>),
    implicit: Some(Implicit {
        modes: 3,
        is_tense: false,
        directions: Kernel { entry: "bend_directions", software: 4.0, hardware: 8192.0, why: FUSED },
    }),
};
