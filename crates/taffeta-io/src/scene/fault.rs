//! What can be wrong with a document, first without a place (as serde reports it), then with one.

use super::document::{Node, Origin, Path, Value};
use super::words;
use std::fmt::{self, Display};

/// A mistake in a document; `origin` is set where it passes the innermost value that it is about.
#[derive(Debug)]
pub(super) struct Fault {
    pub origin: Option<Origin>,
    pub what: What,
}

/// The mistake itself.
#[derive(Debug)]
pub(super) enum What {
    /// In words, complete.
    Said(String),
    /// A key that the table does not have.
    UnknownKey { key: String, valid: &'static [&'static str] },
    /// A word that is not among the choices.
    UnknownWord { word: String, valid: &'static [&'static str] },
    /// A key that the table must have.
    Missing(&'static str),
    /// The value is not what serde expected (its words).
    NotA(String),
    /// A list of the wrong length, with what was expected (serde's words).
    Length { found: usize, expected: String },
}

impl Fault {
    /// A mistake in words, with its place.
    pub fn new(origin: Origin, message: String) -> Self {
        Self { origin: Some(origin), what: What::Said(message) }
    }

    /// A mistake whose place is set later.
    pub fn of(what: What) -> Self {
        Self { origin: None, what }
    }

    /// The fault at `node`, unless it already has a place.
    pub fn at_value(self, node: &Node, path: Path) -> Self {
        let message = match self {
            Self { origin: Some(_), .. } => return self,
            Self { what: What::Said(message), .. } => format!("`{path}`: {message}"),
            Self { what: What::UnknownKey { key, valid }, .. } => words::unknown_key(&key, path, valid),
            Self { what: What::UnknownWord { word, valid }, .. } => words::unknown_word(&word, path, valid),
            Self { what: What::Missing(key), .. } if matches!(path, Path::Root) => {
                format!("missing key `{key}`")
            }
            Self { what: What::Missing(key), .. } => format!("missing key `{key}` in `{path}`"),
            Self { what: What::NotA(expected), .. } => {
                format!("`{path}` is {node}; expected {}", words::expected(&expected))
            }
            Self { what: What::Length { found, expected }, .. } => {
                format!("`{path}` has {found} entries; expected {}", words::expected(&expected))
            }
        };
        Self::new(node.origin, message)
    }

    /// The fault at a key of the table at `path`, unless it already has a place.
    pub fn at_key(self, origin: Origin, path: Path) -> Self {
        let node = Node { origin, value: Value::Table(Vec::new()) };
        self.at_value(&node, path)
    }
}

impl Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.what {
            What::Said(message) => f.write_str(message),
            other => write!(f, "{other:?}"),
        }
    }
}

impl std::error::Error for Fault {}

impl serde::de::Error for Fault {
    fn custom<T: Display>(message: T) -> Self {
        Self::of(What::Said(message.to_string()))
    }
    fn invalid_type(_found: serde::de::Unexpected, expected: &dyn serde::de::Expected) -> Self {
        Self::of(What::NotA(expected.to_string()))
    }
    fn invalid_value(_found: serde::de::Unexpected, expected: &dyn serde::de::Expected) -> Self {
        Self::of(What::NotA(expected.to_string()))
    }
    fn invalid_length(found: usize, expected: &dyn serde::de::Expected) -> Self {
        Self::of(What::Length { found, expected: expected.to_string() })
    }
    fn unknown_variant(word: &str, valid: &'static [&'static str]) -> Self {
        Self::of(What::UnknownWord { word: word.to_owned(), valid })
    }
    fn unknown_field(key: &str, valid: &'static [&'static str]) -> Self {
        Self::of(What::UnknownKey { key: key.to_owned(), valid })
    }
    fn missing_field(key: &'static str) -> Self {
        Self::of(What::Missing(key))
    }
}
