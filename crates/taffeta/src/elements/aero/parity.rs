//! The row of triangles in the air.

use crate::elements::aero::KIND;
use crate::elements::parity::forces;
use crate::gpu::parity::{Row, Tolerance};

/// One row for each kernel.
pub const ROWS: &[Row] = &[Row {
    name: "blow_on_panels",
    entry: "blow_on_panels",
    tolerance: Tolerance::new(
        0.0,
        64.0,
        "sums, products, quotients and roots in the same order; on hardware a fused product turns the normals of small triangles",
    ),
    check: |bench| forces(bench, &KIND),
}];
