//! Faults in the sources of kernels, each of which a row must find. `cargo xtask mutate` plants them.

mod fabric;
mod nodes;
mod pairs;
mod primal;
mod solve;
mod solved;
mod surfaces;
mod volumes;

use super::errors;
use crate::common::gpu;
use std::cell::Cell;
use std::path::Path;
use taffeta::parity::rows;
use taffeta::taffeta_gpu::Gpu;
use twox_hash::XxHash64;

/// The row that must find it, what is written, and what is put in its place.
type Fault = (&'static str, &'static str, &'static str);

fn all() -> Vec<&'static Fault> {
    let lists = [
        nodes::FAULTS,
        fabric::FAULTS,
        volumes::FAULTS,
        solve::FAULTS,
        primal::FAULTS,
        pairs::FAULTS,
        surfaces::FAULTS,
        solved::FAULTS,
    ];
    lists.into_iter().flatten().collect()
}

/// Those that `TAFFETA_FAULTS` chooses: `COUNT SEED` is a sample that the seed draws, nothing is all.
pub fn chosen<T>(all: Vec<T>) -> Vec<T> {
    let Ok(words) = std::env::var("TAFFETA_FAULTS") else { return all };
    let (count, seed) = words.split_once(' ').expect("a count and a seed");
    drawn(all, count.parse().expect("a count"), seed)
}

/// As many as that, in an order that the seed alone decides.
fn drawn<T>(all: Vec<T>, count: usize, seed: &str) -> Vec<T> {
    let mut all: Vec<_> = (0_u64..).zip(all).collect();
    all.sort_by_key(|(index, _)| XxHash64::oneshot(*index, seed.as_bytes()));
    all.into_iter().map(|(_, one)| one).take(count).collect()
}

/// Plants a fault. The error says that its row does not find it.
fn plant(&(name, written, fault): &Fault, gpu: &Gpu) -> Result<(), String> {
    let row = rows().into_iter().find(|row| row.name == name).ok_or(format!("no row `{name}`"))?;
    let is_planted = Cell::new(false);
    let edit = |source: String| {
        // A row may run its kernel with several choices of what it imports.
        is_planted.set(is_planted.get() || source.contains(written));
        source.replace(written, fault)
    };
    let outcome = row
        .run_edited(gpu, gpu.info().is_software(), &edit)
        .map_err(|why| format!("{name}, `{fault}`: {why}"))?;
    assert!(is_planted.get(), "`{written}` is not in the sources of {name}");
    let allowed = row.tolerance.on(gpu);
    if outcome.ulps > allowed {
        return Ok(());
    }
    Err(format!("{name} does not find `{fault}`: {} of {allowed}", outcome.ulps))
}

#[test]
#[ignore = "all faults take minutes: `cargo xtask mutate`"]
fn planted_faults_are_found() {
    let (faults, gpu) = (chosen(all()), gpu());
    let missed = errors(&faults, |fault| {
        println!("{}: `{}` for `{}`", fault.0, fault.2, fault.1);
        plant(fault, &gpu)
    });
    println!("{} faults were planted, {} were found", faults.len(), faults.len() - missed.len());
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}

#[test]
fn a_seed_draws_a_sample_and_another_seed_another() {
    assert!(all().len() > 400);
    let [a, b] = ["a", "b"].map(|seed| drawn(all(), 20, seed));
    assert_eq!((a.len(), &a), (20, &drawn(all(), 20, "a")));
    assert!(a != b && a.iter().enumerate().all(|(i, fault)| !a[..i].contains(fault)));
}

/// The text of the engine's WGSL.
pub fn sources() -> String {
    shaders(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"))
}

/// The text of all WGSL under a folder.
fn shaders(folder: &Path) -> String {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let text = |path: std::path::PathBuf| match path.extension() {
        _ if path.is_dir() => shaders(&path),
        Some(extension) if extension == "wgsl" => std::fs::read_to_string(path).expect("a text"),
        _ => String::new(),
    };
    entries.map(text).collect()
}

#[test]
fn what_faults_replace_is_in_the_sources() {
    let text = sources();
    for (name, written, fault) in all() {
        assert!(text.contains(written), "`{written}` is in no source: {name} cannot find `{fault}`");
        assert!(rows().iter().any(|row| row.name == *name), "no row `{name}`");
    }
}
