//! `cargo xtask`: the project's own chores.
//!
//! `cargo xtask test` (or `ci`) runs every check that needs no special hardware; `cargo xtask models` fetches the
//! real models that scenes name.

mod apt;
mod constraints;
mod contact;
mod display;
mod fuzz;
mod gallery;
mod gpu;
mod lines;
mod mesh;
mod methods;
mod models;
mod pictures;
mod program;
mod results;
mod test;
mod volume;
mod vulkan;

use std::process::ExitCode;

const USAGE: &str =
    "usage: cargo xtask test | ci | models | pictures [SCENE...] | gallery [NAME...]
                   | results [--frames F | --plots-only]
                   | volume [NAME...] [--speed-only | --plots-only] | constraints [NAME...] [--plots-only]
                   | contact [--software | --page-only] | methods [--quick] [SIZE...] | methods --plots-only
                   | gpu [--merge FILE.json] | fuzz [--minutes N] [TARGET...]
  test, ci   formatting, lints, tests, and every scene for 10 frames on the CPU and on a GPU, in software if need be
  models     fetch the bunny, armadillo, dragon and human into models/
  pictures   run scenes and draw them into docs/pictures/
  gallery    draw the pictures at the top of the README with taffeta-view, for which Bevy is built
  results    measure speed, and write the tables and plots of docs/results/
  volume     run the experiments on kept volumes, and write their page and plots in docs/results/
  constraints
             run the experiments on springs as constraints, and write their page, plots and pictures in docs/results/
  contact    measure contact of nodes with each other in several sizes, and write its page in docs/results/
  methods    compare explicit and implicit springs at equal error, and write the page and plot in docs/results/
  gpu        build what to take to a machine with a GPU, or write the page of what it brought back
  fuzz       feed the parsers hostile input, 60 minutes each; needs a nightly compiler and cargo-fuzz";

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        ["test" | "ci"] => test::run(),
        ["models"] => models::run(),
        ["gpu", ref words @ ..] => gpu::run(words),
        ["fuzz", ref words @ ..] => fuzz::run(words),
        ["volume", ref words @ ..] => volume::run(words),
        ["constraints", ref words @ ..] => constraints::run(words),
        ["contact", ref words @ ..] => contact::run(words),
        ["methods", ref words @ ..] => methods::run(words),
        ["results", ref words @ ..] => results::run(words),
        ["gallery", ref names @ ..] => gallery::run(names),
        ["pictures", ref scenes @ ..] => pictures::run(scenes),
        ["help" | "--help" | "-h"] => {
            println!("{USAGE}");
            ExitCode::SUCCESS
        }
        _ => {
            eprintln!("{USAGE}");
            ExitCode::from(2)
        }
    }
}

/// The repository's root: the folder above this crate.
fn root() -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}
