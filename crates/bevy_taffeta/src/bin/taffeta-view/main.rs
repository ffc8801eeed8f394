//! The program `taffeta-view`: shows scenes in a window, or makes films of them without one.

mod args;
mod busy;
mod changes;
mod colours;
mod film;
mod framing;
mod grab;
mod listed;
mod looks;
mod orbit;
mod panel;
mod play;
mod plots;
mod record;
mod save;
mod scenery;
mod settled;
mod stage;
mod studio;
mod window;
mod wires;

use bevy_taffeta::taffeta_io::program;
use clap::Parser;
use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    let args = args::Args::parse();
    if args.is_windowless() {
        // SAFETY: the program has started no thread yet.
        unsafe { program::expect_no_desktop() };
    }
    program::end(run(&args))
}

fn run(args: &args::Args) -> Result<(), program::Failure> {
    let opened = stage::open(args)?;
    match (&args.record, &args.picture) {
        (Some(path), _) => record::film(args, &opened, path),
        (None, Some(path)) => record::picture(args, &opened, path),
        (None, None) => window::run(args, opened),
    }
}

/// Writes a line to standard output, where there is one.
fn say(line: &str) {
    // Unlike `println!`, this does not panic when the reader has gone away.
    let _ = writeln!(std::io::stdout(), "{line}");
}
