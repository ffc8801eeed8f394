//! How a fabric resists stretch and shear in its plane.

mod build;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod membrane;
#[cfg(feature = "gpu")]
pub mod parity;
pub mod strain;

use crate::elements::element::{Implicit, Kernel, Kernels, Kind};
use membrane::Membrane;

/// The name of membranes in reports and shaders.
pub const NAME: &str = "membranes";

const FUSED: &str = "sums, products, quotients and roots in the same order, but that lavapipe's compiler takes some of a compressed \
                     triangle in another; on hardware a fused product turns stresses of triangles that are hardly strained";

/// Membranes.
pub const KIND: Kind = Kind {
    name: NAME,
    nodes: 3,
    forces: 3,
    cost: 4,
    record: (
        "Membrane",
        &["inverse_a", "inverse_b", "inverse_c", "inverse_d", "c11", "c12", "c22", "g", "damping", "limit"],
    ),
    kernels: Kernels {
        forces: Kernel { entry: "pull_membranes", software: 1.0, hardware: 8192.0, why: FUSED },
        energies: Some(Kernel {
            entry: "measure_membranes",
            software: 64.0,
            hardware: 1024.0,
            why: "as a tree in 32 bits, not in order in 64; on hardware with fused products",
        }),
    },
    #[cfg(feature = "gpu")]
    shaders: taffeta_gpu::shaders!("elements/membrane", ["membrane.wgsl", "stages.wgsl"]),
    build: build::membranes,
    modes: Some(Kind::visit::<Membrane, 3, 10>),
    implicit: Some(Implicit {
        modes: 3,
        is_tense: true,
        directions: Kernel {
            entry: "membrane_directions",
            software: 4.0,
            hardware: 8192.0,
            why: "lavapipe's compiler folds the zeros and ones of a mode's tensor into sums; hardware fuses products",
        },
    }),
};
