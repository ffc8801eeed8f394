//! The kernels of a GPU that can be measured, by name.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use taffeta::{ConstraintProduct, GpuKernels};

/// All of them, ours first.
pub const ALL: [GpuKernels; 5] = [
    GpuKernels::Best,
    GpuKernels::Plain,
    GpuKernels::Tiled,
    GpuKernels::NodeCentric,
    GpuKernels::SpringCentric,
];

/// Those of `bench ice` alone: the solver of 2021 with its product and others.
const OF_ICE: [GpuKernels; 4] = [
    GpuKernels::Constraints(ConstraintProduct::Printed),
    GpuKernels::Constraints(ConstraintProduct::Csr),
    GpuKernels::Constraints(ConstraintProduct::Ell),
    GpuKernels::Constraints(ConstraintProduct::MatrixFree),
];
/// What `bench ice` calls ours.
const ENGINE: &str = "engine";

/// As the user calls them.
pub fn name(kernels: GpuKernels) -> &'static str {
    match kernels {
        GpuKernels::Best => "best",
        GpuKernels::Plain => "plain",
        GpuKernels::Tiled => "tiled",
        GpuKernels::NodeCentric => "node-centric",
        GpuKernels::SpringCentric => "spring-centric",
        GpuKernels::Constraints(ConstraintProduct::Printed) => "printed",
        GpuKernels::Constraints(ConstraintProduct::Csr) => "csr",
        GpuKernels::Constraints(ConstraintProduct::Ell) => "ell",
        GpuKernels::Constraints(ConstraintProduct::MatrixFree) => "matrix-free",
    }
}

/// As `bench ice` calls them.
pub fn name_for_ice(kernels: GpuKernels) -> &'static str {
    if kernels == GpuKernels::Best { ENGINE } else { name(kernels) }
}

/// Takes a name on the command line.
pub fn parser() -> impl TypedValueParser<Value = GpuKernels> {
    let all = || ALL.into_iter().chain(OF_ICE);
    PossibleValuesParser::new(all().map(name).chain([ENGINE])).try_map(move |text| match text.as_str() {
        ENGINE => Ok(GpuKernels::Best),
        text => all().find(|&kernels| name(kernels) == text).ok_or("no kernels"),
    })
}
