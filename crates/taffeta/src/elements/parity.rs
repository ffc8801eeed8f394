//! Rows of the elements that several nodes share: hinges, panels and torques.

use crate::gpu::kernels::Name;
use crate::gpu::layout::Load;
use crate::gpu::parity::bench::{Bench, Given};
use crate::gpu::parity::fixture::words;
use crate::gpu::parity::{Row, Tolerance};
use crate::solvers::explicit::parity::{fixtures, kernel_of, scaled_loads};

const FOLDED: &str = "sums, products, quotients and roots in the same order; on hardware a fused product turns the \
                      normals of slivers";
const SUMMED: &str = "both add up in lanes and by halves; on hardware fused products add up over 642 nodes";

const BLOWN: &str = "sums, products, quotients and roots in the same order; on hardware a fused product turns the \
                     normals of small triangles";

/// One row for each kernel.
pub const ROWS: &[Row] = &[
    Row {
        name: "bend_hinges",
        entry: "bend_hinges",
        tolerance: Tolerance::new(0.0, 8192.0, FOLDED),
        check: hinges,
    },
    Row {
        name: "blow_on_panels",
        entry: "blow_on_panels",
        tolerance: Tolerance::new(0.0, 64.0, BLOWN),
        check: panels,
    },
    Row {
        name: "scale_loads",
        entry: "scale_loads",
        tolerance: Tolerance::new(0.0, 64.0, SUMMED),
        check: scales,
    },
];

/// On grids and meshes, with gusts.
fn panels(bench: &mut Bench<'_>) -> Result<(), String> {
    let fixtures = fixtures(bench)?;
    let kernel = kernel_of(bench, Name::new("blow_on_panels"), &fixtures[0])?;
    for mut fixture in fixtures {
        fixture.on_cpu(&[]);
        let (first, count) =
            (fixture.tables.elements.first_panel_force(), fixture.tables.elements.panels.len());
        let mut wanted = fixture.element_forces();
        wanted[..first].fill([f32::NAN; 4]);
        let (arrays, records) = (fixture.arrays(), fixture.records());
        bench.run(
            &kernel,
            &Given { arrays: &arrays, records: &records, groups: count.div_ceil(256) },
            |written| {
                written.fours("element_forces", &wanted);
            },
        )?;
    }
    Ok(())
}

fn hinges(bench: &mut Bench<'_>) -> Result<(), String> {
    let fixtures = fixtures(bench)?;
    let kernel = kernel_of(bench, Name::new("bend_hinges"), &fixtures[0])?;
    for mut fixture in fixtures {
        fixture.on_cpu(&[]);
        let mut wanted = fixture.element_forces();
        wanted[fixture.tables.elements.first_panel_force()..].fill([f32::NAN; 4]);
        let (arrays, records) = (fixture.arrays(), fixture.records());
        let groups = fixture.tables.elements.hinges.len().div_ceil(256);
        bench.run(&kernel, &Given { arrays: &arrays, records: &records, groups }, |written| {
            written.fours("element_forces", &wanted);
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
