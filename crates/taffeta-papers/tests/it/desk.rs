//! A folder to work in, and the program.

use assert_cmd::Command;
use std::path::PathBuf;
use tempfile::TempDir;

/// A folder of its own.
pub struct Desk {
    dir: TempDir,
}

impl Desk {
    /// An empty folder.
    pub fn new() -> Self {
        Self { dir: TempDir::new().expect("a temporary folder") }
    }

    /// A path in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    /// The program, in the folder.
    pub fn papers(&self, words: &[&str]) -> Command {
        let mut command = assert_cmd::cargo::cargo_bin_cmd!("taffeta-papers");
        command.current_dir(self.dir.path()).args(words);
        command
    }

    /// Names of the files in a folder, sorted.
    pub fn files(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.path(folder)).expect("the folder is there");
        let mut names: Vec<String> = entries
            .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }
}
