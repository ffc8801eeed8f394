//! Meshes given as arrays: vertices and faces, with texture coordinates and groups if there are some.

use crate::errors::Failure;
use pyo3::prelude::*;
use pyo3::types::PyMapping;
use std::sync::Arc;
use taffeta::scene::{Mesh, Scene, Surface};
use taffeta::topology::{Polygons, Uvs};
use taffeta_io::surface_from;

/// Keys of a mesh that is given as arrays.
const KEYS: [&str; 4] = ["vertices", "faces", "uvs", "groups"];

/// Named sets of vertices.
type Groups = Vec<(String, Vec<u32>)>;

/// A mesh as it was given, and where in the scene.
pub struct Given {
    path: String,
    vertices: Vec<[f64; 3]>,
    faces: Polygons,
    uvs: Option<Uvs>,
    groups: Groups,
}

/// The name that a mesh of arrays has in the text of a scene: no file is called so.
pub fn stand_in(index: usize) -> String {
    format!("{STAND_IN}{index}")
}

const STAND_IN: &str = "\0arrays ";

impl Given {
    /// Whether a mesh is given as arrays: as a dict with vertices and faces, or an object that has them, as those of trimesh.
    pub fn is_mesh(value: &Bound<'_, PyAny>) -> Result<bool, Failure> {
        Ok(match value.cast::<PyMapping>() {
            Ok(mapping) => mapping.contains("vertices")? || mapping.contains("faces")?,
            Err(_) => value.hasattr("vertices")? && value.hasattr("faces")?,
        })
    }

    /// The mesh, if it is given as arrays.
    pub fn of(value: &Bound<'_, PyAny>, path: &str) -> Result<Option<Self>, Failure> {
        if !Self::is_mesh(value)? {
            return Ok(None);
        }
        let (vertices, faces, mut uvs, mut groups) = match value.cast::<PyMapping>() {
            Ok(mapping) => {
                refuse_others(mapping, path)?;
                let get = |key: &str| mapping.get_item(key).ok();
                (get("vertices"), get("faces"), get("uvs"), get("groups"))
            }
            Err(_) => (Some(value.getattr("vertices")?), Some(value.getattr("faces")?), None, None),
        };
        let missing = |key| move || Failure::scene(format!("`{path}` has no `{key}`; an array would do"));
        let vertices = vertices.ok_or_else(missing("vertices"))?;
        let faces = faces.ok_or_else(missing("faces"))?;
        uvs = uvs.filter(|uvs| !uvs.is_none());
        groups = groups.filter(|groups| !groups.is_none());
        let vertices: Vec<[f64; 3]> = rows(&vertices, &format!("{path}.vertices"))?;
        let faces = polygons(&faces, &format!("{path}.faces"))?;
        let uvs = uvs.map(|uvs| texture(&uvs, &format!("{path}.uvs"), vertices.len(), &faces)).transpose()?;
        let groups =
            groups.map_or_else(|| Ok(Vec::new()), |groups| named(&groups, &format!("{path}.groups")))?;
        Ok(Some(Self { path: path.to_owned(), vertices, faces, uvs, groups }))
    }

    /// The surface that can be simulated.
    pub fn surface(self) -> Result<Surface, Failure> {
        let Self { path, vertices, faces, uvs, groups } = self;
        surface_from(vertices, faces, uvs, groups)
            .map_err(|error| Failure::scene(format!("`{path}`: {error}")))
    }
}

/// Puts the meshes into the scene whose text names them.
pub fn fill(scene: &mut Scene, given: Vec<Given>) -> Result<(), Failure> {
    let mut given: Vec<Option<Given>> = given.into_iter().map(Some).collect();
    let bodies = scene.bodies.iter_mut().map(|body| &mut body.mesh);
    let colliders = scene.colliders.iter_mut().flat_map(|one| [&mut one.mesh, &mut one.convex]).flatten();
    for mesh in bodies.chain(colliders) {
        let Mesh::File(name) = &*mesh else { continue };
        let index = name.strip_prefix(STAND_IN).and_then(|index| index.parse::<usize>().ok());
        if let Some(one) = index.and_then(|index| given.get_mut(index)?.take()) {
            *mesh = Mesh::Surface(Arc::new(one.surface()?));
        }
    }
    Ok(())
}

fn refuse_others(mapping: &Bound<'_, PyMapping>, path: &str) -> Result<(), Failure> {
    for key in mapping.keys()?.iter() {
        let key = key.str()?.to_string();
        if !KEYS.contains(&key.as_str()) {
            let valid = KEYS.join(", ");
            return Err(Failure::scene(format!(
                "unknown key `{key}` in `{path}`. Valid beside arrays: {valid}"
            )));
        }
    }
    Ok(())
}

