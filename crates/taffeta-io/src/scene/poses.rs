//! Poses from a PC2 file, the point cache of 3ds Max that Blender and Maya write: a header of 32 bytes, then 32-bit floats,
//! sample by sample, little endian.

use super::files::found;
use super::folders::Folders;
use super::{LoadError, SceneSource};
use crate::mesh::{load_pose, take_off};
use std::path::Path;
use std::sync::Arc;
use taffeta::scene::{Mesh, Poses};
use taffeta::topology::Surface;

const HEADER: usize = 32;
/// Most bytes of a file.
const LONGEST: u64 = 4 << 30;

/// Reads the poses at `path` of a mesh, which all move as it was moved to the origin [m].
pub(super) fn fill(
    poses: &mut Poses,
    (mesh, moved): (Option<&Mesh>, [f64; 3]),
    path: &str,
    folders: &Folders<'_>,
    source: &SceneSource,
) -> Result<(), LoadError> {
    let surface = match mesh {
        Some(Mesh::Surface(surface)) => surface,
        Some(_) => {
            let what =
                "`poses` are those of a mesh from a file, and this mesh is from none; mesh.file would do";
            return Err(source.at_path(path, what));
        }
        None => return Ok(()),
    };
    let mut all = Vec::new();
    if let Some(name) = &poses.file {
        let place = format!("{path}.file");
        let file = found(folders, name, &place, source)?;
        all = read(folders, &file, surface.vertices.len()).map_err(|what| source.at_path(&place, what))?;
    }
    for (index, name) in poses.files.iter().enumerate() {
        let place = format!("{path}.files[{index}]");
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

/// The samples of a file, each with a place [m] for each of so many `vertices`.
fn read(folders: &Folders<'_>, path: &Path, vertices: usize) -> Result<Vec<Vec<[f64; 3]>>, String> {
    let named = |what: String| format!("{}: {what}", path.display());
    let unread = |error: std::io::Error| named(format!("cannot be read: {error}"));
    let bytes = folders.read(path, LONGEST + 1).map_err(unread)?;
    if bytes.len() as u64 > LONGEST {
        return Err(named(format!("has more than {LONGEST} bytes; fewer samples would do")));
    }
    read_poses(&bytes, vertices).map_err(named)
}

/// Reads a PC2 file: its samples, each with a place [m] for each of so many `vertices`, as the file has them: also such as are no
/// numbers.
///
/// ```
/// let header = [1_i32, 1, 0, 0, 2].map(i32::to_le_bytes).concat();
/// let places = [0.0_f32, 1.0, 2.0, 0.0, 1.5, 2.0].map(f32::to_le_bytes).concat();
/// let poses = taffeta_io::read_poses(&[&b"POINTCACHE2\0"[..], &header, &places].concat(), 1)?;
/// assert_eq!(poses, vec![vec![[0.0, 1.0, 2.0]], vec![[0.0, 1.5, 2.0]]]);
/// # Ok::<(), String>(())
/// ```
///
/// # Errors
/// Says what of the file is not as it should be, to follow its name.
pub fn read_poses(bytes: &[u8], vertices: usize) -> Result<Vec<Vec<[f64; 3]>>, String> {
    if !bytes.starts_with(b"POINTCACHE2\0") || bytes.len() < HEADER {
        let message = "is no PC2 file: it does not begin with POINTCACHE2; poses.files = [\"a.obj\", …] would take a mesh a \
                       pose";
        return Err(message.to_owned());
    }
    let number = |at: usize| i32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
    let (version, points, count) = (number(12), number(16), number(28));
    if version != 1 {
        return Err(format!("is of version {version}; 1 would do"));
    }
    if usize::try_from(points) != Ok(vertices) {
        return Err(format!("has {points} points, the mesh {vertices} vertices; as many would do"));
    }
    let Some(count) = usize::try_from(count).ok().filter(|&count| count > 0) else {
        return Err(format!("says {count} samples; a file with one or more would do"));
    };
    if vertices == 0 {
        return Err("has no points; a file with as many as the mesh has vertices would do".to_owned());
    }
    let [have, need] = [bytes.len() - HEADER, count.saturating_mul(12 * vertices)];
    if have < need {
        return Err(format!("says {count} samples, {need} bytes, and has {have}; a whole file would do"));
    }
    let float = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let place = |b: &[u8]| [float(b), float(&b[4..]), float(&b[8..])];
    let sample = |b: &[u8]| b.chunks_exact(12).map(place).collect();
    Ok(bytes[HEADER..HEADER + need].chunks_exact(12 * vertices).map(sample).collect())
}

#[cfg(test)]
mod tests {
    use super::read_poses;

    fn file(points: i32, count: i32, numbers: &[f32]) -> Vec<u8> {
        let mut bytes = b"POINTCACHE2\0".to_vec();
        for word in [1, points, 0, 1.0_f32.to_bits() as i32, count] {
            bytes.extend(word.to_le_bytes());
        }
        numbers.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        bytes
    }

    #[test]
    fn samples_are_places_of_all_points() {
        let numbers: Vec<f32> = (0..12).map(|i| i as f32 / 4.0).collect();
        let poses = read_poses(&file(2, 2, &numbers), 2).unwrap();
        assert_eq!(poses[1], [[1.5, 1.75, 2.0], [2.25, 2.5, 2.75]]);
    }

    #[test]
    fn a_file_that_is_cut_off_or_of_another_mesh_is_refused() {
        let numbers = [0.0; 12];
        let refused = |bytes: &[u8], vertices| read_poses(bytes, vertices).unwrap_err();
        assert!(refused(&file(2, 3, &numbers), 2).contains("says 3 samples, 72 bytes, and has 48"));
        assert!(refused(&file(2, 2, &numbers), 3).contains("has 2 points, the mesh 3 vertices"));
        assert!(refused(&file(2, -1, &numbers), 2).contains("says -1 samples; a file with one or more"));
        assert!(refused(b"POINTCACHE2\0", 2).contains("no PC2 file"));
        assert!(refused(b"", 2).contains("no PC2 file"));
        assert!(refused(&file(0, 2, &[]), 0).contains("has no points"));
    }
}
