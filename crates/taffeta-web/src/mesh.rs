//! Meshes given as arrays: vertices and faces, flat or by row.

use crate::errors::Failure;
use js_sys::{Array, ArrayBuffer, Float64Array, Reflect};
use std::sync::Arc;
use taffeta::scene::{Mesh, Scene};
use taffeta::topology::Polygons;
use taffeta_io::surface_from;
use wasm_bindgen::{JsCast, JsValue};

/// A mesh as it was given, and where in the scene.
pub struct Arrays {
    path: String,
    vertices: Vec<[f64; 3]>,
    faces: Polygons,
}

const STAND_IN: &str = "\0arrays ";

/// The name that a mesh of arrays has in the text of a scene: no file is called so.
pub fn stand_in(index: usize) -> String {
    format!("{STAND_IN}{index}")
}

/// Whether a mesh may be given by arrays at a path.
pub fn is_key(path: &str) -> bool {
    matches!(path.rsplit('.').next(), Some("mesh" | "convex"))
}

/// Whether a value is a typed array.
pub fn is_typed(value: &JsValue) -> bool {
    ArrayBuffer::is_view(value) && !value.is_instance_of::<js_sys::DataView>()
}

impl Arrays {
    /// The mesh, if it is given as arrays: as an object with `vertices` and `faces`.
    pub fn of(value: &JsValue, path: &str) -> Result<Option<Self>, Failure> {
        let get = |key: &str| Reflect::get(value, &key.into()).unwrap_or_default();
        let (vertices, faces) = (get("vertices"), get("faces"));
        if vertices.is_undefined() && faces.is_undefined() {
            return Ok(None);
        }
        for (key, given) in [("vertices", &vertices), ("faces", &faces)] {
            if !Array::is_array(given) && !is_typed(given) {
                return Err(Failure::scene(format!("`{path}` has no `{key}`; an array would do")));
            }
        }
        if let Some(other) = js_sys::Object::keys(value.unchecked_ref::<js_sys::Object>())
            .iter()
            .filter_map(|key| key.as_string())
            .find(|key| key != "vertices" && key != "faces")
        {
            let what = format!("unknown key `{other}` in `{path}`. Valid beside arrays: vertices, faces");
            return Err(Failure::scene(what));
        }
        let numbers = flat(&vertices);
        let (rows, rest): (&[[f64; 3]], _) = numbers.as_chunks();
        if !rest.is_empty() {
            let what = format!("`{path}.vertices` has {} numbers; three a vertex would do", numbers.len());
            return Err(Failure::scene(what));
        }
        let faces = polygons(&faces, &format!("{path}.faces"))?;
        Ok(Some(Self { path: path.to_owned(), vertices: rows.to_vec(), faces }))
    }
}

/// Puts the meshes into the scene whose text names them.
pub fn fill(scene: &mut Scene, given: Vec<Arrays>) -> Result<(), Failure> {
    let mut given: Vec<Option<Arrays>> = given.into_iter().map(Some).collect();
    let bodies = scene.bodies.iter_mut().map(|body| &mut body.mesh);
    let colliders = scene.colliders.iter_mut().flat_map(|one| [&mut one.mesh, &mut one.convex]).flatten();
    for mesh in bodies.chain(colliders) {
        let Mesh::File(name) = &*mesh else { continue };
        let index = name.strip_prefix(STAND_IN).and_then(|index| index.parse::<usize>().ok());
        if let Some(Arrays { path, vertices, faces }) = index.and_then(|index| given.get_mut(index)?.take()) {
            let surface = surface_from(vertices, faces, None, Vec::new())
                .map_err(|error| Failure::scene(format!("`{path}`: {error}")))?;
            *mesh = Mesh::Surface(Arc::new(surface));
        }
    }
    Ok(())
}

/// Numbers of an array, or of one of rows; what is none is NaN.
pub fn flat(value: &JsValue) -> Vec<f64> {
    match value.dyn_ref::<Array>() {
        Some(rows) => Float64Array::new(&rows.flat(1)).to_vec(),
        None => Float64Array::new(value).to_vec(),
    }
}

/// Faces: three corners each of a flat array, or rows of three corners or more.
fn polygons(value: &JsValue, path: &str) -> Result<Polygons, Failure> {
    let mut faces = Polygons::default();
    let rows = value.dyn_ref::<Array>().filter(|rows| rows.length() > 0 && rows.get(0).is_object());
    let mut push = |face: usize, corners: &[f64]| {
        if corners.len() < 3 {
            let count = corners.len();
            return Err(Failure::scene(format!("`{path}[{face}]` has {count} corners; 3 or more would do")));
        }
        let index = |&corner: &f64| {
            let whole = corner.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&corner);
            whole.then_some(corner as u32).ok_or_else(|| {
                let what =
                    format!("`{path}[{face}]` names vertex {corner}; whole numbers from 0 on would do");
                Failure::scene(what)
            })
        };
        faces.push(&corners.iter().map(index).collect::<Result<Vec<u32>, _>>()?);
        Ok(())
    };
    match rows {
        Some(rows) => rows.iter().enumerate().try_for_each(|(face, row)| push(face, &flat(&row)))?,
        None => flat(value).chunks(3).enumerate().try_for_each(|(face, corners)| push(face, corners))?,
    }
    Ok(faces)
}