/// What numpy makes of a value, as lists of Python: one way for arrays, tensors and lists alike.
fn array<'py>(value: &Bound<'py, PyAny>, kind: &str, path: &str) -> Result<Bound<'py, PyAny>, Failure> {
    let numpy = value.py().import("numpy")?;
    let array = numpy.call_method1("asarray", (value,)).and_then(|array| {
        let of_kind = array.getattr("dtype")?.getattr("kind")?.extract::<String>()?;
        let fits = if kind == "f8" { "fiu" } else { "iu" }.contains(&of_kind);
        let array = numpy.call_method1("ascontiguousarray", (&array, kind));
        if fits { array } else { Err(pyo3::exceptions::PyTypeError::new_err("numbers")) }
    });
    let what = if kind == "f8" { "numbers" } else { "whole numbers" };
    array.map_err(|_| Failure::scene(format!("`{path}` is no array of {what}")))
}

/// An array [n, N].
fn rows<const N: usize>(value: &Bound<'_, PyAny>, path: &str) -> Result<Vec<[f64; N]>, Failure> {
    let array = array(value, "f8", path)?;
    let shape: Vec<usize> = array.getattr("shape")?.extract()?;
    if shape.len() != 2 || shape[1] != N {
        return Err(Failure::scene(format!("`{path}` has the shape {shape:?}; [n, {N}] would do")));
    }
    let array = array.cast_into::<numpy::PyArray2<f64>>().map_err(PyErr::from)?;
    let numbers = numpy::PyArrayMethods::to_vec(&array).map_err(|error| Failure::input(error.to_string()))?;
    Ok(numbers.as_chunks().0.to_vec())
}

/// Faces: an array [m, corners], or lists of different lengths.
fn polygons(value: &Bound<'_, PyAny>, path: &str) -> Result<Polygons, Failure> {
    let mut faces = Polygons::default();
    if let Ok(array) = array(value, "i8", path) {
        let shape: Vec<usize> = array.getattr("shape")?.extract()?;
        if shape.len() != 2 || shape[1] < 3 {
            return Err(Failure::scene(format!(
                "`{path}` has the shape {shape:?}; [n, 3] or [n, 4] would do"
            )));
        }
        let array = array.cast_into::<numpy::PyArray2<i64>>().map_err(PyErr::from)?;
        let numbers =
            numpy::PyArrayMethods::to_vec(&array).map_err(|error| Failure::input(error.to_string()))?;
        numbers.chunks(shape[1]).enumerate().try_for_each(|(face, corners)| {
            faces.push(&indices(corners, path, face)?);
            Ok::<(), Failure>(())
        })?;
        return Ok(faces);
    }
    let lists = value.extract::<Vec<Vec<i64>>>();
    let lists = lists
        .map_err(|_| Failure::scene(format!("`{path}` is no array of whole numbers, and no list of such")))?;
    for (face, corners) in lists.iter().enumerate() {
        if corners.len() < 3 {
            let count = corners.len();
            return Err(Failure::scene(format!("`{path}[{face}]` has {count} corners; 3 or more would do")));
        }
        faces.push(&indices(corners, path, face)?);
    }
    Ok(faces)
}

fn indices(corners: &[i64], path: &str, row: usize) -> Result<Vec<u32>, Failure> {
    let index = |&corner: &i64| {
        u32::try_from(corner)
            .map_err(|_| Failure::scene(format!("`{path}[{row}]` names vertex {corner}; 0 or more would do")))
    };
    corners.iter().map(index).collect()
}

/// Texture coordinates by vertex.
fn texture(value: &Bound<'_, PyAny>, path: &str, vertices: usize, faces: &Polygons) -> Result<Uvs, Failure> {
    let coords = rows::<2>(value, path)?;
    if coords.len() != vertices {
        let what =
            format!("`{path}` has {} rows; one for each of {vertices} vertices would do", coords.len());
        return Err(Failure::scene(what));
    }
    let coords = coords.into_iter().map(|uv| uv.map(|c| c as f32)).collect();
    Ok(Uvs { coords, corners: faces.corners.clone() })
}

/// Groups: names with lists of vertices.
fn named(value: &Bound<'_, PyAny>, path: &str) -> Result<Groups, Failure> {
    let unfit = |_| Failure::scene(format!("`{path}` is no dict of names with lists of vertices"));
    let mapping = value.cast::<PyMapping>().map_err(|error| unfit(error.into()))?;
    let of = |item: Bound<'_, PyAny>| {
        let (name, members): (String, Bound<'_, PyAny>) = item.extract().map_err(unfit)?;
        let members = array(&members, "i8", &format!("{path}.{name}"))?.call_method0("tolist")?;
        let members: Vec<i64> = members.extract().map_err(unfit)?;
        let members = indices(&members, &format!("{path}.{name}"), 0)?;
        Ok((name, members))
    };
    mapping.items()?.iter().map(of).collect()
}
