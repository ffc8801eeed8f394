//! Shapes at rest from a second file.

use super::obj;
use std::fs;
use taffeta::topology::Surface;
use taffeta_io::{MeshError, MeshOptions, load_mesh};

/// Loads `mesh` with the rest shape `rest`, both as OBJ.
fn load(mesh: &str, rest: &str) -> Result<Surface, MeshError> {
    let folder = tempfile::tempdir().unwrap();
    let [mesh_file, rest_file] = ["mesh.obj", "rest.obj"].map(|name| folder.path().join(name));
    fs::write(&mesh_file, mesh).unwrap();
    fs::write(&rest_file, rest).unwrap();
    load_mesh(&mesh_file, &MeshOptions { rest: Some(&rest_file), ..MeshOptions::default() })
}

/// What is said, with the names of the files alone.
fn said(mesh: &str, rest: &str) -> String {
    let message = load(mesh, rest).unwrap_err().to_string();
    let names = message.split(' ').map(|word| word.rsplit('/').next().unwrap_or_default());
    names.collect::<Vec<_>>().join(" ")
}

/// Two triangles that meet in a seam, with vertices of their own.
const WORN: [[f64; 3]; 6] =
    [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.0, 1.0, 0.0]];
const FACES: [[u32; 3]; 2] = [[0, 1, 2], [3, 4, 5]];

#[test]
fn a_seam_has_its_own_place_at_rest_on_either_side() {
    let flat = WORN.map(|[x, y, _]| [2.0 * x, 2.0 * y, 0.0]);
    let mut pattern = flat;
    pattern[3..].iter_mut().for_each(|p| p[0] += 5.0);
    let surface = load(&obj(&WORN, &FACES), &obj(&pattern, &FACES)).unwrap();
    assert_eq!((surface.nodes.len(), surface.triangles.len()), (4, 2));
    assert_eq!(surface.rest.unwrap(), FACES.map(|face| face.map(|vertex| pattern[vertex as usize])));
    // A triangle that is turned over, and those that are dropped, take their places at rest with them.
    let faces = [[0, 1, 1], [0, 1, 2], [2, 0, 1], [3, 5, 4]];
    let surface = load(&obj(&WORN, &faces), &obj(&pattern, &faces)).unwrap();
    assert_eq!(surface.triangles, [[0, 1, 2], [1, 3, 2]]);
    assert_eq!(surface.rest.unwrap(), FACES.map(|face| face.map(|vertex| pattern[vertex as usize])));
}

#[test]
fn faces_of_any_size_keep_their_corners_at_rest() {
    let quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 0 0\nf 1 5 2 3 4\nf 1 2 3 4 1\n";
    let surface = load(quad, &quad.replace("v 1 1 0", "v 3 3 0")).unwrap();
    let rest = surface.rest.unwrap();
    assert_eq!(surface.triangles.len(), rest.len());
    for (triangle, rest) in surface.triangles.iter().zip(rest) {
        let expected = triangle.map(|node| match surface.nodes[node as usize] {
            [1.0, 1.0, 0.0] => [3.0, 3.0, 0.0],
            other => other,
        });
        assert_eq!(rest, expected);
    }
}

#[test]
fn a_rest_shape_of_another_mesh_is_refused_by_its_first_difference() {
    let mesh = obj(&WORN, &FACES);
    assert_eq!(
        said(&mesh, &obj(&WORN, &[[0, 1, 2], [3, 4, 1]])),
        "mesh.obj: face 1 has corners 3 4 5 here and 3 4 1 there, in the rest shape rest.obj; the same would do"
    );
    assert_eq!(
        said(&mesh, &obj(&WORN, &FACES[..1])),
        "mesh.obj: there are 2 faces here and 1 there, in the rest shape rest.obj; the same would do"
    );
    assert_eq!(
        said(&mesh, &obj(&WORN[..5], &FACES[..1])),
        "mesh.obj: the mesh has 6 vertices and its rest shape rest.obj has 5; the same number would do"
    );
    assert_eq!(said(&mesh, "v 0 0\n"), "rest.obj:1: a vertex needs 3 coordinates, found 2");
    let huge = WORN.map(|p| p.map(|x| 1e30 * x));
    assert!(said(&mesh, &obj(&huge, &FACES)).starts_with("rest.obj: the mesh is 1e30 m across"));
}

#[test]
fn a_triangle_without_area_at_rest_is_refused_by_its_face() {
    let mut squashed = WORN;
    squashed[4] = [0.5, 0.5, 0.0];
    assert_eq!(
        said(&obj(&WORN, &FACES), &obj(&squashed, &FACES)),
        "mesh.obj: the triangle 3 4 5 of face 1 has no area in the rest shape; three corners apart would do"
    );
}
