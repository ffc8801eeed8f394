//! Every kernel of the GPU's backend against its twin on the CPU.

mod faults;
mod roundings;

use crate::common::gpu;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use taffeta::parity::{Row, entry_points, rows};
use taffeta::taffeta_gpu::Gpu;

/// Does something with all items, on as many threads as there are cores. Returns the errors.
fn errors<T: Sync>(items: &[T], job: impl Fn(&T) -> Result<(), String> + Sync) -> Vec<String> {
    let next = AtomicUsize::new(0);
    let work = || {
        let mut errors = Vec::new();
        while let Some(item) = items.get(next.fetch_add(1, Ordering::Relaxed)) {
            errors.extend(job(item).err());
        }
        errors
    };
    std::thread::scope(|scope| {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        workers.into_iter().flat_map(|worker| worker.join().expect("a job does not panic")).collect()
    })
}

/// Runs a row. The error says by how much the twins differ.
fn check(row: &Row, gpu: &Gpu) -> Result<(), String> {
    let name = row.name;
    let outcome = row.run(gpu).map_err(|why| format!("{name}: {why}"))?;
    let allowed = row.tolerance.on(gpu);
    println!(
        "{name}: {} ulps of {allowed} in {} numbers, {:?}",
        outcome.ulps, outcome.compared, outcome.place
    );
    if outcome.compared == 0 {
        return Err(format!("{name} compares nothing"));
    }
    let place = outcome.place.filter(|_| outcome.ulps > allowed);
    place.map_or(Ok(()), |place| {
        let why = row.tolerance.why;
        Err(format!("{name}: {} units in the last place, {allowed} allowed ({why}): {place}", outcome.ulps))
    })
}

#[test]
fn every_kernel_is_as_its_twin() {
    let (rows, gpu) = (rows(), gpu());
    assert!(rows.len() > 90, "{} rows", rows.len());
    let differ = errors(&rows, |row| check(row, &gpu));
    assert!(differ.is_empty(), "{}", differ.join("\n"));
}

#[test]
fn every_entry_point_has_a_row() {
    let rows = rows();
    for entry in entry_points().expect("sources that naga reads") {
        assert!(rows.iter().any(|row| row.entry == entry), "kernel `{entry}` has no row");
    }
}

/// The names that follow `@compute` in the WGSL under a folder, but for the formulas that only rows run.
fn compute_functions(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    for path in std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()) {
        if path.is_dir() && !path.ends_with("parity") {
            found.extend(compute_functions(&path));
        } else if path.extension().is_some_and(|extension| extension == "wgsl") {
            let text = std::fs::read_to_string(&path).expect("a text");
            let after = text.split("@compute").skip(1).filter_map(|rest| rest.split("fn ").nth(1));
            found.extend(after.filter_map(|rest| rest.split('(').next()).map(str::to_owned));
        }
    }
    found
}

#[test]
fn every_kernel_in_the_folders_is_among_the_entry_points() {
    let known = entry_points().expect("sources that naga reads");
    let written = compute_functions(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"));
    assert_eq!(written.len(), known.len());
    for name in written {
        assert!(known.contains(&name), "no source of a kernel has `{name}`");
    }
}
