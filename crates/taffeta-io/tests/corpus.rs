//! Replays the inputs of the fuzz targets: none panics, and none makes a parser take memory that its length does not
//! account for.

#[path = "../../../fuzz/targets.rs"]
mod targets;

use std::alloc::{GlobalAlloc, Layout, System};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use taffeta::scene::{Body, Mass, Mesh, Method, Scene};
use taffeta::{Options, Simulation};
use taffeta_io::checkpoint::{Checkpoint, identity};
use taffeta_io::{MeshFormat, MeshOptions, parse_mesh, parse_scene, read_pairs, read_poses};

/// Counts what is allocated.
struct Counting;

static NOW: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call goes to the system's allocator as it is.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let now = NOW.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        PEAK.fetch_max(now, Ordering::Relaxed);
        // SAFETY: the caller keeps the contract.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        NOW.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller keeps the contract.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Memory [byte] that a parser may take for each byte of its input, and without any.
///
/// The densest input is a polygon of a binary PLY, one byte a corner. While it is cut up, a corner takes 16 bytes for its
/// place, 32 for its links, queue and lists, 64 to 128 for the boxes of the tree that finds it, 16 for its order there,
/// 12 for the triangle that is made of it, and up to twice that where lists have just grown: 220 were measured.
const PER_BYTE: usize = 256;
const BASE: usize = 1 << 20;

/// Peak of the memory [byte] that `work` takes on top of what is taken before.
fn peak(work: impl FnOnce()) -> usize {
    let before = NOW.load(Ordering::Relaxed);
    PEAK.store(before, Ordering::Relaxed);
    work();
    PEAK.load(Ordering::Relaxed) - before
}

#[track_caller]
fn assert_frugal(name: &str, bytes: usize, work: impl FnOnce()) {
    let taken = peak(work);
    let bound = BASE + PER_BYTE * bytes;
    assert!(taken <= bound, "{name}: {taken} bytes for {bytes}, at most {bound} would do");
}

fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus")
}

fn files(target: &str) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> =
        fs::read_dir(corpus().join(target)).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// A PLY of `vertices` in 3 bytes each, in a lattice; `rest` follows.
fn ply(vertices: usize, header: &str, rest: impl IntoIterator<Item = u8>) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty char x\nproperty char y\n\
         property char z\n{header}end_header\n"
    )
    .into_bytes();
    bytes.extend((0..vertices).flat_map(|i| [i % 100, i / 100 % 100, i / 10_000].map(|x| x as u8)));
    bytes.extend(rest);
    bytes
}

/// Bytes without order (Knuth, The Art of Computer Programming 2, 1997).
fn noise(count: usize) -> impl Iterator<Item = u8> {
    let mut state = 1_u32;
    (0..count).map(move |_| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    })
}

/// Inputs that say as much as they can in few bytes.
fn dense_meshes(count: usize) -> Vec<(&'static str, MeshFormat, Vec<u8>)> {
    let list = |element: &str| format!("element {element}\nproperty list int uchar vertex_indices\n");
    let length = (count as u32).to_le_bytes();
    let quads = (0..count).flat_map(|i| [4, 0, 1, 100, i as u8]);
    let quad_header = format!("element face {count}\nproperty list uchar uchar vertex_indices\n");
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n".to_owned();
    let names: String = (0..32).map(|i| format!(" {i}")).collect();
    let objects: String = (0..count).map(|i| format!("o {i}\nf 1 2 3\n")).collect();
    vec![
        ("a polygon", MeshFormat::Ply, ply(256, &list("face 1"), length.into_iter().chain(noise(count)))),
        ("a strip", MeshFormat::Ply, ply(256, &list("tristrips 1"), length.into_iter().chain(noise(count)))),
        ("quads", MeshFormat::Ply, ply(256, &quad_header, quads)),
        ("vertices", MeshFormat::Ply, ply(count, &list("face 1"), [3, 0, 0, 0, 0, 1, 2])),
        ("faces", MeshFormat::Obj, (corners.clone() + &"f 1 2 3\n".repeat(count)).into_bytes()),
        ("groups", MeshFormat::Obj, format!("{corners}g{names}\n{}", "f 1 2 3\n".repeat(count)).into_bytes()),
        ("objects", MeshFormat::Obj, (corners + &objects).into_bytes()),
        ("points", MeshFormat::Obj, ("v 0 0 0\n".repeat(count) + "f 1 2 3\n").into_bytes()),
    ]
}

