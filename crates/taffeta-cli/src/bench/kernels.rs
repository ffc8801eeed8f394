//! The kernels of a GPU that can be measured, by name.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use taffeta::GpuKernels;

/// All of them.
pub const ALL: [GpuKernels; 3] = [GpuKernels::Best, GpuKernels::Plain, GpuKernels::Tiled];

/// As the user calls them.
pub fn name(kernels: GpuKernels) -> &'static str {
    match kernels {
        GpuKernels::Best => "best",
        GpuKernels::Plain => "plain",
        GpuKernels::Tiled => "tiled",
    }
}

/// Takes a name on the command line.
pub fn parser() -> impl TypedValueParser<Value = GpuKernels> {
    PossibleValuesParser::new(ALL.map(name))
        .try_map(|text| ALL.into_iter().find(|&kernels| name(kernels) == text).ok_or("no kernels"))
}
