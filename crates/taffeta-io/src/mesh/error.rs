use crate::program::one_line;
use std::borrow::Cow;
use std::fmt;

/// Why a mesh was refused.
///
/// ```
/// use taffeta_io::{MeshFormat, MeshOptions, parse_mesh};
///
/// let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n";
/// let error = parse_mesh(text, MeshFormat::Obj, &MeshOptions::default()).unwrap_err();
/// assert_eq!(error.line, Some(4));
/// println!("{error}");
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct MeshError {
    /// The file; empty for a mesh given as data.
    pub file: String,
    /// Line in the file, from 1, where the mistake has one.
    pub line: Option<usize>,
    /// What was found and what would do.
    pub message: String,
}

impl MeshError {
    /// An error in a mesh given as data, for what reads meshes of its own.
    pub fn new(message: impl Into<String>) -> Self {
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

/// In one line, and without the middle where a file's words make it too long to read.
fn printable(message: &str) -> Cow<'_, str> {
    /// Characters of a message at its beginning and at its end that are always shown.
    const ENDS: [usize; 2] = [500, 200];
    let message = one_line(message);
    if message.len() <= ENDS[0] + ENDS[1] {
        return message;
    }
    let all: Vec<char> = message.chars().collect();
    if all.len() <= ENDS[0] + ENDS[1] {
        return message;
    }
    let ends = all[..ENDS[0]].iter().chain([' ', '…', ' '].iter()).chain(&all[all.len() - ENDS[1]..]);
    Cow::Owned(ends.collect())
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

#[cfg(test)]
mod tests {
    use super::MeshError;

    #[test]
    fn a_message_keeps_its_ends_and_none_of_a_file_s_control_characters() {
        let said = |message: String| MeshError::new(message).to_string();
        assert_eq!(said("`\u{1b}[2J` is no word".to_owned()), "`\\u001b[2J` is no word");
        let long = said(format!("begins{}ends", "\u{7f}".repeat(5000)));
        assert!(long.starts_with("begins\\u007f") && long.contains(" … ") && long.ends_with("\\u007fends"));
        assert!(long.chars().count() == 703, "{}", long.chars().count());
    }
}
