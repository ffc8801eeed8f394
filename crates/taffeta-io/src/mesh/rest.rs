//! Another shape of a mesh, as that at rest, from a second file.

use super::clean::is_flat;
use super::triangles::Triangles;
use super::{MeshError, RawMesh};
use std::path::Path;
use taffeta::topology::Polygons;

/// Places of the vertices [m] in another shape from what its file says, which must have the mesh's `vertices` and faces. `what` it
/// is to the mesh is a word for messages.
pub(super) fn places(
    shape: RawMesh,
    (what, path): (&str, &Path),
    vertices: usize,
    faces: &Polygons,
) -> Result<Vec<[f64; 3]>, MeshError> {
    let path = path.display();
    let there = shape.vertices.len();
    if vertices != there {
        return Err(MeshError::new(format!(
            "the mesh has {vertices} vertices and its {what} {path} has {there}; the same number would do"
        )));
    }
    match difference(faces, &shape.polygons) {
        Some(face) => Err(MeshError::new(format!("{face} there, in the {what} {path}; the same would do"))),
        None => Ok(shape.vertices),
    }
}

/// The first face that differs.
fn difference(here: &Polygons, there: &Polygons) -> Option<String> {
    let corners = |face: &[u32]| face.iter().map(u32::to_string).collect::<Vec<_>>().join(" ");
    let differ = |(face, (a, b)): (usize, (&[u32], &[u32]))| {
        (a != b).then(|| format!("face {face} has corners {} here and {}", corners(a), corners(b)))
    };
    let [a, b] = [here.len(), there.len()];
    let counts = (a != b).then(|| format!("there are {a} faces here and {b}"));
    here.iter().zip(there.iter()).enumerate().find_map(differ).or(counts)
}

/// Places of the triangles' corners at rest [m]. Refuses a shape in which one of them has no area.
pub(super) fn of_triangles(
    triangles: &Triangles,
    places: &[[f64; 3]],
    polygons: &Polygons,
) -> Result<Vec<[[f64; 3]; 3]>, MeshError> {
    let vertices = triangles.vertices.as_deref().unwrap_or_default();
    let rest: Vec<_> = vertices.iter().map(|t| t.map(|vertex| places[vertex as usize])).collect();
    let Some(flat) = rest.iter().position(|corners| is_flat(*corners)) else { return Ok(rest) };
    let [a, b, c] = vertices[flat];
    let face = polygons.iter().position(|face| vertices[flat].iter().all(|vertex| face.contains(vertex)));
    let of = match face {
        Some(face) => format!("of face {face}"),
        None => "that fills a hole".to_owned(),
    };
    Err(MeshError::new(format!(
        "the triangle {a} {b} {c} {of} has no area in the rest shape; three corners apart would do"
    )))
}
