//! `cargo xtask volume`: runs the experiments of Va, Choi and Hong 2023 and our own with each form of keeping volumes,
//! keeps their curves, and writes the page and the plots of docs/results/.

mod curve;
mod experiment;
mod page;
mod plot;
mod run;
mod speed;

use crate::{lines, program, results, root};
use curve::Curve;
use experiment::{ALL, Experiment};
use std::path::Path;
use std::process::ExitCode;

/// Runs the named experiments, or all; with `--speed-only` only their timing, with `--plots-only` none: it draws what was
/// kept.
pub fn run(words: &[&str]) -> ExitCode {
    let (options, names): (Vec<&str>, Vec<&str>) = words.iter().partition(|word| word.starts_with("--"));
    let result = match options[..] {
        [] => chosen(&names).and_then(|chosen| measure(&chosen, &[losses, speeds])).and_then(|()| write()),
        ["--speed-only"] => {
            chosen(&names).and_then(|chosen| measure(&chosen, &[speeds])).and_then(|()| write())
        }
        ["--plots-only"] if names.is_empty() => write(),
        _ => Err(format!(
            "volume {}: it takes names of experiments and --speed-only, or --plots-only alone",
            words.join(" ")
        )),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

fn chosen(names: &[&str]) -> Result<Vec<&'static Experiment>, String> {
    if names.is_empty() {
        return Ok(ALL.iter().collect());
    }
    let find = |name: &&str| {
        let all = || ALL.iter().map(|experiment| experiment.scene).collect::<Vec<_>>().join(", ");
        ALL.iter()
            .find(|experiment| experiment.scene == *name)
            .ok_or_else(|| format!("there is no experiment `{name}`; there are: {}", all()))
    };
    names.iter().map(find).collect()
}

/// A part of what is measured of an experiment; the folder takes its lines.
type Part = fn(&Experiment, folder: &Path, commit: &str) -> Result<(), String>;

/// Measures parts of experiments.
fn measure(chosen: &[&Experiment], parts: &[Part]) -> Result<(), String> {
    let folder = root().join("docs/results/volume");
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let commit = program::commit()?;
    chosen
        .iter()
        .try_for_each(|experiment| parts.iter().try_for_each(|part| part(experiment, &folder, &commit)))
}

/// Runs an experiment in all its variants, and keeps their curves and lines.
fn losses(experiment: &Experiment, folder: &Path, commit: &str) -> Result<(), String> {
    let (mut curves, mut goals) = (Vec::new(), run::Goals::new());
    for variant in experiment.variants() {
        let (curve, run) = run::run(experiment, &variant, &mut goals, commit)?;
        println!("{}", run.words());
        lines::keep(folder, &run)?;
        if variant.k.is_none() {
            curves.push(curve);
        }
    }
    curve::write(&csv(folder, experiment), &curves)
}

/// Times the bodies of an experiment on one thread and on all.
fn speeds(experiment: &Experiment, folder: &Path, commit: &str) -> Result<(), String> {
    for threads in [1, all_threads()] {
        let speed = speed::measure(experiment, threads, commit)?;
        println!("{}", speed.words());
        lines::keep(folder, &speed)?;
    }
    Ok(())
}

/// Draws the curves that were kept, and writes the page, and the link to it.
fn write() -> Result<(), String> {
    let results = root().join("docs/results");
    let folder = results.join("volume");
    let (runs, speeds) = (lines::kept(&folder)?, lines::kept(&folder)?);
    for experiment in &ALL {
        let file = csv(&folder, experiment);
        if file.is_file() {
            let curves: Vec<Curve> = curve::read(&file)?;
            plot::draw(&file.with_extension("svg"), experiment, &curves)?;
        }
    }
    let page = results.join("volume.md");
    std::fs::write(&page, page::page(&runs, &speeds))
        .map_err(|error| format!("{}: {error}", page.display()))?;
    results::write_readme(&results)
}

/// Those of the machine.
fn all_threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

fn csv(folder: &Path, experiment: &Experiment) -> std::path::PathBuf {
    folder.join(experiment.scene).with_extension("csv")
}
