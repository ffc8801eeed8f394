//! Loads what a scene names: meshes and lists of springs.

use super::folders::{Folders, Unusable};
use super::{LoadError, Loaded, SceneSource};
use crate::mesh::{MeshOptions, load_mesh};
use std::path::Path;
use std::sync::Arc;
use taffeta::scene::{Body, Mesh};

/// Replaces the files that the scene names by what is in them.
pub(super) fn fill(loaded: &mut Loaded, scene_file: &Path) -> Result<(), LoadError> {
    let folders = Folders::of(scene_file, std::env::var_os("TAFFETA_MODELS").map(Into::into));
    let Loaded { scene, source, notes } = loaded;
    for (index, body) in scene.bodies.iter_mut().enumerate() {
        let path = format!("body[{index}]");
        fill_mesh(body, &path, &folders, source, notes)?;
        fill_pairs(body, &path, &folders, source)?;
    }
    Ok(())
}

fn fill_mesh(
    body: &mut Body,
    path: &str,
    folders: &Folders,
    source: &SceneSource,
    notes: &mut Vec<String>,
) -> Result<(), LoadError> {
    let stand_in = body.stand_in.take();
    if let Some(Mesh::File(_)) = stand_in {
        let message = "a stand-in must be there without a file: a grid, icosphere, torus, …";
        return Err(source.at_path(&format!("{path}.stand_in"), message));
    }
    let Mesh::File(name) = &body.mesh else { return Ok(()) };
    let place = format!("{path}.mesh.file");
    match (folders.find(name), stand_in) {
        (Ok(file), _) => {
            let surface = load_mesh(&file, &MeshOptions::default())
                .map_err(|error| source.at_path(&place, error.to_string()))?;
            body.mesh = Mesh::Surface(Arc::new(surface));
        }
        (Err(Unusable::Missing(why)), Some(shape)) => {
            let who = if body.name.is_empty() { path } else { &body.name };
            notes.push(format!("body `{who}` uses its stand-in: {why}"));
            body.mesh = shape;
        }
        (Err(Unusable::Missing(why) | Unusable::Refused(why)), _) => {
            return Err(source.at_path(&place, why));
        }
    }
    Ok(())
}

fn fill_pairs(body: &mut Body, path: &str, folders: &Folders, source: &SceneSource) -> Result<(), LoadError> {
    let Some(internal) = &mut body.springs.internal else { return Ok(()) };
    let Some(name) = &internal.file else { return Ok(()) };
    let place = format!("{path}.springs.internal.file");
    let file = folders.find(name).map_err(|unusable| {
        let (Unusable::Missing(why) | Unusable::Refused(why)) = unusable;
        source.at_path(&place, why)
    })?;
    let text = std::fs::read_to_string(&file)
        .map_err(|error| source.at_path(&place, format!("{}: cannot be read: {error}", file.display())))?;
    internal.pairs = Some(read_pairs(&text, &file.display().to_string())?);
    Ok(())
}

/// Two node indices a line; `#` starts a comment.
fn read_pairs(text: &str, file: &str) -> Result<Vec<[u32; 2]>, LoadError> {
    let mut pairs = Vec::new();
    let mut offset = 0;
    for line in text.split_inclusive('\n') {
        let words = line.split('#').next().unwrap_or("").trim();
        let numbers: Vec<Option<u32>> =
            words.split([' ', '\t', ',']).filter(|w| !w.is_empty()).map(|w| w.parse().ok()).collect();
        match numbers.as_slice() {
            [] => {}
            [Some(a), Some(b)] => pairs.push([*a, *b]),
            _ => {
                let what = format!("`{words}` is not two node indices, counted from 0, as in `4 17`");
                return Err(LoadError::in_text(file, text, offset, what));
            }
        }
        offset += line.len();
    }
    Ok(pairs)
}

#[cfg(test)]
mod tests {
    use super::read_pairs;

    #[test]
    fn pairs_are_two_indices_a_line_and_errors_name_the_line() {
        assert_eq!(read_pairs("# struts\n0 5\n\n 7\t2 # last\r\n", "s.txt").unwrap(), [[0, 5], [7, 2]]);
        let error = read_pairs("0 1\n2 -3\n", "s.txt").unwrap_err().to_string();
        assert!(error.starts_with("s.txt:2:1: `2 -3` is not two node indices"), "{error}");
        assert!(read_pairs("1 2 3", "s.txt").is_err());
    }
}
