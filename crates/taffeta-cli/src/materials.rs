//! `taffeta materials`: fabrics by name.

use crate::console;
use serde::Serialize;
use taffeta::scene::{Fabric, PRESETS};
use taffeta_io::program::Failure;

/// List the fabrics that a scene's `[body.material] preset` may name
#[derive(clap::Args)]
pub struct Args {
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// A fabric in the answer.
#[derive(Serialize)]
struct Entry {
    name: &'static str,
    title: &'static str,
    #[serde(flatten)]
    fabric: Fabric,
    /// Cusick's coefficient as simulated [%], least and largest.
    drape: [f64; 2],
    source: &'static str,
}

/// Prints them.
pub fn run(args: &Args) -> Result<(), Failure> {
    let entries = PRESETS.iter().map(|preset| Entry {
        name: preset.name,
        title: preset.title,
        fabric: preset.fabric,
        drape: preset.drape,
        source: preset.source,
    });
    if args.json {
        return console::say(&console::json(&entries.collect::<Vec<_>>())?);
    }
    let mut lines = vec![format!(
        "{:<10} {:>6} {:>13} {:>6} {:>7} {:>13} {:>6} {:>7}  {}",
        "preset",
        "kg/m²",
        "stretch N/m",
        "shear",
        "poisson",
        "bending µN·m",
        "twist",
        "drape %",
        "what it is"
    )];
    lines.extend(entries.map(|one| {
        let ([stretch, bending], micro) = ([one.fabric.stretch, one.fabric.bending], 1e6);
        format!(
            "{:<10} {:>6.3} {:>6.0} {:>6.0} {:>6.1} {:>7.2} {:>6.1} {:>6.1} {:>6.1} {:>7}  {}",
            one.name,
            one.fabric.density,
            stretch.warp,
            stretch.weft,
            one.fabric.shear,
            one.fabric.poisson,
            micro * bending.warp,
            micro * bending.weft,
            micro * one.fabric.plate()[3],
            format!("{:.0}–{:.0}", one.drape[0], one.drape[1]),
            one.title
        )
    }));
    lines.push(
        "stretch and bending: along warp, weft; drape: Cusick's coefficient as simulated on nine meshes. Sources: taffeta materials \
         --json"
            .into(),
    );
    console::say(&lines.join("\n"))
}
