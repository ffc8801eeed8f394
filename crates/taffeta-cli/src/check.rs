//! `taffeta check`: whether a scene can be run, or a mesh be simulated, and how well.

mod advice;
mod mesh;
mod report;
mod sample;
mod scene;
mod words;

pub use report::MeshReport;

use clap::ValueEnum;
use std::path::PathBuf;
use taffeta_io::program::Failure;

/// Say whether a scene can be run or a mesh simulated: counts, faults, memory, largest stable step, advice
#[derive(clap::Args)]
pub struct Args {
    /// A scene, which ends in .toml, or a mesh
    path: PathBuf,
    /// Check the mesh as a body or as a shell [default: both; the exit status is that for a shell]
    #[arg(long = "as", value_enum, value_name = "KIND")]
    kind: Option<MeshKind>,
    /// Close the holes of the mesh first, as fill_holes = true in a scene
    #[arg(long)]
    fill_holes: bool,
    /// Change a value of the scene: body.flag.springs.structural.k=500; may be given several times
    #[arg(long = "set", value_name = "PATH=VALUE")]
    sets: Vec<String>,
    /// Print the answer as JSON
    #[arg(long)]
    json: bool,
}

/// What a mesh is to be.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MeshKind {
    /// Something with an inside: kind = "soft"
    Body,
    /// Something without: kind = "cloth"
    Shell,
}

/// Checks a scene or a mesh.
pub fn run(args: &Args) -> Result<(), Failure> {
    let is_scene = args.path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
    if !is_scene {
        if !args.sets.is_empty() {
            let path = args.path.display();
            return Err(Failure::Input(format!(
                "--set is for scenes, which end in .toml, and {path} does not"
            )));
        }
        return mesh::check(args);
    }
    if args.kind.is_some() || args.fill_holes {
        let option = if args.kind.is_some() { "--as" } else { "--fill-holes" };
        return Err(Failure::Input(format!(
            "{option} is for meshes, and {} is a scene, which says so for each body",
            args.path.display()
        )));
    }
    scene::check(args)
}
