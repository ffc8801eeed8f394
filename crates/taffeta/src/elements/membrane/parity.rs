//! The row of the strain of fabric.

use crate::diagnostics::parity::{compare, measured, sums};
use crate::elements::membrane::{NAME, gpu::STRAINS};
use crate::gpu::layout::GROUP;
use crate::parity::bench::Bench;
use crate::parity::row::{Row, Tolerance};
use crate::solvers::explicit::parity::fixtures;

const FUSED: Tolerance = Tolerance::new(
    0.0,
    1024.0,
    "sums, products and a quotient in the same order; the largest of all is the same in any; hardware fuses products",
);

/// One row.
pub const ROWS: &[Row] =
    &[Row { name: "measure_strains", entry: "measure_strains", tolerance: FUSED, check: strains }];

fn strains(bench: &mut Bench<'_>) -> Result<(), String> {
    for mut fixture in fixtures(bench)? {
        let Some(tables) = fixture.tables.elements.of(NAME) else { continue };
        let groups = [1, 3, tables.set.range.len().div_ceil(GROUP)];
        let wanted = measured(&mut fixture)?.strain.ok_or("fabric without a strain")?.0;
        sums(bench, &fixture, ("measure_strains", "strains", STRAINS), &groups, |written, found| {
            for (at, wanted) in wanted.into_iter().enumerate() {
                let rows = found.iter().skip(at).step_by(STRAINS);
                // A NaN is larger than all.
                let most = rows.fold(f32::NEG_INFINITY, |most, &one| if one <= most { most } else { one });
                compare(written, "strain", wanted, most, wanted.abs());
            }
        })?;
    }
    Ok(())
}
