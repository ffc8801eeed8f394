//! `cargo xtask`: the project's own chores.
//!
//! `cargo xtask test` (or `ci`) runs every check that needs no special hardware; `cargo xtask models` fetches the
//! real models that scenes name.

mod fuzz;
mod mesh;
mod models;
mod pictures;
mod results;
mod test;

use std::process::ExitCode;

const USAGE: &str =
    "usage: cargo xtask test | ci | models | pictures [SCENE...] | results [--frames F | --plots-only]
                   | fuzz [--minutes N] [TARGET...]
  test, ci   formatting, lints, tests, and every scene for 10 frames
  models     fetch the bunny, armadillo, dragon and human into models/
  pictures   run scenes and draw them into docs/pictures/
  results    measure speed, and write the tables and plots of docs/results/
  fuzz       feed the parsers hostile input, 60 minutes each; needs a nightly compiler and cargo-fuzz";

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        ["test" | "ci"] => test::run(),
        ["models"] => models::run(),
        ["fuzz", ref words @ ..] => fuzz::run(words),
        ["results", ref words @ ..] => results::run(words),
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
