//! What is kept of measurements: a line of JSON for each.

use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::Path;

/// A line of a file.
pub trait Line: Serialize + DeserializeOwned + Clone {
    /// The file's name.
    const FILE: &str;
    /// Whether it takes the place of another.
    fn same(&self, other: &Self) -> bool;
}

/// The lines that were kept.
pub fn kept<L: Line>(folder: &Path) -> Result<Vec<L>, String> {
    let file = folder.join(L::FILE);
    let text = std::fs::read_to_string(&file)
        .map_err(|error| format!("{}: {error}; measure first", file.display()))?;
    let line = |(index, line): (usize, &str)| {
        serde_json::from_str(line).map_err(|error| format!("{}:{}: {error}", file.display(), index + 1))
    };
    text.lines().enumerate().map(line).collect()
}

/// Keeps a line, in place of an earlier one that is the same run.
pub fn keep<L: Line>(folder: &Path, line: &L) -> Result<(), String> {
    let file = folder.join(L::FILE);
    let mut lines = if file.is_file() { kept::<L>(folder)? } else { Vec::new() };
    match lines.iter_mut().find(|known| known.same(line)) {
        Some(known) => *known = line.clone(),
        None => lines.push(line.clone()),
    }
    let mut text = String::new();
    for line in &lines {
        text += &serde_json::to_string(line).map_err(|error| error.to_string())?;
        text.push('\n');
    }
    std::fs::write(&file, text).map_err(|error| format!("{}: {error}", file.display()))
}
