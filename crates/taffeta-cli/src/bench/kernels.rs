//! The kernels of a GPU that can be measured, by name.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use taffeta::GpuKernels;

/// All of them, ours first.
pub const ALL: [GpuKernels; 5] = [
    GpuKernels::Best,
    GpuKernels::Plain,
    GpuKernels::Tiled,
    GpuKernels::NodeCentric,
    GpuKernels::SpringCentric,
];

/// As the user calls them.
pub fn name(kernels: GpuKernels) -> &'static str {
    match kernels {
        GpuKernels::Best => "best",
        GpuKernels::Plain => "plain",
        GpuKernels::Tiled => "tiled",
        GpuKernels::NodeCentric => "node-centric",
        GpuKernels::SpringCentric => "spring-centric",
    }
}

/// Takes a name on the command line.
pub fn parser() -> impl TypedValueParser<Value = GpuKernels> {
    PossibleValuesParser::new(ALL.map(name))
        .try_map(|text| ALL.into_iter().find(|&kernels| name(kernels) == text).ok_or("no kernels"))
}
