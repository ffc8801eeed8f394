//! What rows of all kinds of elements are made by, and the row of torques.

use crate::diagnostics::parity::{compare, measured, sums, total};
use crate::elements::element::Kind;
use crate::elements::gpu::KindTables;
use crate::elements::load::gpu_layout::Load;
use crate::elements::{aero, hinge};
use crate::gpu::kernels::Name;
use crate::gpu::layout::GROUP;
use crate::gpu::parity::bench::{Bench, Given};
use crate::gpu::parity::fixture::words;
use crate::gpu::parity::{Row, Tolerance};
use crate::solvers::explicit::parity::{fixtures, kernel_of, scaled_loads};

const SUMMED: &str = "both add up in lanes and by halves; on hardware fused products add up over 642 nodes";

/// Rows of all kinds, and of loads.
pub fn rows() -> Vec<Row> {
    [hinge::parity::ROWS, aero::parity::ROWS, LOADS].concat()
}

const LOADS: &[Row] = &[Row {
    name: "scale_loads",
    entry: "scale_loads",
    tolerance: Tolerance::new(0.0, 64.0, SUMMED),
    check: scales,
}];

/// Forces of the elements of a kind, on grids and meshes, with gusts.
pub fn forces(bench: &mut Bench<'_>, kind: &Kind) -> Result<(), String> {
    let fixtures = fixtures(bench)?;
    let kernel = kernel_of(bench, Name::new(kind.kernels.forces), &fixtures[0])?;
    for mut fixture in fixtures {
        fixture.on_cpu(&[]);
        let Some(KindTables { set, .. }) = fixture.tables.elements.of(kind.name) else { continue };
        let (wanted, groups) = (set.found_on_cpu(&mut fixture.cpu), set.range.len().div_ceil(GROUP));
        let (mut arrays, records) = (fixture.arrays(), fixture.records());
        arrays.insert("element_forces", vec![f32::NAN.to_bits(); 4 * wanted.len()]);
        bench.run(&kernel, &Given { arrays: &arrays, records: &records, groups }, |written| {
            written.fours("element_forces", &wanted);
        })?;
    }
    Ok(())
}

/// Energies of the elements of a kind.
pub fn energies(bench: &mut Bench<'_>, kind: &Kind, entry: &'static str) -> Result<(), String> {
    for mut fixture in fixtures(bench)? {
        let Some(KindTables { set, .. }) = fixture.tables.elements.of(kind.name) else { continue };
        let groups = [1, 3, set.range.len().div_ceil(GROUP)];
        let energies = measured(&mut fixture)?.elements;
        let wanted = energies.iter().find(|one| one.kind == kind.name).map_or(f64::NAN, |one| one.energy);
        sums(bench, &fixture, (entry, "element_energies", 1), &groups, |written, found| {
            compare(written, "energy", wanted, total(found, 1, 0), wanted);
        })?;
    }
    Ok(())
}

fn scales(bench: &mut Bench<'_>) -> Result<(), String> {
    let fixtures = fixtures(bench)?;
    let kernel = kernel_of(bench, Name::new("scale_loads"), &fixtures[0])?;
    for mut fixture in fixtures {
        fixture.on_cpu(&[]);
        let torques = fixture.torques();
        let wanted = scaled_loads(&fixture, &torques);
        let mut arrays = fixture.arrays();
        let poisoned: Vec<Load> = wanted.iter().map(|load| Load { factor: f32::NAN, ..*load }).collect();
        arrays.insert("loads", words(&poisoned));
        let (records, groups) = (fixture.records(), wanted.len());
        bench.run(&kernel, &Given { arrays: &arrays, records: &records, groups }, |written| {
            let found: Vec<Load> = written.take("loads");
            for (index, (wanted, found)) in wanted.iter().zip(&found).enumerate() {
                let name = format!("loads[{index}].factor");
                written.outcome().compare(&name, &[wanted.factor], &[found.factor]);
            }
            let rest: Vec<Load> = found.iter().map(|load| Load { factor: f32::NAN, ..*load }).collect();
            let numbers = |loads: &[Load]| words(loads).into_iter().map(f32::from_bits).collect::<Vec<_>>();
            written.outcome().copied("loads", &numbers(&poisoned), &numbers(&rest));
        })?;
    }
    Ok(())
}
