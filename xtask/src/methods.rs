//! `cargo xtask methods`: runs a swinging sheet in several sizes and stiffnesses by explicit and implicit springs, in longer and
//! shorter steps, compares each run with a reference, and draws error against time.

mod cell;
mod cloth;
mod page;
mod plot;
mod reference;
mod run;
mod way;

use crate::lines::{self, Line};
use crate::{program, results, root};
use cell::{Cell, QUICK, SIZES, Size};
use run::Run;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Runs all sizes or those that are named; with `--quick` small ones for a short time, kept apart; with `--references-only` just
/// what they are compared with, which a busy machine may do as well; with `--plots-only` nothing: it draws what was kept.
pub fn run(words: &[&str]) -> ExitCode {
    match wanted(words).and_then(|wanted| methods(&wanted)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

/// What is to be run.
#[derive(Debug, PartialEq)]
struct Wanted {
    sizes: Vec<Size>,
    what: What,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum What {
    All,
    Quick,
    References,
}

fn wanted(words: &[&str]) -> Result<Wanted, String> {
    let (options, names): (Vec<&str>, Vec<&str>) = words.iter().partition(|word| word.starts_with("--"));
    let (known, what): (&[Size], What) = match options[..] {
        [] => (&SIZES, What::All),
        ["--quick"] => (&QUICK, What::Quick),
        ["--references-only"] => (&SIZES, What::References),
        ["--plots-only"] if names.is_empty() => return Ok(Wanted { sizes: Vec::new(), what: What::All }),
        _ => {
            return Err(format!(
                "methods {}: it takes sizes, alone or with --quick or --references-only; or --plots-only alone",
                words.join(" ")
            ));
        }
    };
    let sizes = if names.is_empty() { known.to_vec() } else { named(known, &names)? };
    Ok(Wanted { sizes, what })
}

fn named(sizes: &[Size], names: &[&str]) -> Result<Vec<Size>, String> {
    let known: Vec<&str> = sizes.iter().map(|size| size.name).collect();
    if let Some(name) = names.iter().find(|name| !known.contains(name)) {
        return Err(format!("there is no size `{name}`; there are: {}", known.join(", ")));
    }
    Ok(sizes.iter().filter(|size| names.contains(&size.name)).copied().collect())
}

fn methods(wanted: &Wanted) -> Result<(), String> {
    let cells = cell::cells(&wanted.sizes);
    if wanted.what == What::References {
        let keep = |cell: &Cell| cloth::fewest_steps(cell).and_then(|fewest| reference::of(cell, fewest));
        return cells.iter().try_for_each(|cell| keep(cell).map(|_| ()));
    }
    let quick = wanted.what == What::Quick;
    let results = root().join("docs/results");
    let page = if quick { program::target().join("methods/quick") } else { results.clone() };
    let folder = page.join("methods");
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let commit = program::commit()?;
    cells.iter().try_for_each(|cell| measure(cell, &folder, &commit))?;
    write(&folder, &page.join("methods.md"))?;
    if quick { Ok(()) } else { results::write_readme(&results) }
}

/// Runs a cell in all ways, and keeps a line of each run.
fn measure(cell: &Cell, folder: &Path, commit: &str) -> Result<(), String> {
    let fewest = cloth::fewest_steps(cell)?;
    let reference = reference::of(cell, fewest)?;
    forget(cell, folder)?;
    for (way, steps) in cell.plan(fewest) {
        let run = run::run(cell, way, steps, &reference, commit)?;
        println!("{}", run.words());
        lines::keep(folder, &run)?;
    }
    Ok(())
}

/// Drops what was kept of a cell: what was another plan once is not to stand beside what is run now.
fn forget(cell: &Cell, folder: &Path) -> Result<(), String> {
    let file = folder.join(Run::FILE);
    if !file.is_file() {
        return Ok(());
    }
    let mut runs: Vec<Run> = lines::kept(folder)?;
    runs.retain(|run| (run.side, run.k) != (cell.size.side, cell.k));
    std::fs::remove_file(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    runs.iter().try_for_each(|run| lines::keep(folder, run))
}

/// Draws the runs that were kept, and writes their page.
fn write(folder: &Path, page: &PathBuf) -> Result<(), String> {
    let mut runs: Vec<Run> = if folder.join(Run::FILE).is_file() { lines::kept(folder)? } else { Vec::new() };
    runs.sort_by_key(Run::key);
    if runs.is_empty() {
        return Err(format!("{}: nothing measured yet; `cargo xtask methods` measures", folder.display()));
    }
    plot::draw(&folder.join("error-by-time.svg"), &runs)?;
    std::fs::write(page, page::page(&runs)).map_err(|error| format!("{}: {error}", page.display()))?;
    println!("{}", page.display());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_chosen_by_name_and_unknown_ones_are_answered_with_those_that_there_are() {
        let sides = |words: &[&str]| {
            wanted(words).map(|wanted| wanted.sizes.iter().map(|size| size.side).collect::<Vec<_>>())
        };
        assert_eq!(sides(&[]), Ok(vec![32, 100, 316, 1000]));
        assert_eq!(sides(&["1M", "1k"]), Ok(vec![32, 1000]));
        assert_eq!(sides(&["--plots-only"]), Ok(Vec::new()));
        assert_eq!(wanted(&["--quick"]), Ok(Wanted { sizes: QUICK.to_vec(), what: What::Quick }));
        let references = wanted(&["100k", "--references-only"]);
        assert_eq!(references, Ok(Wanted { sizes: vec![SIZES[2]], what: What::References }));
        let error = wanted(&["--quick", "1M"]).err().unwrap_or_default();
        assert_eq!(error, "there is no size `1M`; there are: 1k, 10k");
        assert!(wanted(&["--plots-only", "1k"]).is_err() && wanted(&["--fast"]).is_err());
    }
}
