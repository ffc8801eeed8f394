//! Meshes as they come: what is accepted, repaired and refused, and what is said about it.

mod files;
mod foreign;
mod holes;
mod parts;
mod random;
mod rest;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;
use taffeta::topology::{Polygons, Surface, Uvs};
use taffeta_io::{MeshError, MeshOptions, load_mesh, surface_from};

/// OBJ text of vertices and faces that count from 0.
fn obj(vertices: &[[f64; 3]], faces: &[[u32; 3]]) -> String {
    let vertices = vertices.iter().map(|[x, y, z]| format!("v {x:?} {y:?} {z:?}\n"));
    let faces = faces.iter().map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1));
    vertices.chain(faces).collect()
}

/// Cubes, each with its centre, its size and whether it is inside out.
fn cubes(cubes: &[([f64; 3], f64, bool)]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let corner = |i: usize| [i / 4, i / 2 % 2, i % 2].map(|bit| bit as f64 - 0.5);
    let places = cubes.iter().flat_map(|&(centre, size, _)| {
        (0..8).map(corner).map(move |p| [0, 1, 2].map(|i| centre[i] + size * p[i]))
    });
    let faces = cubes.iter().zip((0..).step_by(8)).flat_map(|(&(_, _, inside_out), first)| {
        CUBE_FACES.map(|face| {
            let [a, b, c] = face.map(|i| first + i - 1);
            if inside_out { [a, c, b] } else { [a, b, c] }
        })
    });
    (places.collect(), faces.collect())
}

/// A cube of 1 m about the origin; corner index = 4x + 2y + z, faces outward.
const CUBE_VERTICES: &str = "v -0.5 -0.5 -0.5\nv -0.5 -0.5 0.5\nv -0.5 0.5 -0.5\nv -0.5 0.5 0.5\nv 0.5 -0.5 -0.5\n\
    v 0.5 -0.5 0.5\nv 0.5 0.5 -0.5\nv 0.5 0.5 0.5\n";
const CUBE_FACES: [[u32; 3]; 12] = [
    [2, 4, 1],
    [5, 2, 1],
    [1, 4, 3],
    [3, 5, 1],
    [2, 8, 4],
    [6, 2, 5],
    [6, 8, 2],
    [4, 8, 3],
    [7, 5, 3],
    [3, 8, 7],
    [7, 6, 5],
    [8, 6, 7],
];

fn load(text: &str) -> Result<Surface, MeshError> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mesh.obj");
    fs::write(&file, text).unwrap();
    load_mesh(&file, &MeshOptions::default())
}

fn cube(turn: impl Fn(usize) -> bool) -> String {
    let face = |(i, [a, b, c]): (usize, &[u32; 3])| {
        if turn(i) { format!("f {a} {c} {b}\n") } else { format!("f {a} {b} {c}\n") }
    };
    CUBE_VERTICES.to_owned() + &CUBE_FACES.iter().enumerate().map(face).collect::<String>()
}

/// Volume [m³], and whether each edge has two triangles that run along it in opposite directions.
fn volume_and_closed(surface: &Surface) -> (f64, bool) {
    let mut edges = std::collections::HashMap::new();
    let mut sum = 0.0;
    for triangle in &surface.triangles {
        let [a, b, c] = triangle.map(|n| surface.nodes[n as usize]);
        sum += a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0]);
        for i in 0..3 {
            *edges.entry((triangle[i], triangle[(i + 1) % 3])).or_insert(0) += 1;
        }
    }
    let closed = edges.iter().all(|(&(a, b), &count)| count == 1 && edges.get(&(b, a)) == Some(&1));
    (sum / 6.0, closed)
}

fn assert_unit_cube(surface: &Surface) {
    let (volume, closed) = volume_and_closed(surface);
    assert!(closed && (volume - 1.0).abs() < 1e-12, "volume {volume}, closed: {closed}");
    assert_eq!((surface.nodes.len(), surface.triangles.len()), (8, 12));
}

