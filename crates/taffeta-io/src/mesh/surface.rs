//! From the vertices and faces of a file to a surface that can be simulated, with what was repaired on the way.

use super::bow_tie;
use super::clean::{compact, counted, drop_duplicates, drop_flat};
use super::edges::Edges;
use super::extent::{check_counts, recentre};
use super::holes;
use super::orient::outward;
use super::parts::Parts;
use super::rest;
use super::triangles::Triangles;
use super::weld::weld;
use super::{MeshError, MeshOptions, RawMesh, read_mesh};
use std::path::Path;
use taffeta::topology::{Polygons, Surface, Uvs};

/// Builds a surface from vertices [m] and faces: welds, triangulates, drops what has no area or is there twice, splits,
/// orients. Says in `repairs` what it did.
///
/// ```
/// use taffeta::topology::Polygons;
/// use taffeta_io::surface_from;
///
/// // A square metre, whose lower edge is a group that pins can select.
/// let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
/// let mut faces = Polygons::default();
/// faces.push(&[0, 1, 2, 3]);
/// let square = surface_from(corners, faces, None, vec![("hem".to_owned(), vec![0, 1])])?;
/// assert_eq!((square.nodes.len(), square.triangles.len()), (4, 2));
/// # Ok::<(), taffeta_io::MeshError>(())
/// ```
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
pub(super) fn build(raw: RawMesh, options: &MeshOptions) -> Result<Surface, MeshError> {
    build_moved(raw, options).map(|(surface, _)| surface)
}

/// As [`build`], and what was taken off all places [m].
pub(super) fn build_moved(raw: RawMesh, options: &MeshOptions) -> Result<(Surface, [f64; 3]), MeshError> {
    if raw.polygons.is_empty() {
        return Err(MeshError::new("no triangles: the mesh has no faces"));
    }
    check_counts(&raw)?;
    let at_rest = options.rest.map(|path| rest_places(path, options, &raw)).transpose()?;
    let RawMesh { mut vertices, polygons, uvs, groups, mut repairs } = raw;
    let shift = recentre(&mut vertices, &mut repairs)?;
    let (mut nodes, mut node_of_vertex) = weld(&vertices, &mut repairs);
    let (mut triangles, faulty) = match at_rest {
        None => Triangles::of_nodes(&polygons, &node_of_vertex, &nodes),
        Some(_) => Triangles::with_vertices(&polygons, &node_of_vertex, &vertices),
    };
    if faulty.crossed > 0 {
        repairs.push(format!(
            "not simple: {} a border that crosses itself",
            if faulty.crossed == 1 {
                "1 face has".to_owned()
            } else {
                format!("{} faces have", faulty.crossed)
            }
        ));
    }
    drop_flat(&mut triangles, &nodes, faulty.collapsed, &mut repairs);
    drop_duplicates(&mut triangles, nodes.len(), &mut repairs);
    if triangles.nodes.is_empty() {
        return Err(MeshError::new(match polygons.len() {
            1 => "no triangles: the only face has no area".to_owned(),
            count => format!("no triangles: none of the {count} faces has an area"),
        }));
    }
    let mut edges = Edges::of(nodes.len(), &triangles.nodes);
    edges.report(&triangles.nodes, &node_of_vertex, &mut repairs);
    let (mut parts, turned) = agree(&mut triangles, &mut edges, &mut repairs);
    if options.fill_holes && holes::fill(&mut triangles, &edges, &nodes, &node_of_vertex, &mut repairs) {
        edges = Edges::of(nodes.len(), &triangles.nodes);
        parts = Parts::of(&triangles.nodes, &edges);
    }
    bow_tie::split(&mut triangles.nodes, &edges, &mut nodes, &mut node_of_vertex, &polygons, &mut repairs);
    drop(edges);
    outward(&mut triangles, &parts, &nodes, &turned, &mut repairs);
    drop(parts);
    let rest = at_rest.map(|places| rest::of_triangles(&triangles, &places, &polygons)).transpose()?;
    let mut triangles = triangles.nodes;
    let (nodes, node_of_vertex) = compact(nodes, node_of_vertex, &mut triangles, &mut repairs);
    let links = Vec::new();
    let surface =
        Surface { vertices, polygons, uvs, groups, nodes, node_of_vertex, triangles, links, rest, repairs };
    Ok((surface, shift))
}

fn rest_places(path: &Path, options: &MeshOptions, mesh: &RawMesh) -> Result<Vec<[f64; 3]>, MeshError> {
    let rest = read_mesh(path, options)?;
    let mut places = rest::places(rest, ("rest shape", path), mesh.vertices.len(), &mesh.polygons)?;
    // Only differences count, so that it may be anywhere.
    recentre(&mut places, &mut Vec::new()).map_err(|error| error.in_file(&path.display().to_string()))?;
    Ok(places)
}

/// Gives each part one winding. Returns the parts and which triangles were turned.
fn agree(triangles: &mut Triangles, edges: &mut Edges, repairs: &mut Vec<String>) -> (Parts, Vec<bool>) {
    let mut parts = Parts::of(&triangles.nodes, edges);
    let twisted = parts.list.iter().filter(|part| part.twisted).count();
    if twisted > 0 {
        repairs
            .push(format!("not orientable: {} with a twist, like a Möbius strip", counted(twisted, "part")));
    }
    let turned = std::mem::take(&mut parts.turned);
    if turned.contains(&true) {
        (0..turned.len()).filter(|&triangle| turned[triangle]).for_each(|triangle| triangles.turn(triangle));
        edges.turn(&turned);
    }
    (parts, turned)
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
