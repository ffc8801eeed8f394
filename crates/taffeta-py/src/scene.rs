//! From what the Python class `Scene` holds to a scene of the engine.

use crate::document::{self, Document};
use crate::errors::{Failure, advised, argument, guarded};
use crate::mesh::{self, Given};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use taffeta::BuildError;
use taffeta_io::program::short_of_memory;
use taffeta_io::scene::{UNWRITTEN, hint};
use taffeta_io::{Loaded, load_files, parse_scene, read_scene};

/// What the Python class has of a scene: a text that the user wrote, or a dict.
#[derive(FromPyObject)]
pub struct Parts<'py> {
    /// TOML, as long as nothing has been changed.
    #[pyo3(attribute("_text"))]
    text: Option<String>,
    /// What was built; otherwise what the text says.
    #[pyo3(attribute("_data"))]
    data: Bound<'py, PyAny>,
    /// What messages call the text.
    #[pyo3(attribute("_name"))]
    name: String,
    /// Where the files lie that the scene names.
    #[pyo3(attribute("_folder"))]
    folder: PathBuf,
    /// Overrides, each `PATH=VALUE`.
    #[pyo3(attribute("_overrides"))]
    overrides: Vec<String>,
    /// Whether meshes of arrays are left unread.
    #[pyo3(default, attribute("_skips_arrays"))]
    skips_arrays: bool,
}

/// The same without Python: a text, and the meshes that are no part of it.
pub struct Written {
    text: String,
    meshes: Vec<Given>,
    name: String,
    folder: PathBuf,
    overrides: Vec<String>,
    /// Whether the user has written the text.
    by_user: bool,
}

/// A scene that may be run, and where its values were written.
pub struct Read {
    pub loaded: Loaded,
    by_user: bool,
}

impl Parts<'_> {
    /// Writes it as text, if it is none.
    pub fn write(self) -> Result<Written, Failure> {
        let Self { text, data, name, folder, overrides, skips_arrays } = self;
        let (by_user, text, meshes) = match text {
            Some(text) => (true, text, Vec::new()),
            None => {
                let Document { table, meshes, .. } = Document::of(&data, skips_arrays)?;
                (false, toml::to_string(&table).map_err(|error| Failure::scene(error.to_string()))?, meshes)
            }
        };
        let name = if by_user { name } else { UNWRITTEN.to_owned() };
        Ok(Written { text, meshes, name, folder, overrides, by_user })
    }
}

impl Written {
    /// Reads it, without the files that it names.
    fn parse(&self) -> Result<Read, Failure> {
        let loaded = parse_scene(&self.text, &self.name, &self.overrides);
        let loaded = loaded.map_err(|error| Failure::load(error, self.by_user))?;
        Ok(Read { loaded, by_user: self.by_user })
    }

    /// Reads it with all that it names, and refuses what does not fit into memory.
    pub fn read(self) -> Result<Read, Failure> {
        let mut read = self.parse()?;
        let file = Path::new(&self.name).file_name().unwrap_or(UNWRITTEN.as_ref());
        mesh::fill(&mut read.loaded.scene, self.meshes)?;
        load_files(&mut read.loaded, &self.folder.join(file))
            .map_err(|error| Failure::load(error, self.by_user))?;
        match short_of_memory(&read.loaded.scene, false) {
            Some((why, advice)) => Err(Failure::scene(advised(why, &advice))),
            None => Ok(read),
        }
    }
}

impl Read {
    /// Why the scene was not built, by its line if it has one.
    pub fn explain(&self, error: &BuildError) -> Failure {
        let BuildError::Scene(_) = error else { return error.clone().into() };
        let mut located = self.loaded.source.explain_build(error);
        located.message += &hint(error.advice(), argument);
        Failure::load(located, self.by_user)
    }
}

/// Whether a scene can be read; files that it names are not looked for, and its arrays only if that is asked for.
#[pyfunction]
#[pyo3(signature = (parts, /, *, arrays=false))]
pub fn check(mut parts: Parts<'_>, arrays: bool) -> PyResult<()> {
    parts.skips_arrays = !arrays;
    Ok(guarded(|| parts.write()?.parse().map(drop))?)
}

/// Whether a mesh is one, if it is given as arrays; `path` is its place in the scene.
#[pyfunction]
pub fn check_mesh(mesh: &Bound<'_, PyAny>, path: &str) -> PyResult<()> {
    Ok(guarded(|| Given::of(mesh, path)?.map_or(Ok(()), |given| given.surface().map(drop)))?)
}

/// The text of a scene file.
#[pyfunction]
pub fn read_text(py: Python<'_>, path: PathBuf) -> PyResult<String> {
    let text = py.detach(|| read_scene(&path));
    Ok(text.map_err(|error| Failure::load(error, true))?)
}

/// What a TOML text says, as a dict.
#[pyfunction]
pub fn parse_toml<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let table = text.parse::<toml::Table>().map_err(|error| Failure::scene(error.to_string()))?;
    document::to_python(py, &toml::Value::Table(table))
}

/// A dict as TOML. Meshes of arrays have no text.
#[pyfunction]
pub fn format_toml(data: &Bound<'_, PyAny>) -> PyResult<String> {
    let Document { table, meshes, .. } = Document::of(data, false)?;
    if !meshes.is_empty() {
        let what = "a mesh that is given as arrays has no text; a mesh file would have";
        return Err(Failure::scene(what).into());
    }
    Ok(toml::to_string(&table).map_err(|error| Failure::scene(error.to_string()))?)
}

/// A value as TOML, on one line if it has no text of several.
#[pyfunction]
pub fn format_value(value: &Bound<'_, PyAny>) -> PyResult<String> {
    let whole = PyDict::new(value.py());
    whole.set_item("value", value)?;
    let Document { table, .. } = Document::of(whole.as_any(), false)?;
    let value = table.get("value").ok_or_else(|| Failure::scene("a value that is None has no text"))?;
    Ok(value.to_string())
}

/// A dict as a table.
pub fn table(data: &Bound<'_, PyDict>) -> Result<toml::Table, Failure> {
    Ok(Document::of(data.as_any(), false)?.table)
}
