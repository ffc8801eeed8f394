//! `cargo xtask sanitize`: runs tests that use threads under ThreadSanitizer, and small ones under Miri, after a fault was planted that
//! each of them must find.

use crate::root;
use std::process::{Command, ExitCode, Stdio};

/// The test that writes one number from two threads.
const PLANTED: &str = "cpu::shared::tests::two_workers_write_one_item_at_once";
/// What ThreadSanitizer needs of the compiler, and of the standard library: all code must know of it.
const THREAD: [&str; 3] = ["-Zbuild-std", "--target", "x86_64-unknown-linux-gnu"];
/// Tests of the engine's library and of whole scenes that run on several threads, in all solvers and with contact.
const ON_THREADS: [(&str, &[&str]); 2] = [
    ("--lib", &["cpu::"]),
    (
        "--test=it",
        &["freezing::the_others", "freezing::several", "determinism::", "stopping::", "--skip=gpu"],
    ),
];
/// Tests that Miri, which is a thousand times slower, runs in minutes.
const SMALL: [&str; 6] =
    ["cpu::cells::", "cpu::team::", "cpu::states::", "cpu::places::", "cpu::feature::", "cpu::balance::"];

/// Runs both, or the one that `words` name.
pub fn run(words: &[&str]) -> ExitCode {
    let result = match words {
        [] => thread().and_then(|()| miri()),
        ["thread"] => thread(),
        ["miri"] => miri(),
        _ => Err(format!("sanitize {}: it takes `thread`, `miri` or nothing", words.join(" "))),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

/// Data races, by the vector clocks of ThreadSanitizer.
fn thread() -> Result<(), String> {
    check_component("rust-src")?;
    let words = |target, more: &[&str]| {
        let mut words = vec!["test", "--profile", "quick", "-p", "taffeta", target];
        words.extend_from_slice(&THREAD);
        words.push("--");
        words.extend_from_slice(more);
        let mut command = nightly(&words, "target/sanitize-thread");
        command.env("RUSTFLAGS", "-Zsanitizer=thread").env("TSAN_OPTIONS", "halt_on_error=1");
        command
    };
    finds_planted(words("--lib", &["--ignored", "--exact", PLANTED]), "WARNING: ThreadSanitizer: data race")?;
    ON_THREADS.iter().try_for_each(|(target, tests)| passes(words(target, tests)))
}

/// Undefined behaviour of any sort, by Miri's interpreter.
fn miri() -> Result<(), String> {
    check_component("miri")?;
    let words = |more: &[&str]| {
        let mut words = vec!["miri", "test", "-p", "taffeta", "--no-default-features", "--lib", "--"];
        words.extend_from_slice(more);
        let mut command = nightly(&words, "target/sanitize-miri");
        // How many cores there are, and the time, are asked of the machine.
        // The threads of rayon follow the rules of trees of borrows, not those of stacks, and outlive the program.
        command.env("MIRIFLAGS", "-Zmiri-disable-isolation -Zmiri-tree-borrows -Zmiri-ignore-leaks");
        command
    };
    finds_planted(words(&["--ignored", "--exact", PLANTED]), "Data race detected")?;
    passes(words(&SMALL))
}

fn nightly(words: &[&str], target: &str) -> Command {
    let mut command = Command::new("rustup");
    command.args(["run", "nightly", "cargo"]).args(words).current_dir(root());
    command.env("CARGO_TARGET_DIR", root().join(target));
    command
}

fn check_component(name: &str) -> Result<(), String> {
    let add = format!("`rustup toolchain install nightly --component {name}`");
    let output = Command::new("rustup").args(["+nightly", "component", "list", "--installed"]).output();
    let output = output.map_err(|error| format!("rustup: {error}; {add} needs it"))?;
    let listed = String::from_utf8_lossy(&output.stdout);
    if listed.lines().any(|line| line.starts_with(name)) {
        return Ok(());
    }
    Err(format!("it needs a nightly compiler with {name}: {add}"))
}

/// Runs a test that must fail, and say so.
fn finds_planted(mut command: Command, what: &str) -> Result<(), String> {
    println!("xtask: a planted race must be found");
    let output = command.stdin(Stdio::null()).output().map_err(|error| format!("cargo: {error}"))?;
    let said = String::from_utf8_lossy(&output.stderr) + String::from_utf8_lossy(&output.stdout);
    if !output.status.success() && said.contains(what) {
        return Ok(());
    }
    let last: Vec<&str> = said.lines().rev().take(20).collect();
    let last = last.into_iter().rev().collect::<Vec<_>>().join("\n");
    Err(format!("the planted race was not found:\n{last}"))
}

/// Runs tests that must pass.
fn passes(mut command: Command) -> Result<(), String> {
    let status = command.status().map_err(|error| format!("cargo: {error}"))?;
    if status.success() { Ok(()) } else { Err("a test failed, or something was found: see above".into()) }
}
