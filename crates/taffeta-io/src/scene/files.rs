//! Loads what a scene names: meshes and lists of springs.

use super::colliders;
use super::folders::{Folders, Unusable};
use super::source::ListFile;
use super::{LoadError, Loaded, SceneSource, poses};
use crate::mesh::{MeshOptions, load_moved};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use taffeta::scene::{Body, Mesh};
use taffeta::topology::Surface;

/// Longest list of struts [byte]: some twenty million.
const LONGEST_LIST: u64 = 1 << 28;

/// What is wrong with a stand-in where no mesh file is named.
pub(super) const NOT_STOOD_IN_FOR: &str =
    "stands in for a mesh file that is not there, and no file is named; mesh.file would do, or leave it out";

/// Replaces the files that the scene names by what is in them.
pub(super) fn fill(loaded: &mut Loaded, folders: Folders<'_>) -> Result<(), LoadError> {
    let Loaded { scene, source, notes, files } = loaded;
    for (index, body) in scene.bodies.iter_mut().enumerate() {
        let path = format!("body[{index}]");
        fill_mesh(body, &path, &folders, source, notes)?;
        fill_pairs(body, &path, &folders, source)?;
    }
    for (index, collider) in scene.colliders.iter_mut().enumerate() {
        colliders::fill(collider, &format!("collider[{index}]"), &folders, source, notes)?;
    }
    files.extend(folders.used());
    Ok(())
}

fn fill_mesh(
    body: &mut Body,
    path: &str,
    folders: &Folders<'_>,
    source: &SceneSource,
    notes: &mut Vec<String>,
) -> Result<(), LoadError> {
    let stand_in = body.stand_in.take();
    if let Some(Mesh::File(_)) = stand_in {
        let message = "a stand-in must be there without a file: a grid, icosphere, torus, …";
        return Err(source.at_path(&format!("{path}.stand_in"), message));
    }
    let Mesh::File(name) = &body.mesh else {
        let needless = stand_in.map(|_| source.at_path(&format!("{path}.stand_in"), NOT_STOOD_IN_FOR));
        needless.map_or(Ok(()), Err)?;
        return fill_poses(body, [0.0; 3], path, folders, source);
    };
    let place = format!("{path}.mesh.file");
    match (folders.find(name), stand_in) {
        (Ok(file), _) => {
            let (surface, moved) = load(body, &file, path, folders, source)?;
            body.mesh = Mesh::Surface(Arc::new(surface));
            fill_poses(body, moved, path, folders, source)?;
        }
        (Err(Unusable::Missing(why)), Some(shape)) => {
            let who = if body.name.is_empty() { path } else { &body.name };
            let rest = match &body.rest_shape {
                Some(name) => format!(", and its rest shape `{name}` is not used"),
                None => String::new(),
            };
            notes.push(format!("body `{who}` uses its stand-in{rest}: {why}"));
            (body.mesh, body.rest_shape, body.fill_holes) = (shape, None, false);
            // They are those of the mesh that is not there.
            body.pins.iter_mut().for_each(|pin| pin.poses = None);
        }
        (Err(Unusable::Missing(why) | Unusable::Refused(why)), _) => {
            return Err(source.at_path(&place, why));
        }
    }
    Ok(())
}

/// Reads the poses that pins of a body follow, whose mesh was `moved` to the origin [m].
fn fill_poses(
    body: &mut Body,
    moved: [f64; 3],
    path: &str,
    folders: &Folders<'_>,
    source: &SceneSource,
) -> Result<(), LoadError> {
    for (index, pin) in body.pins.iter_mut().enumerate() {
        let Some(given) = &mut pin.poses else { continue };
        poses::fill(
            given,
            (Some(&body.mesh), moved),
            &format!("{path}.pin[{index}].poses"),
            folders,
            source,
        )?;
    }
    Ok(())
}

/// The mesh in `file`, with the body's rest shape, and what was taken off all its places [m].
fn load(
    body: &Body,
    file: &Path,
    path: &str,
    folders: &Folders<'_>,
    source: &SceneSource,
) -> Result<(Surface, [f64; 3]), LoadError> {
    let rest_key = format!("{path}.rest_shape");
    let rest = body.rest_shape.as_ref().map(|name| found(folders, name, &rest_key, source)).transpose()?;
    let options = MeshOptions { fill_holes: body.fill_holes, rest: rest.as_deref(), ..folders.options() };
    load_moved(file, &options).map_err(|error| {
        let in_rest = rest.is_some_and(|rest| error.file == rest.display().to_string());
        let key = if in_rest { rest_key } else { format!("{path}.mesh.file") };
        source.at_path(&key, error.to_string())
    })
}

