//! The list of all comparisons, and of what they must cover.

use crate::contact::{nodes, triangles};
use crate::elements;
use crate::features::shaders;
use crate::gpu::kernels::Name;
use crate::parity::row::Row;
use crate::parity::{drawn, formulas};
use crate::solvers::{dual, explicit, implicit};
use crate::{attachments, diagnostics, volume};
use taffeta_gpu::wgpu::naga;

/// The rows that compare the kernels of all features with their twins.
pub fn rows() -> Vec<Row> {
    [
        explicit::parity::ROWS,
        drawn::ROWS,
        volume::parity::ROWS,
        dual::parity::ROWS,
        implicit::parity::ROWS,
        implicit::contacts_parity::ROWS,
        implicit::sewn_parity::ROWS,
        attachments::parity::ROWS,
        nodes::parity::ROWS,
        triangles::parity::ROWS,
        &elements::parity::rows(),
        diagnostics::parity::ROWS,
        formulas::ROWS,
    ]
    .concat()
}

/// The entry points that naga finds in the shaders.
pub fn entry_points() -> Result<Vec<String>, String> {
    let mut found = Vec::new();
    let shaders = shaders();
    for file in shaders.with_kernels() {
        let source = Name::new("").source_of(file, &shaders)?;
        let module = naga::front::wgsl::parse_str(&source).map_err(|error| error.emit_to_string(&source))?;
        found.extend(module.entry_points.into_iter().map(|point| point.name));
    }
    found.sort();
    Ok(found)
}
