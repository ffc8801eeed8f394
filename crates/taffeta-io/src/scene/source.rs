//! From a place in the scene back to the line that wrote it.

use super::advice::{hint, key_of};
use super::document::{Node, Origin, Value};
use super::fault::Fault;
use crate::program::one_line;
use std::fmt;
use taffeta::BuildError;
use taffeta::scene::SceneError;

/// Why a scene was not loaded.
///
/// ```
/// use taffeta_io::{Place, parse_scene};
///
/// let error = parse_scene("title = 'flag'\n[tim]\ndt = 0.01\n", "flag.toml", &[]).unwrap_err();
/// assert!(error.message.contains("did you mean `time`?"));
/// assert_eq!(error.place, Place::At { file: "flag.toml".to_owned(), line: 2, column: 2 });
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", one_line(&format!("{place}: {message}")))]
#[non_exhaustive]
pub struct LoadError {
    /// Where.
    pub place: Place,
    /// What it was and what would do.
    pub message: String,
}

/// What scenes are called that were not written as text, as an object of Python or JavaScript.
pub const UNWRITTEN: &str = "scene";

impl LoadError {
    /// What is wrong in words, and the file, line and column where it was written. In a scene that was not `written` as text, and is
    /// called [`UNWRITTEN`], they say nothing.
    ///
    /// ```
    /// use taffeta_io::parse_scene;
    ///
    /// let error = parse_scene("[tim]", "flag.toml", &[]).unwrap_err();
    /// assert_eq!(error.placed(true).1, Some(("flag.toml".to_owned(), 1, 2)));
    /// ```
    pub fn placed(self, written: bool) -> (String, Option<(String, usize, usize)>) {
        match &self.place {
            Place::At { file, line, column } if written || file != UNWRITTEN => {
                (self.to_string(), Some((file.clone(), *line, *column)))
            }
            Place::File(file) if written || file != UNWRITTEN => (self.to_string(), None),
            Place::At { .. } | Place::File(_) => (self.message, None),
            Place::Set(_) => (self.to_string(), None),
        }
    }
}

/// Where a mistake was written.
///
/// ```
/// use taffeta_io::{Place, parse_scene};
///
/// // An override that cannot be applied is named by its text, not by a line of the file.
/// let error = parse_scene("title = 'flag'", "flag.toml", &["time.dt=fast".to_owned()]).unwrap_err();
/// assert_eq!(error.place, Place::Set("time.dt=fast".to_owned()));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Place {
    /// A whole file.
    File(String),
    /// A character in a file; line and column count from 1.
    At {
        /// The file as the user named it.
        file: String,
        /// Line.
        line: usize,
        /// Column in characters.
        column: usize,
    },
    /// An override, with its text.
    Set(String),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::File(file) => f.write_str(file),
            Place::At { file, line, column } => write!(f, "{file}:{line}:{column}"),
            Place::Set(text) => match text.char_indices().nth(200) {
                Some((end, _)) => write!(f, "{}…", &text[..end]),
                None => f.write_str(text),
            },
        }
    }
}

impl LoadError {
    pub(super) fn in_file(file: &str, message: impl Into<String>) -> Self {
        Self { place: Place::File(file.to_owned()), message: message.into() }
    }

    pub(super) fn in_text(file: &str, text: &str, offset: usize, message: impl Into<String>) -> Self {
        let before = &text.as_bytes()[..offset.min(text.len())];
        let line_start = before.iter().rposition(|&b| b == b'\n').map_or(0, |newline| newline + 1);
        // Every byte that does not continue a character starts one.
        let column = before[line_start..].iter().filter(|&&b| b & 0xC0 != 0x80).count() + 1;
        let line = before.iter().filter(|&&b| b == b'\n').count() + 1;
        Self { place: Place::At { file: file.to_owned(), line, column }, message: message.into() }
    }
}

/// The text of a scene and of its overrides, to find where a value was written.
///
/// ```
/// use taffeta::{Options, Simulation};
///
/// let text = "
/// [[body]]
/// mesh.grid = { rows = 4, cols = 5, size = [0.4, 0.3] }
/// area_density = -0.2
/// ";
/// let loaded = taffeta_io::parse_scene(text, "flag.toml", &[])?;
/// let Err(error) = Simulation::new(&loaded.scene, &Options::default()) else { panic!("it has no mass") };
/// let error = loaded.source.explain_build(&error);
/// assert!(error.to_string().starts_with("flag.toml:4:"));
/// # Ok::<(), taffeta_io::LoadError>(())
/// ```
#[derive(Clone, Debug)]
pub struct SceneSource {
    file: String,
    text: String,
    sets: Vec<String>,
    pub(super) root: Node,
    pub(super) lists: Vec<ListFile>,
}

/// A list that the scene takes from a file of its own.
#[derive(Clone, Debug)]
pub(super) struct ListFile {
    /// Its place in the scene: `body[0].springs.internal.pairs`.
    pub path: String,
    /// The file.
    pub file: String,
    /// The line of each item, from 1.
    pub lines: Vec<u32>,
}

impl ListFile {
    /// Where the item at `path` of the scene was written.
    fn place(&self, path: &str) -> Option<Place> {
        let index = path.strip_prefix(&self.path)?.strip_prefix('[')?.strip_suffix(']')?;
        let line = *self.lines.get(index.parse::<usize>().ok()?)? as usize;
        Some(Place::At { file: self.file.clone(), line, column: 1 })
    }
}

impl SceneSource {
    pub(super) fn new(file: &str, text: &str, sets: &[String]) -> Self {
        let root = Node { origin: Origin::File(0), value: Value::Table(Vec::new()) };
        Self { file: file.to_owned(), text: text.to_owned(), sets: sets.to_vec(), root, lists: Vec::new() }
    }

    /// The engine's objection at the line, or override, of the value; of the nearest table above it that exists where
    /// the scene does not give the value. For an item of a list from a file of its own, its line there.
    pub fn locate(&self, error: &SceneError) -> LoadError {
        let message = format!("{}{}", error.message, hint(&error.advice, key_of));
        if let Some(place) = self.lists.iter().find_map(|list| list.place(&error.path)) {
            return LoadError { place, message };
        }
        self.at_path(&error.path, format!("`{}`: {message}", error.path))
    }

    /// Why the scene was not built: an objection at its line, anything else by the file.
    pub fn explain_build(&self, error: &BuildError) -> LoadError {
        match error {
            BuildError::Scene(error) => self.locate(error),
            error => LoadError::in_file(&self.file, error.to_string()),
        }
    }

    pub(super) fn at_path(&self, path: &str, message: impl Into<String>) -> LoadError {
        let mut node = &self.root;
        for step in path.split(['.', '[']).map(|step| step.trim_end_matches(']')) {
            let next = match &node.value {
                Value::Table(entries) => entries.iter().find(|e| e.key == step).map(|e| &e.node),
                Value::List(items) => step.parse::<usize>().ok().and_then(|index| items.get(index)),
                _ => None,
            };
            match next {
                Some(next) => node = next,
                None => break,
            }
        }
        self.error_at(node.origin, message)
    }

    pub(super) fn explain(&self, fault: Fault) -> LoadError {
        self.error_at(fault.origin.unwrap_or(Origin::File(0)), fault.to_string())
    }

    fn error_at(&self, origin: Origin, message: impl Into<String>) -> LoadError {
        match origin {
            Origin::File(offset) => LoadError::in_text(&self.file, &self.text, offset, message),
            Origin::Set(index) => {
                let text = self.sets.get(index).cloned().unwrap_or_default();
                LoadError { place: Place::Set(text), message: message.into() }
            }
        }
    }
}
