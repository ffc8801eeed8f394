//! `taffeta reproduce`, which is a program of its own now.

use taffeta_io::program::Failure;

/// Say which program has the report on three papers now
#[derive(clap::Args)]
pub struct Args {
    /// What it was called with
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    words: Vec<String>,
}

/// Says the command.
pub fn run(args: &Args) -> Result<(), Failure> {
    let words = if args.words.is_empty() { "all --out DIR".to_owned() } else { args.words.join(" ") };
    Err(Failure::Input(format!(
        "the report on the papers is a program of its own now; in a checkout of taffeta:\n    \
         cargo build --release -p taffeta-cli && cargo run --release -p taffeta-papers -- {words}"
    )))
}
