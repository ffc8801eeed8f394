//! Meshes and poses of colliders.

use super::files::NOT_STOOD_IN_FOR;
use super::folders::{Folders, Unusable};
use super::{LoadError, SceneSource, poses};
use crate::mesh::{MeshOptions, UNUSED, load_moved};
use std::sync::Arc;
use taffeta::scene::{Collider, Mesh};

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
    let (path, mesh) = (format!("{path}.poses"), collider.mesh.as_ref());
    collider.poses.as_mut().map_or(Ok(()), |given| poses::fill(given, (mesh, moved), &path, folders, source))
}

/// Its own name or, without one, its place in the scene.
fn name(collider: &Collider, path: &str) -> String {
    if collider.name.is_empty() { path.to_owned() } else { collider.name.clone() }
}
