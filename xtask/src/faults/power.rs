//! Power failures: a run's calls are traced once. After each of them the states that a power failure there may leave on the disk are made,
//! and a run goes on from each. ALICE (Pillai et al., "All File Systems Are Not Created Equal", OSDI 2014) does so with other programs.

use super::disk::{Disk, Fate, Operation, State, Unsynced};
use super::{Desk, RESUME, RUN, Results, log};
use crate::attack::Chance;
use std::collections::{HashMap, HashSet};
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// States after each operation that are made up at random.
const RANDOM: u64 = 4;
/// Failures of a run that are printed in full.
const PRINTED: usize = 10;
/// Operations before a failure that are printed, and what was lost in it.
const BEFORE: usize = 4;
const LOST: usize = 12;

const CHECKPOINT: &str = "out/checkpoint.taffeta";

/// A run to trace; all of them end with the same results.
struct Trial {
    name: &'static str,
    /// The scene of an earlier run in the folder, and how many frames that had.
    before: Option<(&'static str, u32)>,
    run: &'static str,
    /// It goes on from the checkpoint of the earlier run, which else is of no use.
    goes_on: bool,
}

const TRIALS: [Trial; 4] = [
    Trial { name: "a new run", before: None, run: RUN, goes_on: false },
    Trial { name: "a run that goes on", before: Some(("scene.toml", 4)), run: RESUME, goes_on: true },
    Trial {
        name: "a run after one of another scene",
        before: Some(("other.toml", 2)),
        run: RUN,
        goes_on: false,
    },
    // The files of the new run are long enough for the old checkpoint before it has one of its own.
    Trial { name: "a run after a shorter one", before: Some(("scene.toml", 2)), run: RUN, goes_on: false },
];

/// A state to try.
struct Case {
    state: State,
    /// How it came about, in words.
    how: String,
    lost: Vec<String>,
}

/// What must be in each state.
#[derive(Clone, Copy, Hash)]
struct Promise {
    /// A checkpoint: it was written, and the program went on.
    checkpoint: bool,
    /// All results: the run has ended.
    results: bool,
}

/// Tries all runs. Returns how many states there were and how many of them were not withstood.
pub fn try_all(desk: &Desk, whole: &Results) -> Result<[usize; 2], String> {
    let (mut states, mut failed) = (0, 0);
    for trial in &TRIALS {
        let found = Traced::new(desk, trial, whole)?.try_all()?;
        println!("xtask: power failures in {}: {} states, {} not withstood", trial.name, found[0], found[1]);
        (states, failed) = (states + found[0], failed + found[1]);
    }
    Ok([states, failed])
}

/// A run that was traced.
struct Traced<'a> {
    desk: &'a Desk<'a>,
    trial: &'a Trial,
    whole: &'a Results,
    disk: Disk,
    operations: Vec<Operation>,
    /// The checkpoint that was there before.
    earlier: Option<Vec<u8>>,
}

impl<'a> Traced<'a> {
    fn new(desk: &'a Desk, trial: &'a Trial, whole: &'a Results) -> Result<Self, String> {
        desk.clear()?;
        if let Some((scene, frames)) = trial.before {
            desk.run(&format!("{} --frames {frames}", RUN.replace("scene.toml", scene)))?;
        }
        let disk =
            Disk::of(&desk.folder, "out").map_err(|error| format!("{}: {error}", desk.folder.display()))?;
        let earlier = fs::read(desk.folder.join(CHECKPOINT)).ok();
        desk.trace(&log::FLAGS, trial.run)?;
        desk.has(whole).map_err(|what| format!("{}, traced: {what}", trial.name))?;
        let folder = desk.folder.canonicalize().map_err(|error| error.to_string())?;
        let operations = log::operations(&desk.log()?, &folder)?;
        Ok(Self { desk, trial, whole, disk, operations, earlier })
    }

    fn try_all(mut self) -> Result<[usize; 2], String> {
        let operations = std::mem::take(&mut self.operations);
        let (mut seen, mut printed, mut done, mut failed) = (HashSet::new(), HashSet::new(), Vec::new(), 0);
        let mut promise = Promise { checkpoint: self.trial.goes_on, results: false };
        let mut is_renamed = false;
        for (index, operation) in operations.iter().enumerate() {
            let Some(words) = self.disk.apply(operation)? else { continue };
            done.push(words);
            is_renamed |= matches!(operation, Operation::Rename { to, .. } if to == CHECKPOINT);
            // The folder is synced after it.
            promise.checkpoint |= is_renamed && matches!(operation, Operation::Sync { .. });
            promise.results = operations[index + 1..].iter().all(changes_nothing);
            let mut cases = cases(&self.disk, index as u64);
            cases.retain(|case| seen.insert(hash(&(&case.state, promise))));
            for (case, what) in self.failures(&cases, promise) {
                failed += 1;
                // One fault shows in many states.
                if printed.len() < PRINTED && printed.insert(what.clone()) {
                    self.tell(&done, case, &what);
                }
            }
        }
        Ok([seen.len(), failed])
    }

