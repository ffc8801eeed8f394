//! Which way of solving springs is the fastest to a wanted error, on three scenes without contact.
//!
//! Each run is compared with a reference by the method of Runge and Kutta in 64 bits. [`names`] has what there is to run, [`run`]
//! makes one of them, and [`section`] shows what is kept of those that were made, each under its name.

mod method;
mod page;
mod reference;
mod rk4;
mod run;
mod scenes;

pub use method::Method;
pub use page::section;
pub use run::Run;

use scenes::{CASES, Case};
use serde_json::Value;
use std::path::Path;

/// What is run: a scene by a method, with so many sub-steps in a frame.
#[derive(Clone, Copy)]
struct Entry {
    case: &'static Case,
    method: Method,
    steps: u32,
}

impl Entry {
    fn name(&self) -> String {
        format!("tournament-{}-{}-{}", self.case.name, self.method.name(), self.steps)
    }
}

/// All runs, in the order of tables; of a quick look a few.
fn entries(quick: bool) -> Vec<Entry> {
    let looked_at = |case: &&Case| !quick || case.name.ends_with("-soft");
    let of = |case: &'static Case| {
        let of_method = move |method| {
            let steps = plan(case, method, quick).into_iter();
            steps.map(move |steps| Entry { case, method, steps })
        };
        Method::ALL.into_iter().flat_map(of_method)
    };
    CASES.iter().filter(looked_at).flat_map(of).collect()
}

/// Explicit springs are run with this many sub-steps in a frame at most.
const MOST: u32 = 1200;
/// Where the method of Runge and Kutta needs so many, it is not run with four times as many.
const DEAR: u32 = 100;

/// Sub-steps in a frame that a method is run with. Half of the fewest that hold is to blow up.
fn plan(case: &Case, method: Method, quick: bool) -> Vec<u32> {
    let [springs, rk4] = case.fewest;
    let halves = |fewest: u32, times: &[u32]| times.iter().map(|times| times * fewest / 2).collect();
    match method {
        Method::Dual | Method::Primal if quick => vec![1, 4],
        Method::Dual | Method::Primal => vec![1, 2, 4, 8, 16, 32, 64],
        Method::Springs if quick => halves(springs, &[1, 2, 4]),
        Method::Acad | Method::Rk4 | Method::Rk4F64 if quick => {
            halves(if method.of_engine() { springs } else { rk4 }, &[2])
        }
        Method::Springs => {
            let doubled = (0..).map(|times| (springs << times) / 2);
            doubled.take_while(|&steps| steps <= MOST).collect()
        }
        Method::Acad => halves(springs, &[1, 2, 4]),
        Method::Rk4 => halves(rk4, &[1, 2, 4]),
        Method::Rk4F64 if rk4 < DEAR => halves(rk4, &[2, 4, 8]),
        Method::Rk4F64 => halves(rk4, &[2, 4]),
    }
}

/// Names of all runs, in the order of tables; of a quick look those of a few.
pub fn names(quick: bool) -> Vec<String> {
    entries(quick).iter().map(Entry::name).collect()
}

/// Runs what has that name. What it is compared with is kept in `folder`, and taken from there if it is there.
///
/// # Errors
/// Where there is no run of that name, or it cannot be made. A run that blows up is a result.
pub fn run(name: &str, folder: &Path) -> Result<Value, String> {
    let entry = entries(false).into_iter().find(|entry| entry.name() == name);
    let entry = entry.ok_or_else(|| format!("there is no run `{name}`; `tournament::names` has them all"))?;
    let reference = reference::of(entry.case, folder)?;
    let run = run::run(&entry, &reference)?;
    serde_json::to_value(run).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn each_run_has_a_name_of_its_own_and_a_quick_look_takes_some_of_them() {
        let [all, some] = [false, true].map(|quick| names(quick).into_iter().collect::<BTreeSet<_>>());
        assert_eq!((all.len(), some.len()), (names(false).len(), names(true).len()));
        assert!(some.is_subset(&all) && some.len() * 4 < all.len());
        assert!(all.iter().all(|name| name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-')));
    }

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
