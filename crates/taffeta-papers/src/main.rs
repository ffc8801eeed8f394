//! The program `taffeta-papers`: the experiments of three papers, run with taffeta, as a report that has what they print beside
//! what comes out here.
//!
//! - S1: Va, Choi, Hong, "Real-Time Cloth Simulation Using Compute Shader in Unity3D for AR/VR Contents", 2021.
//! - S2: the article "CUDA Cloth Simulation".
//! - S3: Va, Choi, Hong, "Real-Time Surface-Based Volume Constraints on Mass-Spring Model in Unity3D", 2023.
//!
//! A paper's module has its runs ([`runs::job::Job`]) and the tables that are made of what they leave
//! ([`report::look::Look`]). Every number of ours is read from what a run left ([`report::store::Kept`]), and the report has that,
//! too.

mod contact;
mod draw;
mod drive;
mod errata;
mod gallery;
mod kernels;
mod papers;
mod pictures;
mod progress;
mod report;
mod reproduce;
mod runs;
mod tournament;

use clap::{Parser, Subcommand};
use papers::paper::Paper;
use std::process::ExitCode;
use taffeta_io::program;

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
    /// Time the papers' kernels beside the engine's, on a GPU
    Kernels(kernels::bench::Args),
    /// Write docs/errata.md again
    Errata,
    /// Run scenes and draw a moment of each into docs/pictures
    Pictures {
        /// Names of scenes [default: those that are about something to see]
        scenes: Vec<String>,
    },
    /// Draw the pictures at the top of the README with taffeta-view
    Gallery(gallery::Args),
}

fn main() -> ExitCode {
    // SAFETY: the program has started no thread yet.
    unsafe { program::expect_no_desktop() };
    program::end(match Cli::parse().command {
        Command::S1(args) => reproduce::run(&args, &[Paper::S1]),
        Command::S2(args) => reproduce::run(&args, &[Paper::S2]),
        Command::S3(args) => reproduce::run(&args, &[Paper::S3]),
        Command::All(args) => reproduce::run(&args, &Paper::ALL),
        Command::Kernels(args) => kernels::bench::run(&args),
        Command::Errata => errata::write(),
        Command::Pictures { scenes } => pictures::run(&scenes),
        Command::Gallery(args) => gallery::run(&args),
    })
}

/// The repository's root: the folder above `crates/`.
fn root() -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}
