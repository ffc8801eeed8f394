//! `cargo xtask results`: measures the program's speed, keeps each line, and writes tables and plots of them.

mod line;
mod measure;
mod plot;
mod table;

use crate::root;
use line::Line;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Runs all benches, or with `--plots-only` none; `--frames F` times fewer frames.
pub fn run(words: &[&str]) -> ExitCode {
    match arguments(words).and_then(|frames| results(frames.as_ref())) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

/// What to measure; `None`: nothing.
struct Wanted {
    /// Frames a bench; `None`: as many as the bench itself chooses.
    frames: Option<u32>,
}

fn arguments(words: &[&str]) -> Result<Option<Wanted>, String> {
    match words {
        [] => Ok(Some(Wanted { frames: None })),
        ["--plots-only"] => Ok(None),
        ["--frames", count] => match count.parse() {
            Ok(frames) if frames > 0 => Ok(Some(Wanted { frames: Some(frames) })),
            _ => Err(format!("--frames {count}: a number of frames from 1 would do")),
        },
        _ => Err(format!("results {}: it takes --frames F, or --plots-only", words.join(" "))),
    }
}

fn results(wanted: Option<&Wanted>) -> Result<(), String> {
    let folder = root().join("docs/results");
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    if let Some(wanted) = wanted {
        measure::all(&folder, wanted.frames)?;
    }
    let mut devices = Vec::new();
    for file in measured(&folder)? {
        let slug = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let lines = line::latest(&file)?;
        plot::nodes(&folder.join(format!("{slug}-nodes.svg")), &lines)?;
        plot::threads(&folder.join(format!("{slug}-threads.svg")), &lines)?;
        devices.push((slug, lines));
    }
    if devices.is_empty() {
        return Err(format!("{}: nothing measured yet; `cargo xtask results` measures", folder.display()));
    }
    let readme = folder.join("README.md");
    std::fs::write(&readme, table::readme(&devices)).map_err(|error| format!("{}: {error}", readme.display()))
}

/// The files of measured lines, one a device.
fn measured(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let entries = std::fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let paths = entries.filter_map(|entry| entry.ok().map(|entry| entry.path()));
    let mut files: Vec<PathBuf> =
        paths.filter(|path| path.extension().is_some_and(|ext| ext == "jsonl")).collect();
    files.sort();
    Ok(files)
}
