//! Meshes and poses of colliders.

use super::files::{NOT_STOOD_IN_FOR, found};
use super::folders::{Folders, Unusable};
use super::{LoadError, SceneSource, poses};
use crate::mesh::{MeshOptions, UNUSED, load_moved, load_pose, take_off};
use std::sync::Arc;
use taffeta::scene::{Collider, Mesh};
use taffeta::topology::Surface;

/// Replaces the files that a collider names by what is in them.
pub(super) fn fill(
    collider: &mut Collider,
    path: &str,
    folders: &Folders<'_>,
    source: &SceneSource,
    notes: &mut Vec<String>,
) -> Result<(), LoadError> {
    let stand_in = collider.stand_in.take();
    if let Some(Mesh::File(_)) = stand_in {
        let message = "a stand-in must be there without a file: a cube, icosphere, torus, …";
        return Err(source.at_path(&format!("{path}.stand_in"), message));
    }
    let meshes = [&collider.mesh, &collider.convex];
    if stand_in.is_some() && !meshes.into_iter().flatten().any(|mesh| matches!(mesh, Mesh::File(_))) {
        return Err(source.at_path(&format!("{path}.stand_in"), NOT_STOOD_IN_FOR));
    }
    let (fill_holes, who) = (collider.fill_holes, name(collider, path));
    let mut moved = [0.0; 3];
    for (key, mesh) in [("mesh", &mut collider.mesh), ("convex", &mut collider.convex)] {
        let Some(Mesh::File(name)) = mesh else { continue };
        let place = format!("{path}.{key}.file");
        match (folders.find(name), &stand_in) {
            (Ok(file), _) => {
                let options = MeshOptions { fill_holes, ..folders.options() };
                let (mut surface, shift) =
                    load_moved(&file, &options).map_err(|error| source.at_path(&place, error.to_string()))?;
                if key == "convex" {
                    surface.repairs.retain(|said| !said.ends_with(UNUSED));
                }
                (*mesh, moved) = (Some(Mesh::Surface(Arc::new(surface))), shift);
            }
            (Err(Unusable::Missing(why)), Some(shape)) => {
                notes.push(format!("collider `{who}` uses its stand-in: {why}"));
                *mesh = Some(shape.clone());
                // They are those of the mesh that is not there.
                (collider.poses, collider.fill_holes) = (None, false);
            }
            (Err(Unusable::Missing(why) | Unusable::Refused(why)), _) => {
                return Err(source.at_path(&place, why));
            }
        }
    }
    fill_poses(collider, moved, path, folders, source)
}

/// Its own name or, without one, its place in the scene.
fn name(collider: &Collider, path: &str) -> String {
    if collider.name.is_empty() { path.to_owned() } else { collider.name.clone() }
}

/// Reads the poses of a mesh, which all move as it was `moved` to the origin [m].
fn fill_poses(
    collider: &mut Collider,
    moved: [f64; 3],
    path: &str,
    folders: &Folders<'_>,
    source: &SceneSource,
) -> Result<(), LoadError> {
    let Some(poses) = &mut collider.poses else { return Ok(()) };
    let surface = match &collider.mesh {
        Some(Mesh::Surface(surface)) => surface,
        Some(_) => {
            let what =
                "`poses` are those of a mesh from a file, and this mesh is from none; mesh.file would do";
            return Err(source.at_path(&format!("{path}.poses"), what));
        }
        None => return Ok(()),
    };
    let mut all = Vec::new();
    if let Some(name) = &poses.file {
        let place = format!("{path}.poses.file");
        let file = found(folders, name, &place, source)?;
        all = poses::read(folders, &file, surface.vertices.len())
            .map_err(|what| source.at_path(&place, what))?;
    }
    for (index, name) in poses.files.iter().enumerate() {
        let place = format!("{path}.poses.files[{index}]");
        let file = found(folders, name, &place, source)?;
        let pose = load_pose(&file, &folders.options(), surface)
            .map_err(|error| source.at_path(&place, error.to_string()))?;
        all.push(pose);
    }
    all.iter_mut().for_each(|pose| take_off(pose, moved));
    let vertices = first_vertices(surface);
    let by_node =
        |pose: Vec<[f64; 3]>| Arc::new(vertices.iter().map(|&vertex| pose[vertex]).collect::<Vec<_>>());
    poses.nodes.extend(all.into_iter().map(by_node));
    Ok(())
}

/// A vertex at each node.
fn first_vertices(surface: &Surface) -> Vec<usize> {
    let Some(nodes) = &surface.node_of_vertex else { return (0..surface.nodes.len()).collect() };
    let mut first = vec![None; surface.nodes.len()];
    for (vertex, &node) in nodes.iter().enumerate().rev().filter(|(_, node)| **node != u32::MAX) {
        first[node as usize] = Some(vertex);
    }
    let of = |(node, vertex): (usize, Option<usize>)| {
        vertex.unwrap_or_else(|| surface.first_vertex_of(node as u32))
    };
    first.into_iter().enumerate().map(of).collect()
}
