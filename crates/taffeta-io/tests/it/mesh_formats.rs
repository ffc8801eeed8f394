//! The formats of mesh files: the same mesh from each, and what is broken in one of them.

use std::path::{Path, PathBuf};
use std::time::Instant;
use taffeta::topology::Surface;
use taffeta_io::{MeshFormat, MeshOptions, load_mesh, parse_mesh};

/// A cube of 1 m about the origin; corner index = 4x + 2y + z, faces outward.
const FACES: [[u32; 3]; 12] = [
    [1, 3, 0],
    [4, 1, 0],
    [0, 3, 2],
    [2, 4, 0],
    [1, 7, 3],
    [5, 1, 4],
    [5, 7, 1],
    [3, 7, 2],
    [6, 4, 2],
    [2, 7, 6],
    [6, 5, 4],
    [7, 5, 6],
];

fn corner(index: u32) -> [f64; 3] {
    [index >> 2 & 1, index >> 1 & 1, index & 1].map(|bit| f64::from(bit) - 0.5)
}

fn lines(rows: impl Iterator<Item = [f64; 3]>, word: &str) -> String {
    rows.map(|[x, y, z]| format!("{word}{x} {y} {z}\n")).collect()
}

fn faces(word: &str, first: u32) -> String {
    FACES.iter().map(|face| face.map(|i| i + first)).map(|[a, b, c]| format!("{word}{a} {b} {c}\n")).collect()
}

fn obj() -> Vec<u8> {
    (lines((0..8).map(corner), "v ") + &faces("f ", 1)).into_bytes()
}

fn ply() -> Vec<u8> {
    let head = "ply\nformat ascii 1.0\nelement vertex 8\nproperty double x\nproperty double y\nproperty double z\n\
        element face 12\nproperty list uchar int vertex_indices\nend_header\n";
    (head.to_owned() + &lines((0..8).map(corner), "") + &faces("3 ", 0)).into_bytes()
}

fn off() -> Vec<u8> {
    ("OFF\n8 12 18\n".to_owned() + &lines((0..8).map(corner), "") + &faces("3 ", 0)).into_bytes()
}

fn ascii_stl() -> Vec<u8> {
    let facet = |face: &[u32; 3]| {
        let corners = lines(face.iter().map(|&i| corner(i)), "      vertex ");
        format!("  facet normal 0 0 0\n    outer loop\n{corners}    endloop\n  endfacet\n")
    };
    format!("solid a cube\n{}endsolid a cube\n", FACES.iter().map(facet).collect::<String>()).into_bytes()
}

fn binary_stl() -> Vec<u8> {
    let mut bytes = b"solid ".to_vec();
    bytes.resize(80, b'\n');
    bytes.extend(12_u32.to_le_bytes());
    for face in FACES {
        bytes.extend([0; 12]);
        let numbers = face.into_iter().flat_map(corner);
        numbers.for_each(|x| bytes.extend((x as f32).to_le_bytes()));
        bytes.extend([0, 0]);
    }
    bytes
}

