//! What is run: each scene by each method, in longer and shorter steps.

use super::method::Method;
use super::scenes::{CASES, Case, SHEETS, Steps};

/// Explicit springs are run with this many sub-steps in a frame at most.
const MOST: u32 = 1200;
/// Where the method of Runge and Kutta needs so many, it is not run with four times as many.
const DEAR: u32 = 100;

/// A run: a scene by a method, with so many sub-steps in a frame.
#[derive(Clone, Copy)]
pub struct Entry {
    pub case: &'static Case,
    pub method: Method,
    pub steps: u32,
}

impl Entry {
    /// The name under which it is kept.
    pub fn name(&self) -> String {
        format!("tournament-{}-{}-{}", self.case.name, self.method.name(), self.steps)
    }
}

/// All runs of some scenes, in the order of tables; of a quick look a few of small ones.
pub fn entries(cases: &'static [Case], quick: bool) -> Vec<Entry> {
    let looked_at = |case: &&Case| !quick || case.name.ends_with("-soft");
    let of = |case: &'static Case| {
        let of_method = move |method| {
            let steps = plan(case, method, quick).into_iter();
            steps.map(move |steps| Entry { case, method, steps })
        };
        Method::ALL.into_iter().flat_map(of_method)
    };
    cases.iter().filter(looked_at).flat_map(of).collect()
}

/// The run of that name.
pub fn named(name: &str) -> Option<Entry> {
    [&CASES[..], &SHEETS]
        .into_iter()
        .flat_map(|cases| entries(cases, false))
        .find(|entry| entry.name() == name)
}

/// Sub-steps in a frame that a method is run with.
fn plan(case: &Case, method: Method, quick: bool) -> Vec<u32> {
    match &case.steps {
        Some(steps) => of_sheet(case, method, steps),
        None => of_small(case, method, quick),
    }
}

fn of_sheet(case: &Case, method: Method, steps: &Steps) -> Vec<u32> {
    match method {
        Method::Springs => steps.springs.iter().map(|times| times * case.fewest[0]).collect(),
        Method::Dual => steps.dual.to_vec(),
        Method::DualSolved => steps.solved.to_vec(),
        Method::Primal => steps.primal.to_vec(),
        Method::Acad | Method::Rk4 | Method::Rk4F64 => Vec::new(),
    }
}

/// Half of the fewest that hold is to blow up.
fn of_small(case: &Case, method: Method, quick: bool) -> Vec<u32> {
    let [springs, rk4] = case.fewest;
    let halves = |fewest: u32, times: &[u32]| times.iter().map(|times| times * fewest / 2).collect();
    match method {
        Method::DualSolved => Vec::new(),
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn each_run_has_a_name_of_its_own_and_a_quick_look_takes_some_of_the_small_ones() {
        let names = |cases: &'static [Case], quick| {
            let entries = entries(cases, quick);
            let names: BTreeSet<String> = entries.iter().map(Entry::name).collect();
            assert_eq!(names.len(), entries.len());
            names
        };
        let [all, some] = [false, true].map(|quick| names(&CASES, quick));
        assert!(some.is_subset(&all) && some.len() * 4 < all.len());
        let sheets = names(&SHEETS, false);
        assert!(all.is_disjoint(&sheets) && names(&SHEETS, true).is_empty());
        let fits = |c: char| c.is_ascii_alphanumeric() || c == '-';
        assert!(all.iter().chain(&sheets).all(|name| name.chars().all(fits)));
        assert!(named("tournament-sheet-100k-1000-primal-4").is_some_and(|entry| entry.steps == 4));
    }

    #[test]
    fn implicit_springs_take_no_more_steps_on_a_sheet_than_explicit_ones_need() {
        for entry in entries(&SHEETS, false).iter().filter(|entry| entry.method != Method::Springs) {
            assert!(entry.steps < entry.case.fewest[0], "{}", entry.name());
        }
    }
}
