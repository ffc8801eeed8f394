//! `taffeta schema`: the formats as JSON Schema.

use crate::check::MeshReport;
use crate::console;
use crate::summary::Summary;
use clap::ValueEnum;
use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use schemars::{JsonSchema, Schema};
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
        Format::Scene => schema_of::<Scene>(),
        Format::Summary => schema_of::<Summary>(),
        Format::Check => schema_of::<MeshReport>(),
    };
    console::say(&console::json(&schema)?)
}

fn schema_of<T: JsonSchema>() -> Schema {
    let settings = SchemaSettings::default().with_transform(RecursiveTransform(without_example));
    settings.into_generator().into_root_schema_for::<T>()
}

/// Descriptions come from the documentation of types; its examples in Rust are none of the schema's business.
fn without_example(schema: &mut Schema) {
    if let Some(serde_json::Value::String(text)) = schema.get_mut("description")
        && let Some(end) = text.find("\n\n```")
    {
        text.truncate(end);
    }
}