fn glb() -> Vec<u8> {
    let places = (0..8).flat_map(corner).flat_map(|x| (x as f32).to_le_bytes());
    let binary: Vec<u8> = places.chain(FACES.into_iter().flatten().map(|i| i as u8)).collect();
    let mut json = r#"{"asset": {"version": "2.0"}, "buffers": [{"byteLength": 132}],
        "bufferViews": [{"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5121, "count": 36, "type": "SCALAR"}],
        "meshes": [{"name": "a cube", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "scene": 0}"#
        .as_bytes()
        .to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let chunk = |kind: &[u8], data: &[u8]| [&(data.len() as u32).to_le_bytes(), kind, data].concat();
    let chunks = [chunk(b"JSON", &json), chunk(b"BIN\0", &binary)].concat();
    [&b"glTF"[..], &2_u32.to_le_bytes(), &(chunks.len() as u32 + 12).to_le_bytes(), &chunks].concat()
}

/// The cube, its format and how many vertices the file has.
fn cubes() -> [(Vec<u8>, MeshFormat, usize); 6] {
    [
        (obj(), MeshFormat::Obj, 8),
        (ply(), MeshFormat::Ply, 8),
        (off(), MeshFormat::Off, 8),
        (ascii_stl(), MeshFormat::Stl, 36),
        (binary_stl(), MeshFormat::Stl, 36),
        (glb(), MeshFormat::Gltf, 8),
    ]
}

fn parse(bytes: &[u8], format: MeshFormat) -> Result<Surface, String> {
    parse_mesh(bytes, format, &MeshOptions::default()).map_err(|error| error.to_string())
}

/// Volume [m³] by the divergence theorem.
fn volume(surface: &Surface) -> f64 {
    let sixfold = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|n| surface.nodes[n as usize]);
        a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    surface.triangles.iter().map(sixfold).sum::<f64>() / 6.0
}

/// Each triangle by the places of its corners, the lowest first; in order.
fn triangles(surface: &Surface) -> Vec<[[i64; 3]; 3]> {
    let place = |node: u32| surface.nodes[node as usize].map(|x| (x * 1e6).round() as i64);
    let turned = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(place);
        [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap()
    };
    let mut all: Vec<_> = surface.triangles.iter().map(turned).collect();
    all.sort_unstable();
    all
}

#[test]
fn the_same_cube_comes_from_every_format() {
    let expected = triangles(&parse(&obj(), MeshFormat::Obj).unwrap());
    for (bytes, format, vertices) in cubes() {
        let surface = parse(&bytes, format).unwrap();
        let found = (surface.vertices.len(), surface.polygons.len(), surface.nodes.len());
        assert_eq!(found, (vertices, 12, 8), "{format:?}");
        assert_eq!(triangles(&surface), expected, "{format:?}");
        assert!((volume(&surface) - 1.0).abs() < 1e-15, "{format:?}");
        let welded = surface.repairs == ["welded 36 vertices into 8: they lay at the same places"];
        assert!(surface.repairs.is_empty() || welded, "{format:?}: {:?}", surface.repairs);
    }
    for (bytes, format) in [(ascii_stl(), MeshFormat::Stl), (glb(), MeshFormat::Gltf)] {
        let groups = parse(&bytes, format).unwrap().groups;
        assert_eq!(groups.len(), 1);
        assert_eq!((groups[0].0.as_str(), groups[0].1.len() % 4), ("a cube", 0));
    }
}

#[test]
fn the_ending_says_the_format() {
    use MeshFormat::{Gltf, Obj, Off, Ply, Stl};
    let endings = [("obj", Obj), ("ply", Ply), ("stl", Stl), ("off", Off), ("gltf", Gltf), ("glb", Gltf)];
    for (ending, format) in endings {
        let name = format!("a.b.{ending}");
        assert_eq!(MeshFormat::of(Path::new(&name)), Ok(format));
        assert_eq!(MeshFormat::of(Path::new(&name.to_uppercase())), Ok(format));
    }
    let of = |name: &str| MeshFormat::of(Path::new(name)).unwrap_err().to_string();
    let known = "convert to .obj, .ply, .stl, .off, .gltf or .glb";
    assert_eq!(of("a.fbx"), format!("not yet supported: a mesh with the ending .fbx; {known}"));
    assert_eq!(of("obj"), format!("not yet supported: a mesh with no ending; {known}"));
}

#[test]
fn truncated_and_damaged_files_get_an_answer() {
    for (whole, format, _) in cubes() {
        for end in 0..whole.len() {
            let _ = parse(&whole[..end], format);
        }
        let mut bytes = whole.clone();
        for at in 0..whole.len() {
            for flip in [1, 2, 4, 8, 16, 32, 64, 128, 255] {
                bytes[at] ^= flip;
                let _ = parse(&bytes, format);
                bytes[at] = whole[at];
            }
        }
    }
}

#[test]
fn truncated_files_with_lengths_are_refused() {
    for (whole, format, _) in cubes().into_iter().filter(|(_, format, _)| *format != MeshFormat::Obj) {
        // The last line end may be missing, and of an ASCII STL its last line; a shorter last index is one too.
        let enough = if whole.starts_with(b"solid a") {
            whole.len() - "endsolid a cube\n".len() - 1
        } else {
            whole.len() - 2
        };
        for end in 0..enough {
            let answer = parse(&whole[..end], format);
            let said =
                answer.as_ref().is_ok_and(|surface| surface.repairs.iter().any(|r| r.contains("`endsolid`")));
            assert!(answer.is_err() || said, "{format:?}: {end} bytes were accepted");
        }
    }
}

/// A collection of broken meshes, where the machine has one; the tests here hold those that matter most.
fn folder(variable: &str) -> Option<PathBuf> {
    let folder = std::env::var_os(variable).map(PathBuf::from).filter(|folder| folder.is_dir());
    if folder.is_none() {
        eprintln!("skipped: {variable} names no folder");
    }
    folder
}

#[test]
fn the_collection_of_broken_meshes_gets_its_answers() {
    let Some(folder) = folder("TAFFETA_HOSTILE") else { return };
    let refused = [
        ("binary_count_too_small.stl", "file size is 684 bytes, not 84 + 50·count = 234"),
        ("gltf_path_escape.gltf", "outside the scene's folder"),
        (
            "gltf_accessor_out_of_bounds.gltf",
            "bufferView 0 has 36 bytes from byte 0 on, but buffer 0 has only 12",
        ),
    ];
    for (name, expected) in refused {
        let start = Instant::now();
        let error = load_mesh(&folder.join(name), &MeshOptions::default()).expect_err(name).to_string();
        assert!(error.contains(name) && error.contains(expected), "{error}");
        assert!(start.elapsed().as_secs_f64() < 1.0, "{name} took too long");
    }
    for name in ["binary_ok.stl", "binary_solid_prefix.stl"] {
        let surface = load_mesh(&folder.join(name), &MeshOptions::default()).expect(name);
        assert_eq!((surface.nodes.len(), surface.triangles.len()), (8, 12), "{name}");
        assert!((volume(&surface) - 1.0).abs() < 1e-12, "{name}");
    }
}

#[test]
fn a_soup_of_facets_becomes_a_closed_torus() {
    let Some(folder) = folder("TAFFETA_MODELS") else { return };
    let file = folder.join("torus_soup.stl");
    if !file.is_file() {
        eprintln!("skipped: there is no {}", file.display());
        return;
    }
    let surface = load_mesh(&file, &MeshOptions::default()).unwrap();
    assert_eq!((surface.vertices.len(), surface.polygons.len()), (26_100, 8_700));
    assert_eq!((surface.nodes.len(), surface.triangles.len()), (4_350, 8_700));
    assert_eq!(surface.repairs, ["welded 26100 vertices into 4350: they lay at the same places"]);
    // V − E + F of a torus, every edge between two triangles.
    assert_eq!(surface.nodes.len() + surface.triangles.len(), surface.triangles.len() * 3 / 2);
    assert!((volume(&surface) - 4.9175).abs() < 1e-4);
}
