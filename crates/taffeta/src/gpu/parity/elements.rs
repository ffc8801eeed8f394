//! Rows of the elements that several nodes share: hinges and torques.

use super::bench::{Bench, Given};
use super::fixture::words;
use super::particles::{fixtures, kernel_of, scaled_loads};
use super::{Row, Tolerance};
use crate::gpu::kernels::Name;
use crate::gpu::layout::{Four, Load};

const FOLDED: &str = "sums, products, quotients and roots in the same order; on hardware a fused product turns the \
                      normals of slivers";
const SUMMED: &str = "both add up in lanes and by halves; on hardware fused products add up over 642 nodes";

/// One row for each kernel.
pub const ROWS: &[Row] = &[
    Row {
        name: "bend_hinges",
        entry: "bend_hinges",
        tolerance: Tolerance::new(0.0, 8192.0, FOLDED),
        check: hinges,
    },
    Row {
        name: "scale_loads",
        entry: "scale_loads",
        tolerance: Tolerance::new(0.0, 64.0, SUMMED),
        check: scales,
    },
];

fn hinges(bench: &mut Bench<'_>) -> Result<(), String> {
    let fixtures = fixtures(bench)?;
    let kernel = kernel_of(bench, Name::new("bend_hinges"), &fixtures[0])?;
    for mut fixture in fixtures {
        let (between, _) = fixture.on_cpu(|_| {});
        let wanted: Vec<Four> =
            between.hinge_forces.as_flattened().iter().map(|&[x, y, z]| [x, y, z, 0.0]).collect();
        let (arrays, records) = (fixture.arrays(), fixture.records());
        let groups = fixture.tables.hinges.len().div_ceil(256);
        bench.run(&kernel, &Given { arrays: &arrays, records: &records, groups }, |written| {
            written.fours("hinge_forces", &wanted);
        })?;
    }
    Ok(())
}

fn scales(bench: &mut Bench<'_>) -> Result<(), String> {
    let fixtures = fixtures(bench)?;
    let kernel = kernel_of(bench, Name::new("scale_loads"), &fixtures[0])?;
    for mut fixture in fixtures {
        let (between, _) = fixture.on_cpu(|_| {});
        let wanted = scaled_loads(&fixture, &between.torques);
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
