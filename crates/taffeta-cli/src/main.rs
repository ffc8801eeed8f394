//! The program `taffeta`: runs, checks and measures scenes. It converts and calls; there is no physics in it.

mod bench;
mod check;
mod console;
mod gpu;
mod gpu_check;
mod info;
mod intersections;
mod limits;
mod materials;
mod memory;
mod reproduce;
mod run;
mod schema;
mod summary;
mod validate;

use clap::{Parser, Subcommand};
use std::process::ExitCode;
use taffeta_io::program;

/// Real-time cloth and soft bodies.
#[derive(Parser)]
#[command(name = "taffeta", version, about, max_term_width = 110)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Run(run::Args),
    Check(check::Args),
    Bench(bench::Args),
    GpuCheck(gpu_check::Args),
    Reproduce(reproduce::Args),
    Info(info::Args),
    Schema(schema::Args),
    Materials(materials::Args),
    Validate(validate::Args),
}

fn main() -> ExitCode {
    // SAFETY: the program has started no thread yet.
    unsafe { program::expect_no_desktop() };
    program::end(match Cli::parse().command {
        Command::Run(args) => run::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::GpuCheck(args) => gpu_check::run(&args),
        Command::Reproduce(args) => reproduce::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Schema(args) => schema::run(&args),
        Command::Materials(args) => materials::run(&args),
        Command::Validate(args) => validate::run(&args),
    })
}
