//! Tables whose numbers say where they come from.

use crate::report::store::Kept;
use serde_json::Value;

/// A table.
pub struct Table {
    /// Of its file, and of its place in the report.
    pub name: &'static str,
    /// What it is about, as Markdown.
    pub caption: String,
    /// Heads of its columns, as Markdown.
    pub columns: Vec<String>,
    /// Its rows, each with a cell for every column.
    pub rows: Vec<Vec<Cell>>,
}

/// What stands in a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words, as Markdown; nothing where there is nothing to say.
    Words(String),
    /// A published number, as it is printed.
    Theirs(String),
    /// A number that was measured or computed here.
    Ours(Ours),
    /// A number that is still to come: what would bring it.
    Open(String),
}

/// A number of ours. It can only be made of what is kept of a run, so that there is none without.
#[derive(Clone, Debug, PartialEq)]
pub struct Ours {
    text: String,
    source: String,
}

impl Ours {
    /// The number, in writing.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The name under which the run is kept.
    pub fn source(&self) -> &str {
        &self.source
    }
}

impl Cell {
    /// Words.
    pub fn words(words: impl Into<String>) -> Self {
        Self::Words(words.into())
    }

    /// Nothing.
    pub fn none() -> Self {
        Self::Words(String::new())
    }

    /// A published number with so many digits after the point.
    pub fn theirs(number: Option<f64>, digits: usize) -> Self {
        number.map_or_else(Self::none, |number| Self::Theirs(format!("{number:.digits$}")))
    }

    /// What `read` finds in what a run left; open, with the reason, where there is no run, or nothing in it.
    pub fn ours(run: Result<&Kept, String>, read: impl Fn(&Value) -> Option<String>) -> Self {
        let kept = match run {
            Ok(kept) => kept,
            Err(why) => return Self::Open(why),
        };
        match read(&kept.result) {
            Some(text) => Self::Ours(Ours { text, source: kept.name.clone() }),
            None => Self::Open("this run does not have it".to_owned()),
        }
    }
}

impl Table {
    /// A table without rows yet.
    pub fn new(name: &'static str, caption: &str, columns: &[&str]) -> Self {
        let columns = columns.iter().map(|&column| column.to_owned()).collect();
        Self { name, caption: caption.to_owned(), columns, rows: Vec::new() }
    }

    /// Takes another row.
    ///
    /// # Panics
    /// Where it does not have a cell for every column: a mistake of the program, not of what was measured.
    pub fn row(&mut self, cells: Vec<Cell>) {
        assert_eq!(cells.len(), self.columns.len(), "a row of {}", self.name);
        self.rows.push(cells);
    }

    /// As Markdown.
    pub fn markdown(&self) -> String {
        // A bar would end a cell.
        let written = |text: &str| text.replace('|', "\\|");
        let cells =
            |row: &[Cell]| row.iter().map(|cell| written(&cell.text())).collect::<Vec<_>>().join(" | ");
        let rules: Vec<&str> = (0..self.columns.len()).map(|column| self.rule(column)).collect();
        let rows: String = self.rows.iter().map(|row| format!("| {} |\n", cells(row))).collect();
        format!("{}\n\n| {} |\n|{}|\n{rows}", self.caption, self.columns.join(" | "), rules.join("|"))
    }

    /// Numbers stand at the right.
    fn rule(&self, column: usize) -> &'static str {
        let is_words = |row: &Vec<Cell>| matches!(&row[column], Cell::Words(words) if !words.is_empty());
        if self.rows.iter().any(is_words) { "---" } else { "---:" }
    }

    /// As CSV, in UTF-8.
    pub fn csv(&self) -> String {
        let line =
            |texts: Vec<String>| texts.iter().map(|text| field(text)).collect::<Vec<_>>().join(",") + "\n";
        let rows = self.rows.iter().map(|row| line(row.iter().map(Cell::text).collect()));
        line(self.columns.clone()) + &rows.collect::<String>()
    }
}

impl Cell {
    /// In writing.
    fn text(&self) -> String {
        match self {
            Self::Words(text) | Self::Theirs(text) => text.clone(),
            Self::Ours(ours) => ours.text.clone(),
            Self::Open(_) => "open".to_owned(),
        }
    }
}

/// A field of a CSV line (RFC 4180).
fn field(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept() -> Kept {
        Kept {
            name: "grid-32".to_owned(),
            command: "taffeta bench grid --n 32".to_owned(),
            machine: "a machine".to_owned(),
            program: "0123".to_owned(),
            quick: false,
            result: serde_json::json!({"ms": 1.5}),
        }
    }

    #[test]
    fn a_number_of_ours_links_to_its_run_and_one_without_a_run_is_open() {
        let kept = kept();
        let read = |value: &Value| value["ms"].as_f64().map(|ms| format!("{ms:.2}"));
        let mut table = Table::new("times", "Times.", &["what", "S1", "ours"]);
        table.row(vec![Cell::words("grid"), Cell::theirs(Some(2.0), 1), Cell::ours(Ok(&kept), read)]);
        table.row(vec![
            Cell::words("|a, b|"),
            Cell::theirs(None, 1),
            Cell::ours(Err("a GPU".to_owned()), read),
        ]);
        let text = table.markdown();
        assert!(text.contains("|---|---:|---:|\n| grid | 2.0 | 1.50 |\n| \\|a, b\\| |  | open |"), "{text}");
        assert_eq!(table.csv(), "what,S1,ours\ngrid,2.0,1.50\n\"|a, b|\",,open\n");
        assert_eq!(Cell::ours(Ok(&kept), |value| value["s"].as_str().map(str::to_owned)).text(), "open");
    }
}
