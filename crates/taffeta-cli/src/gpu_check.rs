//! `taffeta gpu-check`: whether a GPU computes what the CPU computes, and how fast, in one call on a bare machine.

mod device;
mod guard;
mod jobs;
mod parity;
mod readback;
mod report;
mod scenes;
mod session;
mod speed;
mod table;

use crate::console;
use session::Session;
use std::path::PathBuf;
use taffeta_io::program::Failure;

/// Compare a GPU with the CPU, and measure it
#[derive(clap::Args)]
pub struct Args {
    /// Write everything to this file, as JSON
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Only small scenes and few frames, as on software adapters
    #[arg(long)]
    quick: bool,
    /// Only checks and measurements whose names, as progress shows them, contain one of these words
    #[arg(long, value_name = "WORDS", value_delimiter = ',')]
    only: Vec<String>,
}

/// Checks and measures the adapter that `TAFFETA_ADAPTER` asks for, else the best one; the table comes last.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut session = Session::open(args.out.as_deref(), args.quick, &args.only)?;
    session.checks()?;
    session.measurements()?;
    let report = session.end()?;
    if report.is_empty() {
        return Err(Failure::Input(format!("--only {}: no check has such a name", args.only.join(","))));
    }
    console::say(&table::of(&report))?;
    match report.failed() {
        0 => Ok(()),
        count => {
            let what = console::counted(count, "check", "checks");
            Err(Failure::Work(format!(
                "gpu-check: {what} failed; the GPU does not compute what the CPU does"
            )))
        }
    }
}