#[test]
fn a_good_mesh_is_taken_as_it_is() {
    let surface = load(&cube(|_| false)).unwrap();
    assert_unit_cube(&surface);
    assert_eq!(surface.repairs, Vec::<String>::new());
    assert_eq!(surface.node_of_vertex, None);
    assert_eq!(surface.triangles, CUBE_FACES.map(|face| face.map(|i| i - 1)));
}

#[test]
fn any_winding_becomes_outward() {
    type Turn = fn(usize) -> bool;
    let turns: [(Turn, &str); 4] = [
        (|_| true, "reoriented 12 triangles: the surface was inside out"),
        (|i| i == 0, "reoriented 1 triangle: neighbours disagreed"),
        (|i| i % 3 == 0, "reoriented 4 triangles: neighbours disagreed"),
        (|i| i > 1, "reoriented 10 triangles: the surface was inside out"),
    ];
    for (turn, said) in turns {
        let surface = load(&cube(turn)).unwrap();
        assert_unit_cube(&surface);
        assert_eq!(surface.repairs, [said]);
    }
}

#[test]
fn vertices_at_one_place_become_one_node() {
    let soup: String = CUBE_FACES
        .iter()
        .flatten()
        .map(|&i| {
            CUBE_VERTICES.lines().nth(i as usize - 1).unwrap().replace("-0.5 -0.5 -0.5", "-0.50 -.5 -5e-1")
                + "\n"
        })
        .chain((0..12).map(|i| format!("f {} {} {}\n", 3 * i + 1, 3 * i + 2, 3 * i + 3)))
        .collect();
    let surface = load(&soup).unwrap();
    assert_unit_cube(&surface);
    assert_eq!((surface.vertices.len(), surface.polygons.len()), (36, 12));
    assert_eq!(surface.repairs, ["welded 36 vertices into 8: they lay at the same places"]);
    let nodes = surface.node_of_vertex.unwrap();
    assert!((0..36).all(|v| surface.vertices[v] == surface.nodes[nodes[v] as usize]));
    assert_eq!(&nodes[..6], [0, 1, 2, 3, 0, 2]);
}

#[test]
fn what_has_no_area_or_is_there_twice_is_dropped_and_said() {
    let extra = "v 0 0 0\nv 0.1 0.2 0.3\nv 0.2 0.4 0.6\nf 9 10 11\nf 1 1 2\nf 2 4 1\nf 5 2 6\nf 1 2 2 1\n";
    let surface = load(&(cube(|_| false) + extra)).unwrap();
    assert_unit_cube(&surface);
    assert_eq!(
        surface.repairs,
        [
            "dropped 3 triangles without area",
            "dropped 2 triangles with the same corners as another one",
            "3 vertices of no triangle: kept in outputs, not simulated",
        ]
    );
    assert_eq!(surface.node_of_vertex.unwrap()[8..], [u32::MAX; 3]);
    assert_eq!((surface.vertices.len(), surface.polygons.len()), (11, 17));
}

#[test]
fn a_prism_over_a_concave_polygon_has_its_volume() {
    // An L of area 3, 2 m high.
    let base = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    let ring = |z: f64| base.map(|[x, y]| format!("v {x} {y} {z}\n")).concat();
    let sides: String =
        (0..6).map(|i| format!("f {} {} {} {}\n", i + 1, (i + 1) % 6 + 1, (i + 1) % 6 + 7, i + 7)).collect();
    let surface = load(&(ring(0.0) + &ring(2.0) + "f 6 5 4 3 2 1\nf 7 8 9 10 11 12\n" + &sides)).unwrap();
    let (volume, closed) = volume_and_closed(&surface);
    assert!(closed && (volume - 6.0).abs() < 1e-12, "{volume}");
    assert_eq!((surface.polygons.len(), surface.triangles.len()), (8, 20));
    assert_eq!(surface.repairs, Vec::<String>::new());
}

