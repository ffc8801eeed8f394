//! Every scene for a few frames on the CPU and on the GPU, and the distance of the two. Scenes are run as copies in a folder
//! without models, with their stand-ins: garments that start half inside a body depend on the last digit.

use super::npy::Poses;
use super::timed;
use crate::{program, root};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::process::Command;

const FRAMES: u32 = 10;
/// Farthest that a vertex may be on the GPU from its place on the CPU after [`FRAMES`] frames [m], in scenes of a metre.
/// Rounding of 1e-7 m grows a hundredfold at most in that time; a wrong force is seen at once.
const BOUND: f64 = 1e-4;
/// The same of cloth so stiff that the last digits of places are forces which fold it.
const STIFF_BOUND: f64 = 1e-3;

/// A body in `summary.json`.
#[derive(Deserialize)]
struct Body {
    name: String,
    vertices: usize,
}

#[derive(Deserialize)]
struct Summary {
    bodies: Vec<Body>,
}

/// Runs every scene with the built program.
pub fn run() -> Result<(), String> {
    let out = std::env::temp_dir().join(format!("taffeta-scenes-{}", std::process::id()));
    let result = copies(&out).and_then(|scenes| scenes.iter().try_for_each(|scene| both(scene, &out)));
    // What is left behind in the temporary folder does no harm; the scenes' verdict counts.
    let _ = std::fs::remove_dir_all(&out);
    result
}

/// A scene on both backends.
fn both(scene: &Path, out: &Path) -> Result<(), String> {
    let name = scene.file_stem().unwrap_or_default().to_string_lossy();
    let dir = |backend: &str| out.join(&*name).join(backend);
    for backend in ["cpu", "gpu"] {
        timed(&format!("scene {name} on the {backend}"), command(scene, &dir(backend), backend))?;
    }
    let bound = if is_primal(scene) { STIFF_BOUND } else { BOUND };
    let apart = compare(&dir("cpu"), &dir("gpu"), bound).map_err(|why| format!("scene {name}: {why}"))?;
    println!("xtask: scene {name}: at most {apart:.1e} m between CPU and GPU");
    Ok(())
}

/// Whether a scene's springs are solved for by nodes.
fn is_primal(scene: &Path) -> bool {
    scene.file_stem().is_some_and(|name| name.to_string_lossy().ends_with("_primal"))
}

fn command(scene: &Path, out: &Path, backend: &str) -> Command {
    let mut command = Command::new(program::path());
    command.arg("run").arg(scene).arg("--out").arg(out).args(["--backend", backend]);
    command.args(["--frames", &FRAMES.to_string(), "--quiet"]).current_dir(folder_of(scene));
    command.env_remove("TAFFETA_MODELS");
    if is_primal(scene) {
        // Solutions are compared, not how far each backend's are from them.
        command.args(["--set", "solver.ice.tolerance=1e-6"]);
    }
    command
}

/// The folder of a scene.
fn folder_of(scene: &Path) -> &Path {
    scene.parent().unwrap_or(Path::new("."))
}

/// The largest distance of the last poses in two folders of results [m]; the error names the vertex that is too far off.
fn compare(cpu: &Path, gpu: &Path, bound: f64) -> Result<f64, String> {
    let poses = |dir: &Path| Poses::read(&dir.join("positions.npy"));
    let (vertex, apart) = farthest(&poses(cpu)?, &poses(gpu)?)?;
    if apart <= bound {
        return Ok(apart);
    }
    let file = cpu.join("summary.json");
    let text = std::fs::read(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    let summary: Summary =
        serde_json::from_slice(&text).map_err(|error| format!("{}: {error}", file.display()))?;
    let place = place(&summary.bodies, vertex);
    Err(format!(
        "{place} is {apart:.3e} m from its place on the CPU after {FRAMES} frames on the GPU; {bound:e} m are allowed"
    ))
}

/// The vertex of the last pose that is farthest from its place, and how far [m]. What is no number is infinitely far.
fn farthest(cpu: &Poses, gpu: &Poses) -> Result<(usize, f64), String> {
    if (cpu.frames, cpu.vertices) != (gpu.frames, gpu.vertices) {
        return Err(format!(
            "{} poses of {} vertices on the CPU, {} of {} on the GPU",
            cpu.frames, cpu.vertices, gpu.frames, gpu.vertices
        ));
    }
    let distance = |(p, q): (&[f64; 3], &[f64; 3])| {
        let apart = (0..3).map(|axis| (p[axis] - q[axis]).powi(2)).sum::<f64>().sqrt();
        if apart.is_finite() { apart } else { f64::INFINITY }
    };
    let distances = cpu.last.iter().zip(&gpu.last).map(distance).enumerate();
    Ok(distances.fold((0, 0.0), |most, one| if one.1 > most.1 { one } else { most }))
}

/// A vertex of all bodies in words: that of its body.
fn place(bodies: &[Body], vertex: usize) -> String {
    let mut left = vertex;
    for body in bodies {
        if left < body.vertices {
            return format!("body `{}`, vertex {left}", body.name);
        }
        left -= body.vertices;
    }
    format!("vertex {vertex}")
}

/// Copies of all scenes.
fn copies(out: &Path) -> Result<Vec<PathBuf>, String> {
    let folder = out.join("scenes");
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    std::fs::create_dir_all(&folder).map_err(failed)?;
    let copy = |file: PathBuf| {
        let copy = folder.join(file.file_name().unwrap_or_default());
        std::fs::copy(&file, &copy).map_err(failed)?;
        Ok(copy)
    };
    files()?.into_iter().map(copy).collect()
}

fn files() -> Result<Vec<PathBuf>, String> {
    let folder = root().join("scenes");
    let entries = std::fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut files: Vec<PathBuf> = entries
        .filter_map(|entry| entry.ok().map(|entry| entry.path()))
        .filter(|path| path.extension().is_some_and(|ext| ext == "toml"))
        .collect();
    files.sort();
    if files.is_empty() {
        return Err(format!("{}: no scenes", folder.display()));
    }
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn poses(last: &[[f64; 3]]) -> Poses {
        Poses { frames: 2, vertices: last.len(), last: last.to_vec() }
    }

    #[test]
    fn the_farthest_vertex_is_found_and_what_is_no_number_is_farther() {
        let a = poses(&[[0.0; 3], [1.0; 3], [2.0; 3]]);
        assert_eq!(farthest(&a, &a), Ok((0, 0.0)));
        assert_eq!(farthest(&a, &poses(&[[0.0; 3], [1.0, 1.5, 1.0], [2.0; 3]])), Ok((1, 0.5)));
        let nan = poses(&[[0.0; 3], [1.0, 1.5, 1.0], [2.0, f64::NAN, 2.0]]);
        assert_eq!(farthest(&a, &nan), Ok((2, f64::INFINITY)));
        assert_eq!(farthest(&nan, &nan), Ok((2, f64::INFINITY)));
        assert!(farthest(&a, &poses(&[[0.0; 3]])).is_err());
    }

    #[test]
    fn a_vertex_is_named_by_its_body() {
        let bodies = ["sheet", "ball"].map(|name| Body { name: name.to_owned(), vertices: 10 });
        assert_eq!(place(&bodies, 9), "body `sheet`, vertex 9");
        assert_eq!(place(&bodies, 10), "body `ball`, vertex 0");
    }
}
