//! Rows of hinges.

use crate::elements::hinge::KIND;
use crate::elements::parity::{energies, forces};
use crate::gpu::parity::{Row, Tolerance};

/// One row for each kernel.
pub const ROWS: &[Row] = &[
    Row {
        name: "bend_hinges",
        entry: "bend_hinges",
        tolerance: Tolerance::new(
            0.0,
            8192.0,
            "sums, products, quotients and roots in the same order; on hardware a fused product turns the normals of slivers",
        ),
        check: |bench| forces(bench, &KIND),
    },
    Row {
        name: "measure_hinges",
        entry: "measure_hinges",
        tolerance: Tolerance::new(
            16.0,
            1024.0,
            "as a tree in 32 bits, not in order in 64; on hardware a fused product turns the normals of slivers",
        ),
        check: |bench| energies(bench, &KIND, "measure_hinges"),
    },
];
