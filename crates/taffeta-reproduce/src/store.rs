//! What runs left, a line of JSON each: the raw numbers behind every table.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// What is kept of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    /// What the run is called: letters, numbers and hyphens.
    pub name: String,
    /// The command that makes it again.
    pub command: String,
    /// The processor.
    pub machine: String,
    /// A hash of the program that ran.
    pub program: String,
    /// Whether it was cut short, for a quick look.
    pub quick: bool,
    /// What it printed or wrote.
    pub result: Value,
}

/// What is kept of all runs, in a file to which each is added as soon as it is done.
pub struct Store {
    file: PathBuf,
    kept: BTreeMap<String, Kept>,
}

impl Store {
    /// The name of the file.
    pub const FILE: &str = "raw.jsonl";

    /// What a folder has; a last line that was not written whole does not count.
    ///
    /// # Errors
    /// Where its file cannot be read or written.
    pub fn open(folder: &Path) -> io::Result<Self> {
        let file = folder.join(Self::FILE);
        let text = if file.is_file() { fs::read_to_string(&file)? } else { String::new() };
        let lines = text.lines().filter_map(|line| serde_json::from_str::<Kept>(line).ok());
        let kept: BTreeMap<String, Kept> = lines.map(|kept| (kept.name.clone(), kept)).collect();
        let store = Self { file, kept };
        store.write()?;
        Ok(store)
    }

    /// What a run left.
    pub fn get(&self, name: &str) -> Option<&Kept> {
        self.kept.get(name)
    }

    /// Keeps what a run left, in place of what it left before.
    ///
    /// # Errors
    /// Where that cannot be written.
    pub fn keep(&mut self, kept: Kept) -> io::Result<()> {
        let mut file = File::options().append(true).create(true).open(&self.file)?;
        writeln!(file, "{}", serde_json::to_string(&kept)?)?;
        self.kept.insert(kept.name.clone(), kept);
        Ok(())
    }

    /// Writes the file anew: a line a run, in the order of their names.
    fn write(&self) -> io::Result<()> {
        let mut text = String::new();
        for kept in self.kept.values() {
            text += &serde_json::to_string(kept)?;
            text.push('\n');
        }
        let part = self.file.with_extension("part");
        fs::write(&part, text)?;
        fs::rename(&part, &self.file)
    }
}
