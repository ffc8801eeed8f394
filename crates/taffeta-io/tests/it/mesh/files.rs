//! Files and sizes that no mesh should have.

use super::{cube, cubes, load, obj};
use std::fs::{self, File};
use std::path::Path;
use taffeta_io::{MeshOptions, load_mesh};

fn said(path: &Path) -> String {
    load_mesh(path, &MeshOptions::default()).unwrap_err().message
}

#[test]
fn what_is_no_regular_file_is_refused_without_waiting() {
    let folder = tempfile::tempdir().unwrap();
    let sub = folder.path().join("folder.obj");
    fs::create_dir(&sub).unwrap();
    assert_eq!(said(&sub), "is a folder; a mesh file would do");
    assert_eq!(said(folder.path()), "is a folder; a mesh file would do");
    assert!(said(&folder.path().join("none.obj")).starts_with("cannot be read: "));
    if cfg!(unix) {
        let pipe = folder.path().join("pipe.obj");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        if made.is_ok_and(|status| status.success()) {
            assert_eq!(said(&pipe), "is not a regular file; a mesh file would do");
        }
    }
}

#[test]
fn a_file_larger_than_memory_is_refused_before_it_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("large.ply");
    let sparse = File::create(&path).and_then(|file| file.set_len(1 << 42));
    if sparse.is_err() || !Path::new("/proc/meminfo").exists() {
        eprintln!("skipped: no such file can be made, or the memory is not known");
        return;
    }
    let message = said(&path);
    assert!(
        message.starts_with("is 4096.0 GiB long; reading it takes about 4 times as much memory"),
        "{message}"
    );
}

#[test]
fn sizes_from_the_smallest_to_the_largest_are_taken_or_said() {
    for size in [1e-11, 1e-6, 1e5] {
        let (vertices, faces) = cubes(&[([0.0; 3], size, true)]);
        let surface = load(&obj(&vertices, &faces)).unwrap();
        assert_eq!((surface.nodes.len(), surface.triangles.len()), (8, 12), "{size}");
        assert_eq!(surface.repairs, ["reoriented 12 triangles: the surface was inside out"]);
    }
    for (size, expected) in [
        (5e-324, "at least 1e-12 m"),
        (1e-310, "at least 1e-12 m"),
        (1e7, "at most 1e6 m"),
        (1e30, "1e30 m across"),
    ] {
        // From 0 to the size, so that the smallest number is not halved.
        let (vertices, faces) = cubes(&[([0.5; 3], 1.0, false)]);
        let vertices: Vec<[f64; 3]> = vertices.iter().map(|p| p.map(|x| x * size)).collect();
        let message = load(&obj(&vertices, &faces)).unwrap_err().message;
        assert!(message.contains(expected), "{size}: {message}");
    }
}

#[test]
fn coincident_and_repeated_vertices_do_no_harm() {
    let all_in_one = obj(&[[1.0, 2.0, 3.0]; 3000], &[[0, 1, 2], [5, 2000, 2999]]);
    assert_eq!(load(&all_in_one).unwrap_err().message, "no triangles: none of the 2 faces has an area");
    let line = obj(&[[0.0; 3], [1.0; 3], [2.0; 3]], &[[0, 1, 2]]);
    assert_eq!(load(&line).unwrap_err().message, "no triangles: the only face has no area");
    // The cube, with ten thousand vertices more at one of its corners, the last of them used.
    let (mut vertices, mut faces) = cubes(&[([0.0; 3], 1.0, false)]);
    vertices.extend([vertices[7]; 10_000]);
    faces[0] = faces[0].map(|v| if v == 7 { 10_007 } else { v });
    let surface = load(&obj(&vertices, &faces)).unwrap();
    assert_eq!((surface.nodes.len(), surface.triangles.len()), (8, 12));
    // Zero and minus zero are one place.
    let (vertices, _) = cubes(&[([0.5; 3], 1.0, false)]);
    let soup = vertices.iter().map(|p| p.map(|x| if x == 0.0 { -0.0 } else { x }));
    let faces: Vec<[u32; 3]> =
        super::CUBE_FACES.iter().enumerate().map(|(i, f)| f.map(|v| v - 1 + i as u32 % 2 * 8)).collect();
    let soup: Vec<[f64; 3]> = vertices.iter().copied().chain(soup).collect();
    assert_eq!(load(&obj(&soup, &faces)).unwrap().nodes.len(), 8);
    let repeated = cube(|_| false) + "f 1 1 1\nf 1 2 1\nf 3 3 4 4\nf 1 2 1 2\n";
    let surface = load(&repeated).unwrap();
    assert_eq!(surface.triangles.len(), 12);
    assert!(surface.repairs[0].starts_with("dropped "), "{:?}", surface.repairs);
}
