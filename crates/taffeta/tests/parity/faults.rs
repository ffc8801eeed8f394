//! Faults in the sources of kernels, each of which a row must find.

mod nodes;
mod pairs;
mod primal;
mod solve;
mod volumes;

use super::GPU;
use taffeta::parity::rows;

/// The row that must find it, what is written, and what is put in its place.
type Fault = (&'static str, &'static str, &'static str);

#[test]
fn faults_in_the_sources_are_found() {
    let rows = rows();
    let mut missed = Vec::new();
    let all = [nodes::FAULTS, volumes::FAULTS, solve::FAULTS, primal::FAULTS, pairs::FAULTS];
    for (name, written, fault) in all.into_iter().flatten() {
        let row = rows.iter().find(|row| row.name == *name).expect("a row");
        let edit = |source: String| {
            assert!(source.contains(written), "`{written}` is not in the sources of {name}");
            source.replace(written, fault)
        };
        let outcome = row
            .run_edited(&GPU, GPU.info().is_software(), &edit)
            .unwrap_or_else(|why| panic!("{name}, `{fault}`: {why}"));
        let allowed = row.tolerance.on(&GPU);
        if outcome.ulps <= allowed {
            missed.push(format!("{name} does not find `{fault}`: {} of {allowed}", outcome.ulps));
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}