#[test]
fn a_cavity_keeps_its_sense_even_inside_out() {
    for outer_turned in [false, true] {
        let mut text = cube(|_| outer_turned);
        let inner = cube(|_| !outer_turned);
        for line in inner.lines() {
            let mut words = line.split(' ');
            let kind = words.next().unwrap();
            let moved = |word: &str| match kind {
                "v" => format!(" {}", 0.5 * word.parse::<f64>().unwrap()),
                _ => format!(" {}", word.parse::<u32>().unwrap() + 8),
            };
            text += &format!("{kind}{}\n", words.map(moved).collect::<String>());
        }
        let (volume, closed) = volume_and_closed(&load(&text).unwrap());
        assert!(closed && (volume - 0.875).abs() < 1e-12, "{volume}");
    }
}

#[test]
fn open_crowded_and_twisted_surfaces_are_shells_with_a_word() {
    let sheet = load("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 4 3\nf 1 2 3 \n").unwrap();
    assert_eq!(sheet.triangles, [[0, 1, 2], [0, 2, 3]]);
    let fin = load(&(cube(|_| false) + "v 2 2 2\nf 2 4 9\n")).unwrap();
    assert_eq!(
        fin.repairs,
        ["not a manifold: 1 edge with more than two triangles, between vertices 1 and 3"]
    );
    let mut strip = String::new();
    for i in 0..8 {
        let angle = f64::from(i) * std::f64::consts::FRAC_PI_4;
        for side in [-0.2, 0.2] {
            let radius = 1.0 + side * (0.5 * angle).cos();
            strip += &format!(
                "v {} {} {}\n",
                radius * angle.cos(),
                radius * angle.sin(),
                side * (0.5 * angle).sin()
            );
        }
    }
    (1..8).for_each(|i| strip += &format!("f {} {} {} {}\n", 2 * i - 1, 2 * i, 2 * i + 2, 2 * i + 1));
    let twisted = load(&(strip + "f 15 16 1 2\n")).unwrap();
    assert_eq!(twisted.repairs.len(), 1);
    assert!(twisted.repairs[0].starts_with("not orientable: 1 part"), "{:?}", twisted.repairs);
}

#[test]
fn a_mesh_of_a_different_scale_is_moved_or_refused() {
    let far: String = CUBE_VERTICES
        .lines()
        .map(|line| {
            let at = |word: &str| format!(" {:.9}", 1e6 + 1e-3 * word.parse::<f64>().unwrap());
            format!("v{}\n", line.split(' ').skip(1).map(at).collect::<String>())
        })
        .collect();
    let faces: String = cube(|_| false).lines().skip(8).map(|line| format!("{line}\n")).collect();
    let surface = load(&(far + &faces)).unwrap();
    let (volume, closed) = volume_and_closed(&surface);
    assert!(closed && (volume / 1e-9 - 1.0).abs() < 1e-5, "{volume}");
    assert!(surface.repairs[0].contains("moved there by"), "{:?}", surface.repairs);
    let error = load(&cube(|_| false).replace("0.5", "5e29")).unwrap_err().message;
    assert!(error.contains("1e30 m across; at most 1e6 m"), "{error}");
    let error = load(&cube(|_| false).replace("0.5", "1.5e308")).unwrap_err().message;
    assert!(error.contains("inf m across"), "{error}");
}

#[test]
fn nothing_to_simulate_is_refused() {
    for text in ["", "# nothing\n", "v 0 0 0\n", "v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n"] {
        assert!(load(text).unwrap_err().message.contains("no triangles"));
    }
    let fbx = load_mesh(Path::new("x.fbx"), &MeshOptions::default()).unwrap_err().to_string();
    assert!(fbx.starts_with("x.fbx: not yet supported: a mesh with the ending .fbx; convert to"), "{fbx}");
    assert!(
        load_mesh(Path::new("none.obj"), &MeshOptions::default())
            .unwrap_err()
            .to_string()
            .starts_with("none.obj: cannot be read")
    );
}