/// The file that the scene calls `name` at `key`.
pub(super) fn found(
    folders: &Folders<'_>,
    name: &str,
    key: &str,
    source: &SceneSource,
) -> Result<PathBuf, LoadError> {
    folders.find(name).map_err(|unusable| {
        let (Unusable::Missing(why) | Unusable::Refused(why)) = unusable;
        source.at_path(key, why)
    })
}

fn fill_pairs(
    body: &mut Body,
    path: &str,
    folders: &Folders<'_>,
    source: &mut SceneSource,
) -> Result<(), LoadError> {
    let Some(internal) = &mut body.springs.internal else { return Ok(()) };
    let Some(name) = &internal.file else { return Ok(()) };
    let place = format!("{path}.springs.internal.file");
    let file = found(folders, name, &place, source)?;
    let refuse = |what: String| source.at_path(&place, format!("{}: {what}", file.display()));
    let unread = |error: std::io::Error| refuse(format!("cannot be read: {error}"));
    let bytes = folders.read(&file, LONGEST_LIST + 1).map_err(unread)?;
    if bytes.len() as u64 > LONGEST_LIST {
        return Err(refuse(format!("has more than {LONGEST_LIST} bytes; fewer struts would do")));
    }
    let text = String::from_utf8(bytes).map_err(|_| refuse("is not text in UTF-8".to_owned()))?;
    let (pairs, lines) = read_pairs(&text, &file.display().to_string())?;
    internal.pairs = Some(pairs);
    source.lists.push(ListFile {
        path: format!("{path}.springs.internal.pairs"),
        file: file.display().to_string(),
        lines,
    });
    Ok(())
}

/// Pairs of node indices, and the line of each, from 1.
pub type Pairs = (Vec<[u32; 2]>, Vec<u32>);

/// Reads a list of struts: two node indices a line; `#` starts a comment. Errors call it `file`.
///
/// ```
/// let (pairs, lines) = taffeta_io::read_pairs("# across the belly\n0 17\n4 21\n", "struts.txt")?;
/// assert_eq!((pairs, lines), (vec![[0, 17], [4, 21]], vec![2, 3]));
/// # Ok::<(), taffeta_io::LoadError>(())
/// ```
pub fn read_pairs(text: &str, file: &str) -> Result<Pairs, LoadError> {
    let (mut pairs, mut lines) = (Vec::new(), Vec::new());
    let mut offset = 0;
    for (line, number) in text.split_inclusive('\n').zip(1..) {
        let words = line.split('#').next().unwrap_or("").trim();
        let mut numbers = words.split([' ', '\t', ',']).filter(|w| !w.is_empty()).map(str::parse::<u32>);
        match [numbers.next(), numbers.next(), numbers.next()] {
            [None, ..] => {}
            [Some(Ok(a)), Some(Ok(b)), None] => {
                pairs.push([a, b]);
                lines.push(number);
            }
            _ => {
                let shown: String = words.chars().take(40).collect();
                let what = format!("`{shown}` is not two node indices, counted from 0, as in `4 17`");
                return Err(LoadError::in_text(file, text, offset, what));
            }
        }
        offset += line.len();
    }
    Ok((pairs, lines))
}

#[cfg(test)]
mod tests {
    use super::read_pairs;

    #[test]
    fn pairs_are_two_indices_a_line_and_errors_name_the_line() {
        let (pairs, lines) = read_pairs("# struts\n0 5\n\n 7\t2 # last\r\n", "s.txt").unwrap();
        assert_eq!((pairs, lines), (vec![[0, 5], [7, 2]], vec![2, 4]));
        let error = read_pairs("0 1\n2 -3\n", "s.txt").unwrap_err().to_string();
        assert!(error.starts_with("s.txt:2:1: `2 -3` is not two node indices"), "{error}");
        assert!(read_pairs("1 2 3", "s.txt").is_err());
    }
}
