//! `cargo xtask results`: measures the program's speed, keeps each line, and writes tables and plots of them.

mod line;
pub mod measure;
pub mod plot;
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
    for file in files(&folder, "jsonl")? {
        let slug = slug_of(&file);
        let lines = line::latest(&file)?;
        plot::nodes(&folder.join(format!("{slug}-nodes.svg")), &lines)?;
        plot::threads(&folder.join(format!("{slug}-threads.svg")), &lines)?;
    }
    write_readme(&folder)
}

/// Writes the page of all devices: processors with their tables, and where the pages of GPUs are.
pub fn write_readme(folder: &Path) -> Result<(), String> {
    let mut processors = Vec::new();
    for file in files(folder, "jsonl")? {
        processors.push((slug_of(&file), line::latest(&file)?));
    }
    let mut gpus = Vec::new();
    for file in files(folder, "json")? {
        gpus.push((slug_of(&file), crate::gpu::device_of(&file)?));
    }
    if processors.is_empty() && gpus.is_empty() {
        return Err(format!("{}: nothing measured yet; `cargo xtask results` measures", folder.display()));
    }
    let readme = folder.join("README.md");
    std::fs::write(
        &readme,
        table::readme(
            &processors,
            &gpus,
            &table::PAGES.into_iter().filter(|(file, _)| folder.join(file).is_file()).collect::<Vec<_>>(),
        ),
    )
    .map_err(|error| format!("{}: {error}", readme.display()))
}

fn slug_of(file: &Path) -> String {
    file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// The files with an ending, one a device.
fn files(folder: &Path, ending: &str) -> Result<Vec<PathBuf>, String> {
    let entries = std::fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let paths = entries.filter_map(|entry| entry.ok().map(|entry| entry.path()));
    let mut files: Vec<PathBuf> =
        paths.filter(|path| path.extension().is_some_and(|ext| ext == ending)).collect();
    files.sort();
    Ok(files)
}
