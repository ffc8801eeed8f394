//! Rows of the kernels of all kinds of elements, and the row of torques.

use crate::diagnostics::parity::{compare, measured, sums, total};
use crate::elements::KINDS;
use crate::elements::element::{Kernel, Kind};
use crate::elements::gpu::KindTables;
use crate::elements::load::gpu_layout::Load;
use crate::elements::membrane;
use crate::elements::sets::Elements;
use crate::gpu::kernels::Name;
use crate::gpu::layout::{Four, GROUP};
use crate::parity::bench::{Bench, Given};
use crate::parity::fixture::words;
use crate::parity::row::{Row, Tolerance};
use crate::solvers::explicit::parity::{fixtures, kernel_of, scaled_loads};

const SUMMED: &str = "both add up in lanes and by halves; on hardware fused products add up over 642 nodes";

/// Rows of all kinds, of loads, and of the strain of fabric.
pub fn rows() -> Vec<Row> {
    let kernels = KINDS.into_iter().flat_map(|kind| kind.kernels());
    let of_kinds = kernels.map(|Kernel { entry, software, hardware, why }| Row {
        name: entry,
        entry,
        tolerance: Tolerance::new(software, hardware, why),
        check: of_kind,
    });
    of_kinds.chain(LOADS.iter().chain(membrane::parity::ROWS).copied()).collect()
}

const LOADS: &[Row] = &[Row {
    name: "scale_loads",
    entry: "scale_loads",
    tolerance: Tolerance::new(0.0, 64.0, SUMMED),
    check: scales,
}];

/// The kernel of a kind of elements that the row is for.
fn of_kind(bench: &mut Bench<'_>) -> Result<(), String> {
    let entry = bench.entry;
    let kind = KINDS.into_iter().find(|kind| kind.kernels().any(|kernel| kernel.entry == entry));
    let kind = kind.ok_or_else(|| format!("no kind of elements has the kernel `{entry}`"))?;
    match &kind.implicit {
        _ if entry == kind.kernels.forces.entry => forces(bench, kind),
        Some(implicit) if entry == implicit.directions.entry => directions(bench, kind),
        _ => energies(bench, kind),
    }
}

/// Directions of the modes of the elements of a kind over a step, on grids and meshes.
fn directions(bench: &mut Bench<'_>, kind: &Kind) -> Result<(), String> {
    let fixtures = fixtures(bench)?;
    let kernel = kernel_of(bench, Name::new(bench.entry), &fixtures[0])?;
    for mut fixture in fixtures {
        let Some(KindTables { set, .. }) = fixture.tables.elements.of(kind.name) else { continue };
        let count = set.range.len();
        let [position, velocity] = [&fixture.old.position, &fixture.old.velocity];
        let column = |axis: usize| -> Vec<f32> {
            (if axis < 3 { position } else { velocity }).iter().map(|four| four[axis % 3]).collect()
        };
        let (columns, h) = ([0, 1, 2, 3, 4, 5].map(column), fixture.substep().h);
        let set = fixture.cpu.feature::<Elements<f32>>().and_then(|all| all.of(kind.name));
        let wanted: Vec<Four> =
            set.map_or_else(Vec::new, |set| set.listed_directions(&columns.each_ref().map(Vec::as_slice), h));
        let (mut arrays, records) = (fixture.arrays(), fixture.records());
        arrays.insert("element_directions", vec![f32::NAN.to_bits(); 4 * wanted.len()]);
        let groups = count.div_ceil(GROUP);
        bench.run(&kernel, &Given { arrays: &arrays, records: &records, groups }, |written| {
            let found: Vec<Four> = written.take("element_directions");
            written.compare_fours("element_directions", &wanted, &found);
        })?;
    }
    Ok(())
}

/// Forces of the elements of a kind, on grids and meshes, with gusts.
fn forces(bench: &mut Bench<'_>, kind: &Kind) -> Result<(), String> {
    let fixtures = fixtures(bench)?;
    let kernel = kernel_of(bench, Name::new(bench.entry), &fixtures[0])?;
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
fn energies(bench: &mut Bench<'_>, kind: &Kind) -> Result<(), String> {
    let entry = bench.entry;
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
