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

    /// What a folder has.
    ///
    /// # Errors
    /// Where its file cannot be read or written, or is none of these.
    pub fn open(folder: &Path) -> io::Result<Self> {
        let file = folder.join(Self::FILE);
        let text = if file.is_file() { fs::read(&file)? } else { Vec::new() };
        let kept = lines(&text).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))?;
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

    /// Writes the file again: a line a run, in the order of their names.
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

/// What lines have, by name; a last line that was not written whole does not count, nor one with nothing for a result.
///
/// # Errors
/// Which line is none, and why.
pub fn lines(text: &[u8]) -> Result<BTreeMap<String, Kept>, String> {
    let mut kept = BTreeMap::new();
    // After the last line's end comes nothing, or what was not written whole.
    let count = text.split(|&byte| byte == b'\n').count();
    let lines = text.split(|&byte| byte == b'\n').zip(1..);
    for (line, number) in lines.filter(|(line, _)| !line.trim_ascii().is_empty()) {
        match serde_json::from_slice::<Kept>(line) {
            Ok(one) if one.result.is_null() => {}
            Ok(one) => drop(kept.insert(one.name.clone(), one)),
            Err(_) if number == count => {}
            Err(error) => return Err(format!("line {number}: {}", fault(&error))),
        }
    }
    Ok(kept)
}

/// What is wrong in a line. The error counts lines too, from that one on.
fn fault(error: &serde_json::Error) -> String {
    let words = error.to_string();
    match words.split_once(" at line ") {
        Some((what, _)) => format!("{what} at column {}", error.column()),
        None => words,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line_of(name: &str, result: Value) -> String {
        let [name, command, machine, program] = [name, "", "", ""].map(str::to_owned);
        let kept = Kept { name, command, machine, program, quick: false, result };
        serde_json::to_string(&kept).unwrap()
    }

    fn line(name: &str) -> String {
        line_of(name, Value::from(1))
    }

    #[test]
    fn a_line_that_was_not_written_whole_does_not_count_and_another_is_never_lost() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(Store::FILE);
        fs::write(&file, format!("{}\n\n{}\n{{\"name\":", line("b"), line("a"))).unwrap();
        assert!(
            Store::open(folder.path())
                .is_ok_and(|store| store.get("a").is_some() && store.get("b").is_some())
        );
        assert_eq!(fs::read_to_string(&file).unwrap(), format!("{}\n{}\n", line("a"), line("b")));
        let foreign = format!("{}\n[1]\n{}\n", line("b"), line("a"));
        fs::write(&file, &foreign).unwrap();
        assert!(
            Store::open(folder.path()).err().is_some_and(|error| error.to_string().starts_with("line 2: "))
        );
        assert_eq!(fs::read_to_string(&file).unwrap(), foreign);
    }

    #[test]
    fn a_bad_line_is_told_with_its_place() {
        let told = |bad: &[u8]| lines(&[line("a").as_bytes(), b"\n", bad, b"\n"].concat()).unwrap_err();
        assert_eq!(told(b"{\"name\":"), "line 2: EOF while parsing a value at column 8");
        assert!(told(b"{\"name\":\"\xff\"}").starts_with("line 2: invalid unicode code point at column "));
        assert!(told(b"{}").starts_with("line 2: missing field `name` at column "));
    }

    #[test]
    fn a_run_that_left_nothing_is_not_kept() {
        let text = format!("{}\n{}\n", line_of("a", Value::Null), line("b"));
        assert_eq!(lines(text.as_bytes()).unwrap().into_keys().collect::<Vec<_>>(), ["b"]);
    }
}
