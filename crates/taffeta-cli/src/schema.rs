//! `taffeta schema`: the formats as JSON Schema.

use crate::console;
use crate::failure::Failure;
use crate::summary::Summary;
use clap::ValueEnum;
use schemars::schema_for;
use taffeta::scene::Scene;

/// Print the JSON Schema of scenes or of summary.json
#[derive(clap::Args)]
pub struct Args {
    /// Which format
    what: Format,
}

#[derive(Clone, Copy, ValueEnum)]
enum Format {
    Scene,
    Summary,
}

/// Prints the schema.
pub fn run(args: &Args) -> Result<(), Failure> {
    let schema = match args.what {
        Format::Scene => schema_for!(Scene),
        Format::Summary => schema_for!(Summary),
    };
    console::say(&console::json(&schema)?)
}
