//! From TOML or an object to a scene of the engine.

use crate::document::Document;
use crate::errors::{Failure, option};
use crate::mesh;
use js_sys::Uint8Array;
use taffeta::{BuildError, Options, Simulation};
use taffeta_io::scene::{UNWRITTEN, hint};
use taffeta_io::{Given, Loaded, load_given, parse_scene};
use wasm_bindgen::JsValue;
use wasm_bindgen::prelude::wasm_bindgen;

/// A scene that may be run, and where its values were written.
pub struct Read {
    pub loaded: Loaded,
    by_user: bool,
}

impl Read {
    /// Reads a scene with all that it names.
    pub fn of(scene: &JsValue, name: &str, sets: &[String], files: &Given) -> Result<Self, Failure> {
        let (by_user, text, meshes) = match scene.as_string() {
            Some(text) => (true, text, Vec::new()),
            None => {
                let Document { table, meshes } = Document::of(scene)?;
                let text = toml::to_string(&table).map_err(|error| Failure::scene(error.to_string()))?;
                (false, text, meshes)
            }
        };
        let name = if by_user { name } else { UNWRITTEN };
        let failed = |error| Failure::load(error, by_user);
        let mut loaded = parse_scene(&text, name, sets).map_err(failed)?;
        mesh::fill(&mut loaded.scene, meshes)?;
        load_given(&mut loaded, files).map_err(failed)?;
        Ok(Self { loaded, by_user })
    }

    /// Builds it.
    pub fn build(&self, options: &Options) -> Result<Simulation, Failure> {
        Simulation::new(&self.loaded.scene, options).map_err(|error| self.explain(&error))
    }

    /// Why the scene was not built, by its line if it has one.
    fn explain(&self, error: &BuildError) -> Failure {
        let BuildError::Scene(_) = error else { return error.clone().into() };
        let mut located = self.loaded.source.explain_build(error);
        located.message += &hint(error.advice(), option);
        Failure::load(located, self.by_user)
    }
}

/// Files by their names.
pub fn given(names: Vec<String>, bytes: &[Uint8Array]) -> Given {
    names.into_iter().zip(bytes.iter().map(Uint8Array::to_vec)).collect()
}

/// The names of the files that a scene reads: meshes, shapes at rest, poses, struts. What stands in for a mesh makes it needless.
#[wasm_bindgen(js_name = filesOf)]
pub fn files_of(scene: &JsValue, name: &str) -> Result<Vec<String>, JsValue> {
    let text = match scene.as_string() {
        Some(text) => text,
        None => {
            toml::to_string(&Document::of(scene)?.table).map_err(|error| Failure::scene(error.to_string()))?
        }
    };
    let loaded = parse_scene(&text, name, &[]).map_err(|error| Failure::load(error, true))?;
    Ok(named(&loaded))
}

fn named(loaded: &Loaded) -> Vec<String> {
    use taffeta::scene::Mesh;
    let file = |mesh: &Mesh| match mesh {
        Mesh::File(name) => Some(name.clone()),
        _ => None,
    };
    let mut names = Vec::new();
    for body in &loaded.scene.bodies {
        names.extend(file(&body.mesh));
        names.extend(body.rest_shape.clone());
        names.extend(body.springs.internal.as_ref().and_then(|internal| internal.file.clone()));
    }
    for collider in &loaded.scene.colliders {
        names.extend([&collider.mesh, &collider.convex].into_iter().flatten().filter_map(file));
        let poses = collider.poses.iter();
        names.extend(poses.flat_map(|poses| poses.file.iter().chain(&poses.files).cloned()));
    }
    names.sort();
    names.dedup();
    names
}
