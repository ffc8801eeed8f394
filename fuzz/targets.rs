//! What is done with the input of each fuzz target, and what must hold afterwards. The fuzzers call one of these each;
//! the test that replays the corpus calls them all.

mod calls;

use std::sync::Arc;
use taffeta::scene::{Body, Mass, Mesh, Scene};
use taffeta::topology::Surface;
use taffeta::{Options, Simulation};
use taffeta_io::{Checkpoint, MeshFormat, MeshOptions, parse_mesh, parse_scene, read_pairs, read_poses};
use twox_hash::XxHash64;

/// Memory [byte] that a scene may say it needs; larger ones are left alone.
const SMALL: u64 = 8 << 20;
/// Longest message [byte]: an error is to be read by people.
const READABLE: usize = 2000;

/// What a target does with an input; whether that was accepted.
type Target = fn(&[u8]) -> bool;

/// Each target, which has a folder of its name in `corpus`.
#[allow(dead_code, reason = "each fuzzer uses one of them, the test all")]
pub const ALL: [(&str, Target); 10] = [
    ("obj", obj),
    ("ply", ply),
    ("stl", stl),
    ("off", off),
    ("gltf", gltf),
    ("scene", scene),
    ("pairs", pairs),
    ("poses", poses),
    ("checkpoint", checkpoint),
    ("calls", calls::calls),
];

pub fn obj(input: &[u8]) -> bool {
    mesh(input, MeshFormat::Obj)
}

pub fn ply(input: &[u8]) -> bool {
    mesh(input, MeshFormat::Ply)
}

pub fn stl(input: &[u8]) -> bool {
    mesh(input, MeshFormat::Stl)
}

pub fn off(input: &[u8]) -> bool {
    mesh(input, MeshFormat::Off)
}

pub fn gltf(input: &[u8]) -> bool {
    mesh(input, MeshFormat::Gltf)
}

/// A mesh is refused in words, or is a surface that the engine accepts and can simulate.
fn mesh(input: &[u8], format: MeshFormat) -> bool {
    let runs =
        |fill_holes| match parse_mesh(input, format, &MeshOptions { fill_holes, ..MeshOptions::default() }) {
            Ok(surface) => {
                check_surface(&surface);
                let body = Body::cloth("cloth", Mesh::Surface(Arc::new(surface))).with_mass(Mass::Whole(1.0));
                run(&Scene::new("mesh").body(body.structural(100.0, 0.1).bend(10.0, 0.0).hinge(1e-3, 0.0)))
            }
            Err(error) => refused(&error.to_string()),
        };
    runs(false) & runs(true)
}

fn check_surface(surface: &Surface) {
    let nodes = surface.nodes.len() as u32;
    assert!(!surface.triangles.is_empty(), "a surface without triangles");
    assert!(surface.triangles.iter().flatten().all(|&node| node < nodes), "a triangle of no node");
    assert!(surface.triangles.iter().all(|[a, b, c]| a != b && b != c && c != a), "a triangle of two nodes");
    assert!(
        surface.nodes.iter().chain(&surface.vertices).flatten().all(|x| x.is_finite()),
        "a place that is not finite"
    );
    match &surface.node_of_vertex {
        Some(list) => {
            assert_eq!(list.len(), surface.vertices.len());
            assert!(list.iter().all(|&node| node < nodes || node == u32::MAX), "a vertex of no node");
        }
        None => assert_eq!(surface.vertices.len(), surface.nodes.len()),
    }
    surface.repairs.iter().for_each(|repair| check_message(repair));
}

fn refused(message: &str) -> bool {
    check_message(message);
    false
}

fn check_message(message: &str) {
    assert!(!message.is_empty() && message.len() <= READABLE, "a message of {} bytes", message.len());
}

/// A scene is refused in words, or runs two frames with finite positions, or says why it cannot.
pub fn scene(input: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(input) else { return false };
    match parse_scene(text, "scene.toml", &[]) {
        Ok(loaded) => run(&loaded.scene),
        Err(error) => refused(&error.to_string()),
    }
}

/// Builds a small scene and runs it. Whether it could be built.
fn run(scene: &Scene) -> bool {
    /// Most node-steps a frame, so that an input takes a moment at most.
    const WORK: u64 = 1 << 18;
    let nodes: u64 = scene.bodies.iter().map(|body| body.mesh.nodes()).fold(0, u64::saturating_add);
    if scene.memory_needed().bytes > SMALL {
        return false;
    }
    let options = Options { threads: Some(1), ..Options::default() };
    let mut simulation = match Simulation::new(scene, &options) {
        Ok(simulation) => simulation,
        Err(error) => return refused(&error.to_string()),
    };
    if nodes.saturating_mul(scene.time.substeps().into()) > WORK {
        return true;
    }
    for _ in 0..2 {
        if let Err(diverged) = simulation.step() {
            check_message(&diverged.to_string());
            return true;
        }
    }
    let mut places: Vec<[f32; 3]> = Vec::new();
    simulation.positions_f32(&mut places);
    assert!(places.iter().flatten().all(|x| x.is_finite()), "a position that is not finite");
    true
}

/// A list of struts is refused in words, or is pairs.
pub fn pairs(input: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(input) else { return false };
    match read_pairs(text, "struts.txt") {
        Ok((pairs, _)) => {
            assert!(pairs.len() <= input.len() / 4 + 1, "more pairs than there is room for");
            true
        }
        Err(error) => refused(&error.to_string()),
    }
}

/// Poses are refused in words, or are as many places as the file has bytes for. The first byte is the number of vertices.
pub fn poses(input: &[u8]) -> bool {
    let Some((&vertices, file)) = input.split_first() else { return false };
    let vertices = usize::from(vertices);
    match read_poses(file, vertices) {
        Ok(poses) => {
            assert!(
                !poses.is_empty() && poses.iter().all(|pose| pose.len() == vertices),
                "poses without places"
            );
            assert!(12 * vertices * poses.len() <= file.len(), "more places than there is room for");
            true
        }
        Err(error) => refused(&error),
    }
}

/// A checkpoint is refused in words, or is one. Its last eight bytes are a checksum, which no fuzzer finds: the input is
/// read as it is, and with the right length and checksum.
pub fn checkpoint(input: &[u8]) -> bool {
    let sealed = seal(input);
    let read = |bytes: &[u8]| match Checkpoint::<Vec<u32>>::parse(bytes) {
        Ok(checkpoint) => {
            let taken = checkpoint.snapshot.state.len() + checkpoint.snapshot.constraints.len();
            assert!(taken < bytes.len(), "more state than there is room for");
            true
        }
        Err(error) => refused(&error),
    };
    let plain = read(input);
    read(&sealed) || plain
}

/// The input with its length and its checksum set right.
fn seal(input: &[u8]) -> Vec<u8> {
    let mut bytes = input.to_vec();
    let Some(end) = bytes.len().checked_sub(8).filter(|end| *end >= 20) else { return bytes };
    let length = bytes.len() as u64;
    bytes[12..20].copy_from_slice(&length.to_le_bytes());
    let hash = XxHash64::oneshot(0, &bytes[..end]);
    bytes[end..].copy_from_slice(&hash.to_le_bytes());
    bytes
}