/// `cargo test -p taffeta-io --test corpus -- --ignored` writes the seeds of checkpoints again: for a new version of their
/// format.
#[test]
#[ignore = "writes into fuzz/corpus"]
fn write_the_seeds_of_checkpoints() {
    let folder = corpus().join("checkpoint");
    let sheet =
        Body::cloth("sheet", Mesh::grid(3, 4, [0.3, 0.2])).with_mass(Mass::Node(0.1)).structural(40.0, 0.1);
    let scene = Scene::new("").time(0.01, 0.002).method(Method::Acad).body(sheet);
    let mut simulation = Simulation::new(&scene, &Options::default()).unwrap();
    simulation.step().unwrap();
    let good =
        Checkpoint { scene: identity(&scene), snapshot: simulation.snapshot(), run: vec![1_u32, 2, 3] };
    let good_file = folder.join("good.taffeta");
    good.write(&good_file).unwrap();
    let mut nodes = good.clone();
    nodes.snapshot.nodes = u64::MAX;
    nodes.write(&folder.join("refused_nodes.taffeta")).unwrap();
    let mut pulls = good.clone();
    pulls.snapshot.pulls = u64::MAX / 4;
    pulls.write(&folder.join("refused_pulls.taffeta")).unwrap();
    let mut adaptive = good.clone();
    adaptive.snapshot.adaptive = u64::MAX;
    adaptive.write(&folder.join("refused_adaptive.taffeta")).unwrap();
    let bytes = fs::read(&good_file).unwrap();
    fs::write(folder.join("refused_cut.taffeta"), &bytes[..bytes.len() / 2]).unwrap();
    let altered = |name: &str, at: usize, value: u32| {
        let mut bytes = bytes.clone();
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        fs::write(folder.join(name), bytes).unwrap();
    };
    altered("refused_older.taffeta", 8, 0);
    altered("refused_record_length.taffeta", 20, u32::MAX);
}

// One test for all: what runs beside it would be counted with it.
#[test]
fn hostile_inputs_end_in_words_and_within_their_memory() {
    for (target, run) in targets::ALL {
        let files = files(target);
        assert!(!files.is_empty(), "no corpus for {target}");
        for file in files {
            let input = fs::read(&file).unwrap();
            let name = file.display().to_string();
            let refused = file.file_name().is_some_and(|name| name.to_string_lossy().starts_with("refused"));
            // What runs scenes for any input takes what they take.
            let length = if target == "calls" { 1 << 16 } else { input.len() };
            assert_frugal(&name, length, || assert_eq!(run(&input), !refused, "{name}: accepted"));
        }
    }
    for (name, format, input) in dense_meshes(50_000) {
        assert_frugal(name, input.len(), || drop(parse_mesh(&input, format, &MeshOptions::default())));
    }
    let pairs = "1 2\n".repeat(50_000);
    assert_frugal("pairs", pairs.len(), || drop(read_pairs(&pairs, "pairs.txt")));
    let header = [1, 1, 0, 0, 50_000_i32].map(i32::to_le_bytes).concat();
    let poses = [&b"POINTCACHE2\0"[..], &header, &[0; 12 * 50_000]].concat();
    assert_frugal("poses", poses.len(), || drop(read_poses(&poses, 1)));
    for text in [format!("a = [{}]", "1,".repeat(50_000)), "[[body]]\n".repeat(50_000), "a.".repeat(50_000)] {
        assert_frugal(&text[..9], text.len(), || drop(parse_scene(&text, "scene.toml", &[])));
    }
}
