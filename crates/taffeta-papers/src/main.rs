//! The program `taffeta-papers`.

use clap::{Parser, Subcommand};
use std::process::ExitCode;
use taffeta_io::program;
use taffeta_papers::papers::paper::Paper;
use taffeta_papers::{errata, reproduce};

/// Three papers on cloth and soft bodies, beside what taffeta does.
#[derive(Parser)]
#[command(name = "taffeta-papers", version, about, max_term_width = 110)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Report on S1: cloth, by springs and by constraints
    S1(reproduce::Args),
    /// Report on S2: cloth that touches itself
    S2(reproduce::Args),
    /// Report on S3: bodies that keep their volume
    S3(reproduce::Args),
    /// Report on all three, the methods at equal error, the papers' limits and errata
    All(reproduce::Args),
    /// Write docs/errata.md again
    Errata,
}

fn main() -> ExitCode {
    // SAFETY: the program has started no thread yet.
    unsafe { program::expect_no_desktop() };
    program::end(match Cli::parse().command {
        Command::S1(args) => reproduce::run(&args, &[Paper::S1]),
        Command::S2(args) => reproduce::run(&args, &[Paper::S2]),
        Command::S3(args) => reproduce::run(&args, &[Paper::S3]),
        Command::All(args) => reproduce::run(&args, &Paper::ALL),
        Command::Errata => errata::write(),
    })
}
