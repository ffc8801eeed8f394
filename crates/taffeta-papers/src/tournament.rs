//! Which way of solving springs is the fastest to a wanted error, on scenes without contact.
//!
//! Each run is compared with a reference in 64 bits. [`names`] has what there is to run, [`run`] makes one of them, and
//! [`sections`] shows what is kept of those that were made, each under its name.

mod method;
mod page;
mod plan;
mod reference;
mod rk4;
mod run;
mod scenes;

pub use page::sections;

use plan::Entry;
use scenes::{CASES, SHEETS};
use serde_json::Value;
use std::path::Path;

/// Names of all runs, in the order of tables; of a quick look those of a few.
pub fn names(quick: bool) -> Vec<String> {
    let entries = [&CASES[..], &SHEETS].into_iter().flat_map(|cases| plan::entries(cases, quick));
    entries.map(|entry: Entry| entry.name()).collect()
}

/// Runs what has that name. What it is compared with is kept in `folder`, and taken from there if it is there.
///
/// # Errors
/// Where there is no run of that name, or it cannot be made. A run that blows up is a result.
pub fn run(name: &str, folder: &Path) -> Result<Value, String> {
    let entry = plan::named(name);
    let entry = entry.ok_or_else(|| format!("there is no run `{name}`; `tournament::names` has them all"))?;
    let reference = reference::of(entry.case, folder)?;
    let run = run::run(&entry, &reference)?;
    serde_json::to_value(run).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use run::Run;

    #[test]
    fn a_run_is_made_by_its_name_and_one_that_blows_up_is_a_result() {
        let folder = tempfile::tempdir().unwrap();
        let made = |name: &str| run(name, folder.path()).map(|value| Run::read(&value).unwrap());
        let held = made("tournament-chain-soft-springs-25").unwrap();
        assert!(held.holds() && held.runs >= 3 && held.wall_ms.is_some_and(|wall| wall.is_sorted()));
        assert!(held.error.is_some_and(|error| error > 1e4 * held.reference), "{held:?}");
        let lost = made("tournament-chain-soft-springs-12").unwrap();
        assert!(lost.diverged == Some(1) && !lost.holds() && lost.cost().is_none());
        let error = made("tournament-chain-soft-springs-1").unwrap_err();
        assert!(error.contains("there is no run `tournament-chain-soft-springs-1`"), "{error}");
    }
}
