//! `taffeta schema`: the formats as JSON Schema.

use crate::check::MeshReport;
use crate::console;
use crate::summary::Summary;
use clap::ValueEnum;
use schemars::schema_for;
use taffeta::scene::Scene;
use taffeta_io::program::Failure;

/// Print the JSON Schema of scenes, of summary.json or of the answer to `check MESH --json`
#[derive(clap::Args)]
pub struct Args {
    /// Which format
    what: Format,
}

#[derive(Clone, Copy, ValueEnum)]
enum Format {
    Scene,
    Summary,
    Check,
}

/// Prints the schema.
pub fn run(args: &Args) -> Result<(), Failure> {
    let schema = match args.what {
        Format::Scene => schema_for!(Scene),
        Format::Summary => schema_for!(Summary),
        Format::Check => schema_for!(MeshReport),
    };
    console::say(&console::json(&schema)?)
}
