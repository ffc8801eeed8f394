//! `cargo xtask test`: formatting, lints, and every test, each part with its time.

mod built;
mod times;

pub use built::{Built, build as build_with};

use crate::program::cargo;
use crate::{blender, display, mutate, python, vulkan, web};
use std::process::{Command, ExitCode, Stdio};
use times::{Scope, Times};

/// All code is built in one profile, and all of a scope at once: two commands would give what they share other features,
/// and compile it twice.
const PROFILE: [&str; 2] = ["--profile", "quick"];
const ALL: [&str; 1] = ["--workspace"];
/// The engine, its files and its program.
pub const CORE: [&str; 9] = [
    "--workspace",
    "--exclude",
    "bevy_taffeta",
    "--exclude",
    "taffeta-papers",
    "--exclude",
    "taffeta-py",
    "--exclude",
    "taffeta-web",
];

/// What is tested, and the seed of the sample of planted faults.
#[derive(Debug, PartialEq)]
struct Choice<'a> {
    core: bool,
    seed: Option<&'a str>,
}

fn parse<'a>(words: &[&'a str]) -> Result<Choice<'a>, String> {
    let (core, rest) = match words {
        ["--core", rest @ ..] => (true, rest),
        rest => (false, rest),
    };
    match rest {
        [] => Ok(Choice { core, seed: None }),
        ["--seed", seed] => Ok(Choice { core, seed: Some(seed) }),
        _ => Err(format!("test {}: it takes [--core] [--seed SEED]", words.join(" "))),
    }
}

/// Runs all checks; the first that fails ends the run.
pub fn run(words: &[&str]) -> ExitCode {
    let result = parse(words).and_then(|choice| {
        let mut times = Times::start(if choice.core { Scope::Core } else { Scope::All });
        let result = all(&choice, &mut times);
        println!("{times}");
        result
    });
    match result {
        Ok(()) => {
            println!("xtask: all passed");
            ExitCode::SUCCESS
        }
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

fn all(choice: &Choice, times: &mut Times) -> Result<(), String> {
    let packages = if choice.core { &CORE[..] } else { &ALL[..] };
    let with = |words: &[&'static str]| [words, &PROFILE[..], packages].concat();
    vulkan::provide()?;
    if !choice.core {
        display::provide()?;
    }
    times.part("formatting", formatting)?;
    if !built::has_linter() {
        println!("xtask: clippy: skipped, not installed (`rustup component add clippy`)");
    }
    let built = times.part("lints and compiling", || build(packages))?;
    times.from_nothing = built.from_nothing;
    for program in &built.programs {
        times.part(&program.name(), || passes(&program.name(), program.command()))?;
    }
    if !choice.core {
        times.part("python, web and blender", || {
            let wheel = python::packed(&built)?;
            let other = || web::test(&built).and_then(|()| blender::test(&built, &wheel));
            beside(|| python::test(&built, &wheel), other)
        })?;
    }
    times.part("planted faults", || mutate::sample(&built, choice.seed))?;
    times.part("documentation", || passes("documentation", built::linting(&with(&["test", "--doc"]))))
}

/// Does two works at once that need one core each. Each ends by itself, whatever the other comes to.
fn beside(
    one: impl FnOnce() -> Result<(), String>,
    other: impl FnOnce() -> Result<(), String> + Send,
) -> Result<(), String> {
    let (one, other) = std::thread::scope(|scope| {
        let other = scope.spawn(other);
        (one(), other.join().unwrap_or_else(|_| Err("it panicked".to_owned())))
    });
    one.and(other)
}

/// Builds all programs of tests of these packages.
pub fn build(packages: &[&str]) -> Result<Built, String> {
    built::build(&[&["test", "--no-run"], &PROFILE[..], packages].concat())
}

/// Whether rustfmt has nothing to change; skipped where it is not installed, and said.
fn formatting() -> Result<(), String> {
    let probe = cargo(&["fmt", "--version"]).stdout(Stdio::null()).stderr(Stdio::null()).status();
    if probe.is_ok_and(|status| status.success()) {
        return passes("rustfmt", cargo(&["fmt", "--all", "--check"]));
    }
    println!("xtask: rustfmt: skipped, not installed (`rustup component add rustfmt`)");
    Ok(())
}

fn passes(name: &str, mut command: Command) -> Result<(), String> {
    let status =
        vulkan::quiet(&mut command).status().map_err(|error| format!("{name}: cannot start: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("{name}: failed ({status})")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tests_are_chosen_by_words() {
        assert_eq!(parse(&[]), Ok(Choice { core: false, seed: None }));
        assert_eq!(parse(&["--core"]), Ok(Choice { core: true, seed: None }));
        assert_eq!(parse(&["--core", "--seed", "a"]), Ok(Choice { core: true, seed: Some("a") }));
        assert!(parse(&["--seed"]).is_err() && parse(&["core"]).is_err());
    }
}
