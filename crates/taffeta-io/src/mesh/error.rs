use std::borrow::Cow;
use std::fmt;

/// Why a mesh was refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshError {
    /// The file; empty for a mesh given as data.
    pub file: String,
    /// Line in the file, from 1, where the mistake has one.
    pub line: Option<usize>,
    /// What was found and what would do.
    pub message: String,
}

impl MeshError {
    pub(super) fn new(message: impl Into<String>) -> Self {
        Self { file: String::new(), line: None, message: message.into() }
    }

    pub(super) fn at_line(line: usize, message: impl Into<String>) -> Self {
        Self { line: Some(line), ..Self::new(message) }
    }

    /// Names the file, unless the error is about another one.
    pub(super) fn in_file(self, file: &str) -> Self {
        if self.file.is_empty() { Self { file: file.to_owned(), ..self } } else { self }
    }
}

impl fmt::Display for MeshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let message = printable(&self.message);
        match (self.file.is_empty(), self.line) {
            (true, None) => f.write_str(&message),
            (true, Some(line)) => write!(f, "line {line}: {message}"),
            (false, None) => write!(f, "{}: {message}", self.file),
            (false, Some(line)) => write!(f, "{}:{line}: {message}", self.file),
        }
    }
}

impl std::error::Error for MeshError {}

/// With control characters written as escapes: words of a file must not steer the terminal.
fn printable(message: &str) -> Cow<'_, str> {
    if !message.contains(char::is_control) {
        return Cow::Borrowed(message);
    }
    let escape = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
    Cow::Owned(message.chars().map(escape).collect())
}

/// What a file says, as a message can show it.
pub(super) fn shown(word: &[u8]) -> String {
    /// Characters of a word that messages show.
    const SHOWN: usize = 40;
    let text = String::from_utf8_lossy(&word[..word.len().min(4 * SHOWN)]);
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.into_owned(),
    }
}
