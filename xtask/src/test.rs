//! `cargo xtask test`: formatting, lints, tests, and every scene for a few frames, each with its time.

mod npy;
mod scenes;

use crate::program::cargo;
use crate::{display, vulkan};
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

/// Bevy has a profile of its own, in which it is built in minutes.
const WITH_BEVY: [&str; 4] = ["--profile", "bevy", "-p", "bevy_taffeta"];
const WITHOUT_BEVY: [&str; 3] = ["--workspace", "--exclude", "bevy_taffeta"];

/// Runs all checks; the first that fails ends the run.
pub fn run() -> ExitCode {
    let start = Instant::now();
    let lints = ["--all-targets", "--", "-D", "warnings"];
    let result = vulkan::provide()
        .and_then(|()| display::provide())
        .and_then(|()| component("rustfmt", &["fmt", "--all", "--check"]))
        .and_then(|()| component("clippy", &[&["clippy", "--release"], &WITHOUT_BEVY[..], &lints].concat()))
        .and_then(|()| timed("tests", cargo(&[&["test", "--release"], &WITHOUT_BEVY[..]].concat())))
        // With the `taffeta` that tests have left: a build alone gives what it needs other features, and makes it all anew.
        .and_then(|()| scenes::run())
        .and_then(|()| component("clippy", &[&["clippy"], &WITH_BEVY[..], &lints].concat()))
        .and_then(|()| timed("tests with Bevy", cargo(&[&["test"], &WITH_BEVY[..]].concat())));
    match result {
        Ok(()) => {
            println!("xtask: all passed in {:.1} s", start.elapsed().as_secs_f64());
            ExitCode::SUCCESS
        }
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

/// A cargo command that needs a component of the toolchain; where that is missing it is skipped, and said.
fn component(name: &str, words: &[&str]) -> Result<(), String> {
    let probe = cargo(&[words[0], "--version"]).stdout(Stdio::null()).stderr(Stdio::null()).status();
    if probe.is_ok_and(|status| status.success()) {
        return timed(name, cargo(words));
    }
    println!("xtask: {name}: skipped, not installed (`rustup component add {name}`)");
    Ok(())
}

fn timed(name: &str, mut command: Command) -> Result<(), String> {
    println!("xtask: {name}");
    let start = Instant::now();
    let status =
        vulkan::quiet(&mut command).status().map_err(|error| format!("{name}: cannot start: {error}"))?;
    if !status.success() {
        return Err(format!("{name}: failed ({status})"));
    }
    println!("xtask: {name}: passed in {:.1} s", start.elapsed().as_secs_f64());
    Ok(())
}