#[test]
fn surfaces_given_as_data_are_checked() {
    let vertices = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let polygons =
        |offsets: &[u32], corners: &[u32]| Polygons { offsets: offsets.into(), corners: corners.into() };
    let build = |polygons, uvs, groups| surface_from(vertices.clone(), polygons, uvs, groups);
    assert!(build(polygons(&[0, 3], &[0, 1, 2]), None, vec![]).is_ok());
    for bad in [
        polygons(&[], &[]),
        polygons(&[], &[0, 1, 2]),
        polygons(&[0, 3], &[0, 1, 3]),
        polygons(&[0, 9], &[0, 1, 2]),
        polygons(&[0, 2], &[0, 1]),
        polygons(&[0, 4, 3], &[0, 1, 2]),
        polygons(&[1, 3], &[0, 1, 2]),
    ] {
        assert!(build(bad.clone(), None, vec![]).is_err(), "{bad:?}");
    }
    let one = || polygons(&[0, 3], &[0, 1, 2]);
    assert!(build(one(), Some(Uvs { coords: vec![[0.0; 2]], corners: vec![0, 0, 1] }), vec![]).is_err());
    assert!(build(one(), None, vec![("g".to_owned(), vec![3])]).is_err());
    assert!(surface_from(vec![[f64::NAN; 3]; 3], one(), None, vec![]).is_err());
}

/// A collection of broken meshes, where the machine has one; the cases above are those that matter most.
fn hostile() -> Option<PathBuf> {
    std::env::var_os("TAFFETA_HOSTILE").map(PathBuf::from).filter(|folder| folder.is_dir())
}

#[test]
fn the_collection_of_broken_meshes_gets_its_answers() {
    let Some(folder) = hostile() else {
        eprintln!("skipped: TAFFETA_HOSTILE names no folder");
        return;
    };
    let refused = [
        ("empty.obj", "no triangles"),
        ("empty.ply", "no triangles"),
        ("comments_only.obj", "no triangles"),
        ("zero_index.obj", ":4: face 0: vertex index 0"),
        ("index_out_of_range.obj", "valid: 1 to 8"),
        ("face_index_out_of_range.ply", "valid: 0 to 7"),
        ("short_vertex.obj", ":1: a vertex needs 3"),
        ("nan_coords.obj", ":2: vertex 1 "),
        ("nan.ply", "vertex "),
        ("huge_coords.obj", "1e30 m across"),
        ("huge_counts_truncated.ply", "truncated"),
        ("truncated_body.ply", "bytes follow"),
    ];
    for (name, expected) in refused {
        let start = Instant::now();
        let error = load_mesh(&folder.join(name), &MeshOptions::default()).expect_err(name).to_string();
        assert!(error.contains(name) && error.contains(expected), "{error}");
        assert!(start.elapsed().as_secs_f64() < 1.0, "{name} took too long");
    }
    let cubes = [
        "utf8_bom.obj",
        "crlf.obj",
        "negative_indices.obj",
        "quads.obj",
        "soup_duplicate_vertices.obj",
        "duplicate_faces.obj",
        "zero_area.obj",
        "inverted.obj",
        "mixed_winding.obj",
        "ascii_ok.ply",
        "big_endian.ply",
        "vertex_index_name.ply",
    ];
    for name in cubes {
        assert_unit_cube(&load_mesh(&folder.join(name), &MeshOptions::default()).expect(name));
    }
    let accepted = [
        ("syntax_variety.obj", true, 1.0 / 6.0),
        ("far_from_origin.obj", true, 1e-9),
        ("nested_cavity.obj", true, 3.2),
        ("open_boundary.obj", false, 0.0),
        ("nonmanifold_edge.obj", false, 0.0),
        ("moebius.obj", false, 0.0),
    ];
    for (name, closed, volume) in accepted {
        let found = volume_and_closed(&load_mesh(&folder.join(name), &MeshOptions::default()).expect(name));
        assert_eq!(found.1, closed, "{name}");
        assert!(!closed || (found.0 / volume - 1.0).abs() < 1e-2, "{name}: {}", found.0);
    }
    let (volume, closed) = volume_and_closed(
        &load_mesh(&folder.join("concave_ngon_prism.obj"), &MeshOptions::default()).unwrap(),
    );
    assert!(closed && volume > 0.0, "{volume}");
}
