//! `cargo xtask constraints`: runs the figures of Va, Choi and Hong 2021 on springs as constraints, and experiments of our own,
//! keeps their curves, draws them and the cloth, and writes their page in docs/results/.

mod curve;
mod experiment;
mod page;
mod plot;
mod run;
mod speed;

use crate::lines::{self, Line};
use crate::{program, results, root};
use experiment::{Experiment, Variant};
use speed::Timing;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Runs what is named, or all; with `--plots-only` nothing: it draws what was kept.
pub fn run(words: &[&str]) -> ExitCode {
    let result = wanted(words).and_then(|wanted| measure(&wanted)).and_then(|()| write());
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

/// What is to be measured.
#[derive(Default)]
struct Wanted {
    experiments: Vec<Experiment>,
    timings: Vec<Timing>,
    sizes: bool,
}

/// The name of the cost by size.
const SIZES: &str = "sizes";

fn wanted(words: &[&str]) -> Result<Wanted, String> {
    let (options, names): (Vec<&str>, Vec<&str>) = words.iter().partition(|word| word.starts_with("--"));
    let (mut experiments, mut timings) = (experiment::all(), speed::all());
    match options[..] {
        [] if names.is_empty() => return Ok(Wanted { experiments, timings, sizes: true }),
        [] => {}
        ["--plots-only"] if names.is_empty() => return Ok(Wanted::default()),
        _ => {
            return Err(format!(
                "constraints {}: it takes names of experiments, or --plots-only alone",
                words.join(" ")
            ));
        }
    }
    let mut known: Vec<&str> = experiments.iter().map(|experiment| experiment.name).collect();
    known.extend(timings.iter().map(|timing| timing.name));
    known.push(SIZES);
    known.dedup();
    if let Some(name) = names.iter().find(|name| !known.contains(name)) {
        return Err(format!("there is no experiment `{name}`; there are: {}", known.join(", ")));
    }
    experiments.retain(|experiment| names.contains(&experiment.name));
    timings.retain(|timing| names.contains(&timing.name));
    Ok(Wanted { experiments, timings, sizes: names.contains(&SIZES) })
}

fn measure(wanted: &Wanted) -> Result<(), String> {
    let folder = folder();
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let commit = program::commit()?;
    for experiment in &wanted.experiments {
        for variant in &experiment.variants {
            let done = run::run(experiment, variant, &commit)?;
            println!("{}", done.run.words());
            curve::write(&file(&folder, experiment, variant, "csv"), &done.curve)?;
            if let Some(strip) = &done.strip {
                let file = file(&folder, experiment, variant, "png");
                std::fs::write(&file, strip.png()?)
                    .map_err(|error| format!("{}: {error}", file.display()))?;
            }
            lines::keep(&folder, &done.run)?;
        }
    }
    for timing in &wanted.timings {
        for threads in speed::threads() {
            let speed = speed::measure(timing, threads, &commit)?;
            println!("{}", speed.words());
            lines::keep(&folder, &speed)?;
        }
    }
    if wanted.sizes { speed::sizes(&folder, &commit) } else { Ok(()) }
}

/// Draws the curves that were kept, and writes the page, and the link to it.
fn write() -> Result<(), String> {
    let folder = folder();
    let all = experiment::all();
    for experiment in &all {
        let curves = experiment.variants.iter().map(|variant| {
            let file = file(&folder, experiment, variant, "csv");
            file.is_file().then(|| curve::read(&file)).transpose()
        });
        let curves: Vec<_> = curves.collect::<Result<_, String>>()?;
        if curves.iter().any(Option::is_some) {
            plot::draw(&folder.join(experiment.name).with_extension("svg"), experiment, &curves)?;
        }
    }
    let results = root().join("docs/results");
    let page = results.join("constraints.md");
    let text = page::page(&all, &kept(&folder)?, &kept(&folder)?, &kept(&folder)?);
    std::fs::write(&page, text).map_err(|error| format!("{}: {error}", page.display()))?;
    results::write_readme(&results)
}

/// The lines that were kept, if any were.
fn kept<L: Line>(folder: &Path) -> Result<Vec<L>, String> {
    if folder.join(L::FILE).is_file() { lines::kept(folder) } else { Ok(Vec::new()) }
}

fn folder() -> PathBuf {
    root().join("docs/results/constraints")
}

/// A file of one run.
fn file(folder: &Path, experiment: &Experiment, variant: &Variant, ending: &str) -> PathBuf {
    folder.join(format!("{}-{}.{ending}", experiment.name, variant.slug))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_choose_and_unknown_ones_are_answered_with_those_that_there_are() {
        let some = wanted(&["fig15", "fig9"]).unwrap_or_default();
        assert!(some.experiments.iter().all(|experiment| experiment.name == "fig15"));
        assert!(some.timings.iter().all(|timing| timing.name == "fig9"));
        assert!(!some.experiments.is_empty() && !some.timings.is_empty() && !some.sizes);
        let error = wanted(&["fig99"]).err().unwrap_or_default();
        assert!(error.starts_with("there is no experiment `fig99`; there are: fig11, fig12"), "{error}");
        assert!(wanted(&["--plots-only", "fig15"]).is_err() && wanted(&["--fast"]).is_err());
        assert!(wanted(&["--plots-only"]).is_ok_and(|none| none.experiments.is_empty() && !none.sizes));
        assert!(wanted(&[]).is_ok_and(|all| all.sizes && all.timings.len() > 3));
    }
}