    /// Those states from which no run goes on to the whole results, and why.
    fn failures<'b>(&self, cases: &'b [Case], promise: Promise) -> Vec<(&'b Case, String)> {
        let (next, failed) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
        std::thread::scope(|scope| {
            for worker in 0..std::thread::available_parallelism().map_or(1, usize::from) {
                let (next, failed) = (&next, &failed);
                scope.spawn(move || {
                    let folder = self.desk.folder.join(format!("desk{worker}"));
                    let desk = Desk { program: self.desk.program, folder };
                    loop {
                        let index = next.fetch_add(1, Ordering::Relaxed);
                        let Some(case) = cases.get(index) else { return };
                        if let Err(what) = self.try_one(&desk, &case.state, promise) {
                            failed.lock().expect("no thread panics").push((index, what));
                        }
                    }
                });
            }
        });
        let mut failed = failed.into_inner().expect("no thread panics");
        failed.sort();
        failed.into_iter().map(|(index, what)| (&cases[index], what)).collect()
    }

    fn try_one(&self, desk: &Desk, state: &State, promise: Promise) -> Result<(), String> {
        let checkpoint = state.get(CHECKPOINT);
        if promise.checkpoint && checkpoint.is_none() {
            return Err("the checkpoint is lost".into());
        }
        desk.clear()?;
        put(state, &desk.folder)?;
        if promise.results {
            return desk.has(self.whole).map_err(|what| format!("the run had ended, and {what}"));
        }
        // The user has given up the earlier run: if it cannot go on, that is no loss.
        let is_old = !self.trial.goes_on && checkpoint.is_some_and(|content| *content == self.earlier);
        match checkpoint {
            None => desk.run(RUN)?,
            Some(_) if is_old => {
                // A shorter run must not go on with the files of the new one.
                desk.run(RESUME).or_else(|_| desk.run(RUN))?;
            }
            Some(_) => desk.run(RESUME)?,
        }
        desk.has(self.whole)
    }

    fn tell(&self, done: &[String], case: &Case, what: &str) {
        println!(
            "xtask: {}, {} operations, then power fails ({}): {}",
            self.trial.name,
            done.len(),
            case.how,
            what.trim()
        );
        println!("  last: {}", done[done.len().saturating_sub(BEFORE)..].join("; "));
        let more = case.lost.len().saturating_sub(LOST);
        let more = if more > 0 { format!("; and {more} more") } else { String::new() };
        println!("  lost: {}{more}", case.lost[..case.lost.len().min(LOST)].join("; "));
    }
}

/// Whether an operation is none that a disk sees.
fn changes_nothing(operation: &Operation) -> bool {
    use Operation::{Close, Read, Seek, Unknown};
    matches!(operation, Close { .. } | Read { .. } | Seek { .. } | Unknown { .. })
}

/// The states that a power failure may leave now.
fn cases(disk: &Disk, seed: u64) -> Vec<Case> {
    let mut cases = Vec::new();
    let mut add = |how: String, fate: &mut dyn FnMut(Unsynced) -> Fate| {
        let (state, lost) = disk.state(fate);
        cases.push(Case { state, how, lost });
    };
    let lost = |is_lost: bool| if is_lost { Fate::Lost } else { Fate::Kept };
    add("all is kept".into(), &mut |_| Fate::Kept);
    add("all that was not synced is lost".into(), &mut |_| Fate::Lost);
    add("data are lost".into(), &mut |one| lost(!one.is_name));
    add("data are zeros".into(), &mut |one| if one.is_write { Fate::Length } else { Fate::Kept });
    add("names are lost".into(), &mut |one| lost(one.is_name));
    for name in 0..disk.unsynced_names() {
        add("one name is lost".into(), &mut |one| lost(one.is_name && one.number == name));
        add("one name is kept".into(), &mut |one| lost(one.is_name && one.number != name));
    }
    for number in 0..RANDOM {
        let mut chance = Chance::new(seed * RANDOM + number);
        if number % 2 == 0 {
            add("at random".into(), &mut |one| at_random(one, &mut chance));
            continue;
        }
        // Of each folder and file what came first is kept.
        let mut ends = HashMap::new();
        add("at random, in order".into(), &mut |one| {
            let end = *ends.entry(one.node).or_insert_with(|| chance.below(6));
            lost(one.index as u64 >= end)
        });
    }
    cases
}

fn at_random(one: Unsynced, chance: &mut Chance) -> Fate {
    match (one.is_write, chance.below(6)) {
        (_, 0..3) => Fate::Kept,
        (true, 3) => Fate::Half,
        (true, 4) => Fate::Length,
        _ => Fate::Lost,
    }
}

fn hash(what: &impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    what.hash(&mut hasher);
    hasher.finish()
}

/// Makes the files of a state in a folder.
fn put(state: &State, folder: &Path) -> Result<(), String> {
    // A folder comes before what is in it.
    for (path, content) in state {
        let path = folder.join(path);
        let made = match content {
            Some(bytes) => fs::write(&path, bytes),
            None => fs::create_dir(&path),
        };
        made.map_err(|error| format!("{}: {error}", path.display()))?;
    }
    Ok(())
}
