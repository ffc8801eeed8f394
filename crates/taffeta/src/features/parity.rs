//! The rows that compare kernels with their twins, of all features.

use crate::gpu::parity::{Row, drawn, formulas};
use crate::solvers::{dual, explicit, implicit};
use crate::{attachments, contact, diagnostics, elements, volume};

/// All rows.
pub fn rows() -> Vec<Row> {
    [
        explicit::parity::ROWS,
        drawn::ROWS,
        volume::parity::ROWS,
        dual::parity::ROWS,
        implicit::parity::ROWS,
        attachments::parity::ROWS,
        contact::nodes::parity::ROWS,
        &elements::parity::rows(),
        diagnostics::parity::ROWS,
        formulas::ROWS,
    ]
    .concat()
}
