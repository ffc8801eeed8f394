//! From the vertices and faces of a file to a surface that can be simulated, with what was mended on the way.

use super::clean::{compact, drop_duplicates, drop_flat, weld};
use super::orient::orient;
use super::polygon::Triangulator;
use super::{MeshError, MeshOptions, RawMesh};
use taffeta::topology::{Polygons, Surface, Uvs};

/// Largest extent of a mesh [m].
const LARGEST: f64 = 1e6;
/// A mesh this many times its own extent away from the origin is moved there, so that 32 bits can tell its vertices
/// apart.
const FAR: f64 = 1e4;

/// Builds a surface from vertices [m] and faces: welds, triangulates, drops what has no area or is there twice,
/// orients. Says in `repairs` what it did.
pub fn surface_from(
    vertices: Vec<[f64; 3]>,
    polygons: Polygons,
    uvs: Option<Uvs>,
    groups: Vec<(String, Vec<u32>)>,
) -> Result<Surface, MeshError> {
    check_indices(vertices.len(), &polygons, uvs.as_ref(), &groups)?;
    if let Some((i, place)) = vertices.iter().enumerate().find(|(_, p)| p.iter().any(|x| !x.is_finite())) {
        return Err(MeshError::new(format!("vertex {i} is at {place:?}; coordinates must be finite")));
    }
    build(RawMesh { vertices, polygons, uvs, groups, repairs: Vec::new() }, &MeshOptions::default())
}

/// As [`surface_from`], for a mesh whose indices and coordinates have been checked.
pub(super) fn build(raw: RawMesh, _options: &MeshOptions) -> Result<Surface, MeshError> {
    let RawMesh { mut vertices, polygons, uvs, groups, mut repairs } = raw;
    if polygons.is_empty() {
        return Err(MeshError::new("no triangles: the mesh has no faces"));
    }
    recentre(&mut vertices, &mut repairs)?;
    let (nodes, node_of_vertex) = weld(&vertices, &mut repairs);
    let mut triangulator = Triangulator::default();
    for polygon in polygons.iter() {
        triangulator.add(polygon, &node_of_vertex, &nodes);
    }
    let mut triangles = triangulator.triangles;
    drop_flat(&mut triangles, &nodes, triangulator.collapsed, &mut repairs);
    drop_duplicates(&mut triangles, &mut repairs);
    if triangles.is_empty() {
        return Err(MeshError::new(format!(
            "no triangles: none of the {} faces has an area",
            polygons.len()
        )));
    }
    orient(&mut triangles, &nodes, &mut repairs);
    let (nodes, node_of_vertex) = compact(nodes, node_of_vertex, &mut triangles, &mut repairs);
    Ok(Surface {
        vertices,
        polygons,
        uvs,
        groups,
        nodes,
        node_of_vertex,
        triangles,
        links: Vec::new(),
        rest: None,
        repairs,
    })
}

/// Refuses a mesh too large for metres, and moves one that lies far away to the origin.
fn recentre(vertices: &mut [[f64; 3]], repairs: &mut Vec<String>) -> Result<(), MeshError> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for vertex in vertices.iter() {
        for axis in 0..3 {
            low[axis] = low[axis].min(vertex[axis]);
            high[axis] = high[axis].max(vertex[axis]);
        }
    }
    let extent = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    if extent > LARGEST {
        return Err(MeshError::new(format!(
            "the mesh is {extent:e} m across; at most {LARGEST:e} m can be simulated: scale its coordinates to metres"
        )));
    }
    let centre = [0, 1, 2].map(|axis| low[axis] + 0.5 * (high[axis] - low[axis]));
    let away = centre.iter().fold(0.0_f64, |away, x| away.max(x.abs()));
    if away > FAR * extent && extent > 0.0 {
        vertices.iter_mut().for_each(|vertex| *vertex = [0, 1, 2].map(|axis| vertex[axis] - centre[axis]));
        let [x, y, z] = centre;
        repairs.push(format!(
            "the mesh is {extent:.3e} m across and {away:.3e} m from the origin: moved there by ({:e}, {:e}, {:e}) m",
            -x, -y, -z
        ));
    }
    Ok(())
}

fn check_indices(
    count: usize,
    polygons: &Polygons,
    uvs: Option<&Uvs>,
    groups: &[(String, Vec<u32>)],
) -> Result<(), MeshError> {
    let refuse = |what: String| Err(MeshError::new(what));
    let Polygons { offsets, corners } = polygons;
    let ends = (offsets.first(), offsets.last().map(|&end| end as usize));
    let (None, None) = ends else {
        if ends != (Some(&0), Some(corners.len())) || !offsets.is_sorted() {
            return refuse("the faces' offsets must rise from 0 to the number of corners".to_owned());
        }
        let beyond = |face: &[u32]| face.iter().copied().find(|&v| v as usize >= count);
        for (face, polygon) in polygons.iter().enumerate() {
            if let Some(vertex) = beyond(polygon) {
                return refuse(format!("face {face}: vertex index {vertex}; there are {count} vertices"));
            }
            if polygon.len() < 3 {
                return refuse(format!("face {face} has {} corners; it needs at least 3", polygon.len()));
            }
        }
        let fits = |uvs: &Uvs| {
            uvs.corners.len() == corners.len()
                && uvs.corners.iter().all(|&uv| (uv as usize) < uvs.coords.len())
        };
        if !uvs.is_none_or(fits) {
            return refuse("texture coordinates need one valid index for each corner".to_owned());
        }
        return match groups.iter().find(|(_, group)| group.iter().any(|&v| v as usize >= count)) {
            Some((name, _)) => refuse(format!("group `{name}` has a vertex that is not there")),
            None => Ok(()),
        };
    };
    Ok(())
}
