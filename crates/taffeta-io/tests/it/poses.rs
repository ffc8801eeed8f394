//! Poses of colliders and of pins from files.

use std::fs;
use std::path::Path;
use taffeta::scene::{Collider, Mesh};
use taffeta_io::load_scene;

type V = [f64; 3];

const FACES: &str = "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

/// A tetrahedron that has risen for so many poses, far away by `far` [m] along x.
fn pose(far: f64, index: u32) -> Vec<V> {
    let rise = 0.25 * f64::from(index);
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]];
    corners.iter().map(|[x, y, z]: &V| [x + far, y + rise, *z]).collect()
}

fn obj(places: &[V], faces: &str) -> String {
    let vertex = |[x, y, z]: &V| format!("v {x} {y} {z}\n");
    places.iter().map(vertex).collect::<String>() + faces
}

fn pc2(poses: &[Vec<V>]) -> Vec<u8> {
    let mut bytes = b"POINTCACHE2\0".to_vec();
    let words = [1, poses[0].len() as i32, 0, 1.0_f32.to_bits() as i32, poses.len() as i32];
    words.iter().for_each(|word| bytes.extend(word.to_le_bytes()));
    poses.iter().flatten().flatten().for_each(|x| bytes.extend((*x as f32).to_le_bytes()));
    bytes
}

/// The collider of a scene with these `poses` of the mesh in a folder.
fn load(folder: &Path, poses: &str) -> Result<Collider, String> {
    let body = "[[body]]\nmesh = { grid = { rows = 2, cols = 2, size = [1.0, 1.0] } }\nmass = 1.0\n\
                springs.structural = { k = 1.0 }\n";
    let collider = format!("[[collider]]\nmesh = {{ file = \"mesh.obj\" }}\nposes = {{ {poses} }}\n");
    fs::write(folder.join("s.toml"), body.to_owned() + &collider).unwrap();
    let loaded = load_scene(&folder.join("s.toml"), &[]).map_err(|error| error.to_string())?;
    Ok(loaded.scene.colliders[0].clone())
}

#[test]
fn poses_of_a_far_mesh_are_moved_as_it_is() {
    for far in [0.0, 131072.0] {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, bytes: Vec<u8>| fs::write(folder.path().join(name), bytes).unwrap();
        let poses: Vec<Vec<V>> = (0..3).map(|index| pose(far, index)).collect();
        write("mesh.obj", obj(&poses[0], FACES).into());
        write("film.pc2", pc2(&poses));
        for (index, pose) in poses.iter().enumerate() {
            write(&format!("{index}.obj"), obj(pose, FACES).into());
        }
        for text in ["file = \"film.pc2\"", "files = [\"0.obj\", \"1.obj\", \"2.obj\"]"] {
            let collider = load(folder.path(), text).unwrap();
            let Some(Mesh::Surface(mesh)) = &collider.mesh else { panic!("{:?}", collider.mesh) };
            assert!((mesh.nodes[0][0] == 0.0) == (far == 0.0) && mesh.nodes[0][0].abs() < 1.0);
            for (index, given) in collider.poses.unwrap().nodes.iter().enumerate() {
                for ([x, y, z], [p, q, r]) in mesh.nodes.iter().zip(given.iter()) {
                    let rise = 0.25 * index as f64;
                    assert_eq!([*p, *q, *r], [*x, y + rise, *z], "{text}, pose {index}, {far} m away");
                }
            }
        }
    }
}

