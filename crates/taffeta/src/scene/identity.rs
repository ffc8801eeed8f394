//! Whether two scenes are the same, and where they differ.

use crate::scene::{Mesh, Poses, Scene, Surface};
use serde_json::Value;
use std::hash::Hasher;
use twox_hash::XxHash64;

/// A scene as text, the same for scenes that run the same. What comes from files (surfaces, poses, struts) stands as a hash; title and
/// number of frames are left out, for a run may go on for longer.
///
/// ```
/// use taffeta::scene::{Scene, identity};
///
/// let (mut short, mut long) = (Scene::new("first try"), Scene::new("all of it"));
/// (short.time.frames, long.time.frames) = (60, 600);
/// assert_eq!(identity(&short), identity(&long));
/// ```
pub fn identity(scene: &Scene) -> String {
    let mut plain = scene.clone();
    plain.title = String::new();
    plain.time.frames = 0;
    for body in &mut plain.bodies {
        [Some(&mut body.mesh), body.stand_in.as_mut()].into_iter().flatten().for_each(hash_surface);
        if let Some(internal) = &mut body.springs.internal
            && let Some(pairs) = internal.pairs.take()
        {
            let mut hash = Hash::default();
            hash.list(pairs.as_flattened().iter().map(|&i| u64::from(i)));
            internal.file = Some(format!("struts with hash {:016x}", hash.0.finish()));
        }
        body.pins.iter_mut().filter_map(|pin| pin.poses.as_mut()).for_each(hash_poses);
    }
    for collider in &mut plain.colliders {
        let meshes = [&mut collider.mesh, &mut collider.convex, &mut collider.stand_in];
        meshes.into_iter().flatten().for_each(hash_surface);
        collider.poses.iter_mut().for_each(hash_poses);
    }
    // Numbers, words, lists and tables with words as keys: nothing that JSON refuses.
    let mut value = serde_json::to_value(&plain).expect("a scene without data of files is text");
    unsign_zeros(&mut value);
    value.to_string()
}

/// A zero has no sign in what a scene means.
fn unsign_zeros(value: &mut Value) {
    match value {
        Value::Number(number) if number.as_f64() == Some(0.0) && number.is_f64() => *value = 0.0.into(),
        Value::Array(items) => items.iter_mut().for_each(unsign_zeros),
        Value::Object(items) => items.values_mut().for_each(unsign_zeros),
        _ => {}
    }
}

/// 64-bit hash of [`identity`].
pub(crate) fn identity_hash(scene: &Scene) -> u64 {
    XxHash64::oneshot(0, identity(scene).as_bytes())
}

/// Puts the hash of a surface in its place.
fn hash_surface(mesh: &mut Mesh) {
    if let Mesh::Surface(surface) = mesh {
        *mesh = Mesh::File(format!("a surface with hash {:016x}", surface_hash(surface)));
    }
}

/// Puts the hash of poses that are known in their place.
fn hash_poses(poses: &mut Poses) {
    if poses.nodes.is_empty() {
        return;
    }
    let mut hash = Hash::default();
    for nodes in std::mem::take(&mut poses.nodes) {
        hash.list(nodes.as_flattened().iter().map(|x| x.to_bits()));
    }
    (poses.file, poses.files) = (Some(format!("poses with hash {:016x}", hash.0.finish())), Vec::new());
}

/// The first place in which two scenes differ, in words; `None` where they are the same.
///
/// ```
/// use taffeta::scene::{Scene, difference, identity};
///
/// let before = Scene::new("on Earth");
/// let mut now = before.clone();
/// now.world.gravity = [0.0, -1.62, 0.0];
/// let what = difference(&identity(&before), &identity(&now));
/// assert_eq!(what.as_deref(), Some("`world.gravity[1]` was -9.81 and is -1.62"));
/// ```
pub fn difference(earlier: &str, now: &str) -> Option<String> {
    if earlier == now {
        return None;
    }
    let [earlier, now] = [earlier, now].map(|text| serde_json::from_str(text).unwrap_or(Value::Null));
    if earlier.is_null() || now.is_null() {
        return Some("it cannot be read".to_owned());
    }
    let mut path = Vec::new();
    let (was, is) = first_difference(&earlier, &now, &mut path)?;
    Some(format!("`{}` was {} and is {}", path.concat(), shown(was), shown(is)))
}

/// Descends to the first pair that differs; `path` is the way there.
fn first_difference<'a>(
    was: &'a Value,
    is: &'a Value,
    path: &mut Vec<String>,
) -> Option<(&'a Value, &'a Value)> {
    const NONE: &Value = &Value::Null;
    let steps: Vec<(String, &Value, &Value)> = match (was, is) {
        (Value::Object(a), Value::Object(b)) => {
            let keys = a.keys().chain(b.keys().filter(|key| !a.contains_key(*key)));
            let dot = if path.is_empty() { "" } else { "." };
            keys.map(|key| (format!("{dot}{key}"), a.get(key).unwrap_or(NONE), b.get(key).unwrap_or(NONE)))
                .collect()
        }
        (Value::Array(a), Value::Array(b)) => (0..a.len().max(b.len()))
            .map(|i| (format!("[{i}]"), a.get(i).unwrap_or(NONE), b.get(i).unwrap_or(NONE)))
            .collect(),
        _ => return (was != is).then_some((was, is)),
    };
    for (step, was, is) in steps {
        path.push(step);
        if let Some(found) = first_difference(was, is, path) {
            return Some(found);
        }
        path.pop();
    }
    None
}

fn shown(value: &Value) -> String {
    match value {
        Value::Null => "not given".to_owned(),
        Value::Object(_) => "given".to_owned(),
        Value::Array(items) => format!("a list of {}", items.len()),
        other => other.to_string(),
    }
}

/// A hash of lists.
#[derive(Default)]
struct Hash(XxHash64);

impl Hash {
    /// Adds a list and its length.
    fn list(&mut self, words: impl Iterator<Item = u64>) {
        let mut count = 0_u64;
        for word in words {
            self.0.write(&word.to_le_bytes());
            count += 1;
        }
        self.0.write(&count.to_le_bytes());
    }
}

/// 64-bit hash of all that a surface holds.
fn surface_hash(surface: &Surface) -> u64 {
    let mut hash = Hash::default();
    hash.list(surface.vertices.as_flattened().iter().map(|x| x.to_bits()));
    hash.list(surface.nodes.as_flattened().iter().map(|x| x.to_bits()));
    hash.list(surface.triangles.as_flattened().iter().map(|&i| u64::from(i)));
    hash.list(surface.links.as_flattened().iter().map(|&i| u64::from(i)));
    hash.list(surface.polygons.offsets.iter().map(|&i| u64::from(i)));
    hash.list(surface.polygons.corners.iter().map(|&i| u64::from(i)));
    hash.list(surface.node_of_vertex.iter().flatten().map(|&i| u64::from(i)));
    hash.list(surface.rest.iter().flatten().flatten().flatten().map(|x| x.to_bits()));
    if let Some(uvs) = &surface.uvs {
        hash.list(uvs.coords.as_flattened().iter().map(|x| x.to_bits().into()));
        hash.list(uvs.corners.iter().map(|&i| u64::from(i)));
    }
    for (name, members) in &surface.groups {
        hash.list(name.bytes().map(u64::from));
        hash.list(members.iter().map(|&i| u64::from(i)));
    }
    hash.0.finish()
}
