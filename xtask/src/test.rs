//! `cargo xtask test`: formatting, lints, tests, and every scene for a few frames, each with its time.

use crate::root;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

/// Runs all checks; the first that fails ends the run.
pub fn run() -> ExitCode {
    let start = Instant::now();
    let lints = ["clippy", "--workspace", "--release", "--all-targets", "--", "-D", "warnings"];
    let result = component("rustfmt", &["fmt", "--all", "--check"])
        .and_then(|()| component("clippy", &lints))
        .and_then(|()| timed("tests", cargo(&["test", "--release", "--workspace"])))
        .and_then(|()| timed("build", cargo(&["build", "--release", "--package", "taffeta-cli"])))
        .and_then(|()| scenes());
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

fn cargo(words: &[&str]) -> Command {
    // Cargo sets CARGO for what it runs; the name alone serves when the binary is started by hand.
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(words).current_dir(root());
    command
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
    let status = command.status().map_err(|error| format!("{name}: cannot start: {error}"))?;
    if !status.success() {
        return Err(format!("{name}: failed ({status})"));
    }
    println!("xtask: {name}: passed in {:.1} s", start.elapsed().as_secs_f64());
    Ok(())
}

/// Runs every scene for 10 frames with the built program.
fn scenes() -> Result<(), String> {
    let out = std::env::temp_dir().join(format!("taffeta-scenes-{}", std::process::id()));
    let result = scene_files()?.iter().try_for_each(|scene| {
        let name = scene.file_stem().unwrap_or_default().to_string_lossy();
        timed(&format!("scene {name}"), run_scene(scene, &out.join(&*name)))
    });
    // What is left behind in the temporary folder does no harm; the scenes' verdict counts.
    let _ = std::fs::remove_dir_all(&out);
    result
}

fn run_scene(scene: &Path, out: &Path) -> Command {
    let mut command = Command::new(program());
    command.arg("run").arg(scene).arg("--out").arg(out);
    command.args(["--frames", "10", "--quiet"]).current_dir(root());
    command
}

fn scene_files() -> Result<Vec<PathBuf>, String> {
    let folder = root().join("scenes");
    let entries = std::fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut files: Vec<PathBuf> = entries
        .filter_map(|entry| entry.ok().map(|entry| entry.path()))
        .filter(|path| path.extension().is_some_and(|ext| ext == "toml"))
        .collect();
    files.sort();
    if files.is_empty() {
        return Err(format!("{}: no scenes", folder.display()));
    }
    Ok(files)
}

/// The built `taffeta`, where cargo puts it.
fn program() -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| "target".into(), PathBuf::from);
    root().join(target).join("release").join(format!("taffeta{}", std::env::consts::EXE_SUFFIX))
}