/// The nodes of a pin in each pose, of a scene whose body is that mesh.
fn load_pinned(folder: &Path, pin: &str) -> Result<Vec<Vec<V>>, String> {
    let body = format!(
        "[[body]]\nmesh.file = \"mesh.obj\"\nmass = 1.0\nsprings.structural = {{ k = 1.0 }}\n[[body.pin]]\n\
         select = {{ nodes = [0, 3] }}\n{pin}\n"
    );
    fs::write(folder.join("s.toml"), body).unwrap();
    let loaded = load_scene(&folder.join("s.toml"), &[]).map_err(|error| error.to_string())?;
    loaded.scene.validate().map_err(|error| loaded.source.locate(&error).to_string())?;
    let Mesh::Surface(mesh) = &loaded.scene.bodies[0].mesh else {
        panic!("{:?}", loaded.scene.bodies[0].mesh)
    };
    let origin = mesh.nodes[0];
    let poses = loaded.scene.bodies[0].pins[0].poses.clone().unwrap();
    let from = |pose: &Vec<V>| pose.iter().map(|x| [0, 1, 2].map(|axis| x[axis] - origin[axis])).collect();
    Ok(poses.nodes.iter().map(|pose| from(pose)).collect())
}

#[test]
fn pins_follow_poses_of_the_mesh_of_their_body() {
    for far in [0.0, 131072.0] {
        let folder = tempfile::tempdir().unwrap();
        let poses: Vec<Vec<V>> = (0..3).map(|index| pose(far, index)).collect();
        fs::write(folder.path().join("mesh.obj"), obj(&poses[0], FACES)).unwrap();
        fs::write(folder.path().join("film.pc2"), pc2(&poses)).unwrap();
        let given = load_pinned(folder.path(), "poses = { file = \"film.pc2\", interval = 0.5 }").unwrap();
        let near: Vec<Vec<V>> = (0..3).map(|index| pose(0.0, index)).collect();
        assert_eq!(given, near, "{far} m away");
        let refused = |pin: &str| load_pinned(folder.path(), pin).unwrap_err();
        let words = refused("poses = { file = \"none.pc2\" }");
        assert!(words.contains("s.toml:7:18") && words.contains("none.pc2"), "{words}");
        let words = refused("poses = { file = \"film.pc2\" }\nbreak_force = 1.0");
        assert!(words.contains("s.toml:7") && words.contains("cannot be beside break_force"), "{words}");
    }
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("film.pc2"), pc2(&[pose(0.0, 0)])).unwrap();
    let grid = "[[body]]\nmesh.grid = { rows = 2, cols = 2, size = [1.0, 1.0] }\nmass = 1.0\nsprings.structural = { k = 1.0 }\n\
                [[body.pin]]\nselect = { nodes = [0] }\nposes = { file = \"film.pc2\" }\n";
    fs::write(folder.path().join("s.toml"), grid).unwrap();
    let words = load_scene(&folder.path().join("s.toml"), &[]).unwrap_err().to_string();
    assert!(words.contains("s.toml:7") && words.contains("mesh.file would do"), "{words}");
}

#[test]
fn poses_have_the_faces_and_vertices_of_their_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |pose: String| {
        fs::write(folder.path().join("a.obj"), pose).unwrap();
        load(folder.path(), "files = [\"mesh.obj\", \"a.obj\"]").unwrap_err()
    };
    fs::write(folder.path().join("mesh.obj"), obj(&pose(0.0, 0), FACES)).unwrap();
    let words = refused(obj(&pose(0.0, 1), &FACES.replace("2 3 4", "2 4 3")));
    assert!(words.contains("s.toml:7:32: face 2 has corners 1 2 3 here and 1 3 2 there"), "{words}");
    assert!(words.contains("in the pose ") && words.contains("a.obj; the same would do"), "{words}");
    let words = refused(obj(&pose(0.0, 1), "f 1 3 2\n"));
    assert!(words.contains("there are 4 faces here and 1 there"), "{words}");
    let words = refused(obj(&pose(0.0, 1)[..3], "f 1 3 2\n"));
    assert!(words.contains("the mesh has 4 vertices and its pose ") && words.contains(" has 3"), "{words}");
    // A pose may have what a mesh of its own could not: no volume.
    let flat: Vec<V> = pose(0.0, 0).iter().map(|[x, _, z]| [*x, 0.0, *z]).collect();
    fs::write(folder.path().join("a.obj"), obj(&flat, FACES)).unwrap();
    assert!(load(folder.path(), "files = [\"mesh.obj\", \"a.obj\"]").is_ok());
}
