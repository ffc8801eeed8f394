//! Files given as bytes are read as those of a disk.

use std::fs;
use taffeta_io::{Given, load_given, load_scene, parse_scene};

const SCENE: &str = "
[[body]]
name = 'kite'
mesh.file = 'meshes/kite.obj'
rest_shape = './rest.obj'
area_density = 0.1
springs.internal = { file = 'struts.txt', k = 10.0 }

[[body]]
name = 'sail'
mesh.file = 'meshes/sail.gltf'
area_density = 0.1

[[collider]]
mesh.file = 'rest.obj'
poses = { file = 'poses.pc2', interval = 1.0 }
";
const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 0 1\nv 1 0 1\nf 1 3 2\nf 2 3 4\n";
const SAIL: &str = r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
"bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": "../sail.bin"}]}"#;

fn files() -> Vec<(String, Vec<u8>)> {
    let floats =
        |numbers: &[f32]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>();
    let header = [1_i32, 4, 0, 0, 2].map(i32::to_le_bytes).concat();
    let places = [0., 0., 0., 1., 0., 0., 0., 0., 1., 1., 0., 1.];
    let higher = places.map(|place| place + 0.5);
    let poses = [&b"POINTCACHE2\0"[..], &header, &floats(&places), &floats(&higher)].concat();
    let sail = floats(&[0., 0., 0., 1., 0., 0., 0., 0., 1.]);
    let files: [(&str, Vec<u8>); 6] = [
        ("meshes/kite.obj", OBJ.into()),
        ("rest.obj", OBJ.into()),
        ("struts.txt", b"0 3\n".to_vec()),
        ("meshes/sail.gltf", SAIL.into()),
        ("sail.bin", sail),
        ("poses.pc2", poses),
    ];
    files.map(|(name, bytes)| (name.to_owned(), bytes)).into()
}

#[test]
fn a_scene_of_given_files_is_that_of_the_same_files_on_a_disk() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("meshes")).unwrap();
    for (name, bytes) in files() {
        fs::write(folder.path().join(name), bytes).unwrap();
    }
    let file = folder.path().join("scene.toml");
    fs::write(&file, SCENE).unwrap();
    let on_disk = load_scene(&file, &[]).unwrap();
    let mut given = parse_scene(SCENE, "scene.toml", &[]).unwrap();
    load_given(&mut given, &files().into_iter().collect()).unwrap();
    assert_eq!(format!("{:?}", given.scene), format!("{:?}", on_disk.scene));
    let taffeta::scene::Mesh::Surface(sail) = &given.scene.bodies[1].mesh else { panic!("no surface") };
    assert_eq!(sail.vertices.len(), 3);
}

#[test]
fn a_file_that_was_not_given_is_named_at_its_line() {
    let refused = |missing: &str| {
        let given: Given = files().into_iter().filter(|(name, _)| name != missing).collect();
        let mut loaded = parse_scene(SCENE, "scene.toml", &[]).unwrap();
        load_given(&mut loaded, &given).unwrap_err().to_string()
    };
    let said = refused("meshes/kite.obj");
    let start =
        "scene.toml:4:13: `meshes/kite.obj` is not among the files given: meshes/sail.gltf, poses.pc2, ";
    assert!(said.starts_with(start), "{said}");
    let said = refused("sail.bin");
    assert!(said.contains("`../sail.bin` is not among the files that were given"), "{said}");
    let mut loaded = parse_scene(SCENE, "scene.toml", &[]).unwrap();
    let said = load_given(&mut loaded, &Given::default()).unwrap_err().to_string();
    assert!(said.contains("`meshes/kite.obj` was not given, nor any other file"), "{said}");
}
