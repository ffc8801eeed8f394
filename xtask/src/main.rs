//! `cargo xtask`: the project's own chores.
//!
//! `cargo xtask test` runs every check that needs no special hardware; `cargo xtask models` fetches the
//! real models that scenes name.

mod apt;
mod attack;
mod blender;
mod display;
mod faults;
mod fuzz;
mod gpu;
mod models;
mod mutate;
mod program;
mod python;
mod sanitize;
mod shaders;
mod speeds;
mod test;
mod vulkan;
mod web;

use std::process::ExitCode;

const USAGE: &str =
    "usage: cargo xtask test [--core] [--seed SEED] | mutate [--all | --sample N [--seed SEED]] | models
                    | gpu [--merge FILE.json] | fuzz [--minutes N] [TARGET...]
                    | attack [--scenes N] [--first SEED] [--program FILE] | sanitize [thread | miri]
                    | faults [--program FILE] | shaders | speeds [--program FILE] | python | wheel
                    | web [--serve] | blender [--test]
  test       formatting, lints, all tests, and 20 planted faults that the seed draws (the commit's hash if there is none);
             --core leaves out Bevy, the papers, Python, Blender and the web. A GPU is needed, in software if need be
  mutate     plants faults in the sources of kernels and sees that the parity tests find them: all, or a sample
  models     fetch the bunny, armadillo, dragon and human into models/
  gpu        build what to take to a machine with a GPU, or write the page of what it brought back
  fuzz       feed the parsers hostile input, 60 minutes each; needs a nightly compiler and cargo-fuzz
  attack     run scenes that are made up at random, 10,000 of them, and look for panics, hangs and numbers that are none
  sanitize   run tests under ThreadSanitizer and Miri; needs a nightly compiler with rust-src and miri
  faults     have each call for results fail once, and see that runs go on from there, as from what power failures
             leave on the disk and from too little memory; needs strace
  shaders    write the page of what Mesa's compiler for AMD makes of every kernel; no GPU is needed
  speeds     run all benches and write the page of what they print, some five minutes on an idle machine
  python     build and test the Python package alone; Python of 3.10 or newer is needed, and pip
  wheel      build the Python package for this machine into target/wheels, with pip's maturin
  blender    build the Blender extension into target/blender; --test tests it in Blender's module, with Python 3.11
  web        build the npm package and its page into target/web; --serve shows the page. Node 20 is needed";

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        ["test", ref words @ ..] => test::run(words),
        ["mutate", ref words @ ..] => mutate::run(words),
        ["models"] => models::run(),
        ["gpu", ref words @ ..] => gpu::run(words),
        ["fuzz", ref words @ ..] => fuzz::run(words),
        ["attack", ref words @ ..] => attack::run(words),
        ["faults", ref words @ ..] => faults::run(words),
        ["sanitize", ref words @ ..] => sanitize::run(words),
        ["shaders"] => shaders::run(),
        ["speeds", ref words @ ..] => speeds::run(words),
        ["python"] => python::run(),
        ["wheel"] => python::wheel(),
        ["blender", ref words @ ..] => blender::run(words),
        ["web", ref words @ ..] => web::run(words),
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
