//! `cargo xtask fuzz`: feeds each parser what it was not made for, for as long as you like.

use crate::root;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};

/// Time for each target, if none is given [min].
const MINUTES: u64 = 60;

/// Runs the targets that `words` name, or all: `[--minutes N] [TARGET...]`.
pub fn run(words: &[&str]) -> ExitCode {
    let result = parse(words).and_then(|(minutes, targets)| {
        check_tools()?;
        targets.iter().try_for_each(|target| fuzz(target, minutes))
    });
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

fn parse(words: &[&str]) -> Result<(u64, Vec<String>), String> {
    let (minutes, names) = match words {
        ["--minutes", minutes, names @ ..] => {
            let refuse = || format!("`{minutes}` minutes; a whole number from 1 on would do");
            // None would be without end to the fuzzer.
            (minutes.parse().ok().filter(|&minutes| minutes > 0).ok_or_else(refuse)?, names)
        }
        names => (MINUTES, names),
    };
    let all = targets()?;
    if let Some(odd) = names.iter().find(|name| !all.iter().any(|target| target == *name)) {
        return Err(format!("there is no fuzz target `{odd}`; {} would do", all.join(", ")));
    }
    let chosen = if names.is_empty() { all } else { names.iter().map(ToString::to_string).collect() };
    Ok((minutes, chosen))
}

/// The names of the files in `fuzz/fuzz_targets`.
fn targets() -> Result<Vec<String>, String> {
    let folder = root().join("fuzz/fuzz_targets");
    let entries = std::fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let stem = |path: &Path| path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let mut names: Vec<String> = entries.filter_map(|entry| stem(&entry.ok()?.path())).collect();
    names.sort();
    Ok(names)
}

fn nightly(words: &[&str]) -> Command {
    let mut command = Command::new("rustup");
    command.args(["run", "nightly", "cargo"]).args(words).current_dir(root());
    command
}

fn check_tools() -> Result<(), String> {
    let works = |words: &[&str]| {
        let status = nightly(words).stdout(Stdio::null()).stderr(Stdio::null()).status();
        status.is_ok_and(|status| status.success())
    };
    if !works(&["--version"]) {
        return Err("fuzzing needs a nightly compiler: `rustup toolchain install nightly`".into());
    }
    if !works(&["fuzz", "--version"]) {
        return Err("fuzzing needs cargo-fuzz: `cargo install cargo-fuzz --version 0.13.2`".into());
    }
    Ok(())
}

fn fuzz(target: &str, minutes: u64) -> Result<(), String> {
    println!("xtask: fuzz {target} for {minutes} min");
    // What the fuzzer adds goes to the first folder, which is not kept; the corpus is made by hand.
    let grown = format!("fuzz/grown/{target}");
    std::fs::create_dir_all(root().join(&grown)).map_err(|error| format!("{grown}: {error}"))?;
    let time = format!("-max_total_time={}", 60 * minutes);
    let mut command = nightly(&["fuzz", "run", target, &grown, &format!("fuzz/corpus/{target}"), "--"]);
    command.args(["-rss_limit_mb=512", "-timeout=5", &time]);
    // The sanitizer keeps freed memory for a while; that must not count as the program's.
    command.env("ASAN_OPTIONS", "quarantine_size_mb=16");
    let status = command.status().map_err(|error| format!("fuzz {target}: cannot start: {error}"))?;
    if status.success() {
        return Ok(());
    }
    Err(format!(
        "fuzz {target}: failed; the input is in fuzz/artifacts/{target}, keep it in fuzz/corpus/{target}"
    ))
}
