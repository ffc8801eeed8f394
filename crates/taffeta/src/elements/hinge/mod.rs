//! Bending between two triangles that share an edge.

mod build;
pub mod hinge;
#[cfg(feature = "gpu")]
pub mod parity;

use crate::elements::element::{Kernels, Kind};
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
    kernels: Kernels { forces: "bend_hinges", energies: Some("measure_hinges") },
    #[cfg(feature = "gpu")]
    shaders: taffeta_gpu::shaders!("elements/hinge", ["hinge.wgsl", "stages.wgsl"]),
    build: build::hinges,
    modes: Some(Kind::visit::<Bending, 4, 4>),
};
