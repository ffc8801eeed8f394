//! The program `taffeta-view`: shows scenes in a window, or makes films of them without one.

mod args;
mod colours;
mod failure;
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

use clap::Parser;
use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    let args = args::Args::parse();
    if args.is_windowless() {
        expect_no_desktop();
    }
    match run(&args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // Where standard error is closed there is nobody left to tell.
            let _ = writeln!(std::io::stderr(), "{failure}");
            failure.code()
        }
    }
}

fn run(args: &args::Args) -> Result<(), failure::Failure> {
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

/// Keeps Vulkan's device selection from complaining on a machine without a desktop: it looks for one in the folder that
/// this variable names. There is nothing at this path, and nobody else can put something there.
#[cfg(target_os = "linux")]
fn expect_no_desktop() {
    let name = "XDG_RUNTIME_DIR";
    if std::env::var_os(name).is_none_or(|value| value.is_empty()) {
        // SAFETY: the only thread of the process does this before it starts others.
        unsafe { std::env::set_var(name, "/nonexistent") };
    }
}

/// Nothing complains elsewhere.
#[cfg(not(target_os = "linux"))]
fn expect_no_desktop() {}
