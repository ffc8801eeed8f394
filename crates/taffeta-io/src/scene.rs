//! Scenes from TOML: overrides, errors with file, line and column, and the files a scene names.

mod advice;
mod colliders;
mod document;
mod fault;
mod files;
mod folders;
mod overrides;
mod poses;
mod read;
mod source;
mod unused;
mod words;

pub use advice::{hint, key_of};
pub use files::read_pairs;
pub use poses::read_poses;
pub use source::{LoadError, Place, SceneSource, UNWRITTEN};

use crate::files::Given;
use crate::mesh::MeshFormat;
use folders::Folders;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use taffeta::scene::Scene;

/// A scene, and where each of its values came from.
///
/// ```
/// let text = "
/// [[body]]
/// name = 'flag'
/// mesh.grid = { rows = 20, cols = 30, size = [1.5, 1.0] }
/// area_density = 0.2
/// ";
/// let loaded = taffeta_io::parse_scene(text, "flag.toml", &["body.flag.area_density=0.3".to_owned()])?;
/// assert_eq!(loaded.scene.bodies[0].area_density, Some(0.3));
/// assert!(loaded.notes.is_empty());
/// # Ok::<(), taffeta_io::LoadError>(())
/// ```
#[derive(Debug)]
pub struct Loaded {
    /// The scene; meshes from files are `Mesh::Surface`.
    pub scene: Scene,
    /// Finds the line of a value.
    pub source: SceneSource,
    /// What the user should know, in words.
    pub notes: Vec<String>,
    /// Full paths of the files that were read: the scene, meshes, lists of struts.
    pub files: Vec<PathBuf>,
}

/// Longest scene [byte]: as a document it takes up to a hundred times as much memory.
const LARGEST: usize = 10_000_000;

/// The bytes of a file, up to one more than a scene may have.
fn read(path: &Path) -> std::io::Result<Vec<u8>> {
    crate::files::read(path, LARGEST as u64 + 1)
}

/// Reads a scene file, applies the overrides `sets` (each `PATH=VALUE`) and loads the files that it names.
///
/// ```no_run
/// let loaded = taffeta_io::load_scene("scenes/flag.toml".as_ref(), &["time.frames=10".to_owned()])?;
/// let mut simulation = taffeta::Simulation::new(&loaded.scene, &taffeta::Options::default())
///     .map_err(|error| loaded.source.explain_build(&error))?;
/// simulation.step()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn load_scene(path: &Path, sets: &[String]) -> Result<Loaded, LoadError> {
    let text = read_scene(path)?;
    let mut loaded = parse_scene(&text, &path.display().to_string(), sets)?;
    load_files(&mut loaded, path)?;
    Ok(loaded)
}

/// The text of a scene file, as [`parse_scene`] takes it.
///
/// ```
/// let error = taffeta_io::read_scene("bunny.ply".as_ref()).unwrap_err();
/// assert_eq!(error.to_string(), "bunny.ply: is a mesh and not a scene");
/// ```
pub fn read_scene(path: &Path) -> Result<String, LoadError> {
    let file = path.display().to_string();
    if MeshFormat::of(path).is_ok() {
        return Err(LoadError::in_file(&file, "is a mesh and not a scene"));
    }
    let bytes = read(path).map_err(|e| LoadError::in_file(&file, format!("cannot be read: {e}")))?;
    if bytes.len() > LARGEST {
        let message = format!(
            "has more than {LARGEST} bytes, the most that a scene may have; long lists of nodes are better groups of a \
             mesh file, and of struts a file of their own"
        );
        return Err(LoadError::in_file(&file, message));
    }
    String::from_utf8(bytes).map_err(|e| {
        let good = e.utf8_error().valid_up_to();
        let text = String::from_utf8_lossy(&e.as_bytes()[..good]).into_owned();
        LoadError::in_text(&file, &text, good, "is not UTF-8 from here on; save the file as UTF-8")
    })
}

/// Loads the files that a scene names; `path` is where the scene itself is, or would be.
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// std::fs::write(folder.path().join("kite.obj"), "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 3 2\n")?;
/// let text = "
/// [[body]]
/// mesh.file = 'kite.obj'
/// area_density = 0.05
/// ";
/// let mut loaded = taffeta_io::parse_scene(text, "kite.toml", &[])?;
/// taffeta_io::load_files(&mut loaded, &folder.path().join("kite.toml"))?;
/// assert_eq!(loaded.scene.bodies[0].mesh.nodes(), 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn load_files(loaded: &mut Loaded, path: &Path) -> Result<(), LoadError> {
    let models = std::env::var_os("TAFFETA_MODELS").map(Into::into);
    loaded.files.extend(path.canonicalize());
    files::fill(loaded, Folders::of(path, models))
}

/// Loads the files that a scene names from what is given, where there is no disk.
///
/// ```
/// let text = "
/// [[body]]
/// mesh.file = 'kite.obj'
/// area_density = 0.05
/// ";
/// let kite = b"v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 3 2\n".to_vec();
/// let given = [("kite.obj".to_owned(), kite)].into_iter().collect();
/// let mut loaded = taffeta_io::parse_scene(text, "kite.toml", &[])?;
/// taffeta_io::load_given(&mut loaded, &given)?;
/// assert_eq!(loaded.scene.bodies[0].mesh.nodes(), 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn load_given(loaded: &mut Loaded, given: &Given) -> Result<(), LoadError> {
    files::fill(loaded, Folders::given(given))
}

/// Reads a scene from `text`, which errors call `file_name`, and applies `sets`. Files that it names are not loaded.
///
/// ```
/// let text = "
/// [[body]]
/// mesh.grid = { rows = 4, cols = 5, size = [0.4, 0.3] }
/// mas = 1.0
/// ";
/// let error = taffeta_io::parse_scene(text, "flag.toml", &[]).unwrap_err();
/// assert!(error.to_string().starts_with("flag.toml:4:1: unknown key `mas` in `body[0]`; did you mean `mass`?"));
/// ```
pub fn parse_scene(text: &str, file_name: &str, sets: &[String]) -> Result<Loaded, LoadError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut source = SceneSource::new(file_name, text, sets);
    let mut root = document::parse(text).map_err(|fault| source.explain(fault))?;
    for (index, set) in sets.iter().enumerate() {
        overrides::apply(&mut root, index, set).map_err(|fault| source.explain(fault))?;
    }
    let notes = unused::set_aside(&mut root);
    let scene = Scene::deserialize(read::Reader::of(&root)).map_err(|fault| source.explain(fault))?;
    source.root = root;
    Ok(Loaded { scene, source, notes, files: Vec::new() })
}
