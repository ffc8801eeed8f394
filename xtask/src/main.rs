//! `cargo xtask`: the project's own chores.
//!
//! `cargo xtask test` (or `ci`) runs every check that needs no special hardware; `cargo xtask models` fetches the
//! real models that scenes name.

mod apt;
mod display;
mod fuzz;
mod gpu;
mod models;
mod program;
mod test;
mod vulkan;

use std::process::ExitCode;

const USAGE: &str =
    "usage: cargo xtask test | ci | models | gpu [--merge FILE.json] | fuzz [--minutes N] [TARGET...]
  test, ci   formatting, lints, tests, and every scene for 10 frames on the CPU and on a GPU, in software if need be
  models     fetch the bunny, armadillo, dragon and human into models/
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
