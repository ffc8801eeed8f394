//! What is wrong in the papers, each with a small experiment that shows it.
//!
//! An experiment computes the same number twice in 64 bits, as the paper prints it and as corrected, beside what is right.
//! `taffeta-papers errata` writes `docs/errata.md` of them; a report lists them.

mod dense;
mod finding;
mod s1;
mod s1_constraints;
mod s2;
mod s3;
mod s3_volume;
mod vector;

pub use finding::Finding;

use crate::papers::paper::Paper;
use crate::report::page::Section;
use crate::report::table::{Cell, Table};
use crate::root;
use std::path::PathBuf;
use taffeta_io::program::{self, Failure};

/// A place where a paper says what it cannot mean.
pub struct Erratum {
    /// By which it is cited; of its heading, its table, its link.
    pub id: &'static str,
    /// Where it is found.
    pub paper: Paper,
    /// Where in the paper.
    pub place: &'static str,
    /// What stands there; formulas in the paper's symbols.
    pub printed: &'static str,
    /// What should stand there.
    pub corrected: &'static str,
    /// How one knows.
    pub why: &'static str,
    /// What the experiment does.
    pub setting: &'static str,
    /// The page of the model that has it corrected, and what is corrected there.
    pub model: &'static str,
    /// Computes it.
    pub experiment: fn() -> Vec<Finding>,
}

/// All errata, by paper.
pub fn all() -> Vec<Erratum> {
    [s1::errata(), s1_constraints::errata(), s2::errata(), s3_volume::errata(), s3::errata()]
        .into_iter()
        .flatten()
        .collect()
}

const INTRODUCTION: &str = "\
taffeta implements three papers. Their methods work once some formulas, algorithms and counts are corrected. We know of no other \
list of these errors, and everybody who implements a paper from its text meets them again. Each entry has what is printed, what \
it should say, and a small experiment whose numbers anybody can check. Where a sentence can be read in more than one way, the \
entry says so. Corrections of this list are welcome.";

const NUMBERS: &str = "\
The numbers are computed by `crates/taffeta-papers/src/errata/`, one function for each entry; a test compares this page with \
them. *Exact* is a value that needs neither formula: a derivative by differences, a conservation law, a count. A value below \
1e-9 is printed as 0. [The models](models/README.md) say what taffeta does in these places.";

const CITING: &str = "\
Name the paper, the place and the erratum. An example: *eq. 10 of Va, Choi and Hong (2023) as corrected by taffeta, \
docs/errata.md, `s3-eq10`*. An identifier keeps its meaning; new errata get new ones.";

/// All errata as a part of a report.
pub fn section() -> Section {
    let mut list =
        Table::new("errata", "Errata of the three papers.", &["erratum", "place", "printed", "corrected"]);
    for Erratum { id, paper, place, printed, corrected, .. } in all() {
        let place = format!("{}, {place}", paper.name());
        let [printed, corrected] = [printed, corrected].map(str::to_owned);
        list.row([format!("`{id}`"), place, printed, corrected].map(Cell::words).into());
    }
    Section::new("Errata")
        .words(INTRODUCTION)
        .words("Each with its experiment: `docs/errata.md`.")
        .table(list)
}

impl Erratum {
    /// Its part of the page.
    fn words(&self) -> String {
        let rows: String = (self.experiment)()
            .iter()
            .map(|finding| format!("| {} |\n", finding.cells().join(" | ")))
            .collect();
        let Self { id, place, printed, corrected, why, setting, model, .. } = self;
        let paper = self.paper.name();
        let [printed, corrected] = [("Printed", printed), ("Corrected", corrected)]
            .map(|(name, text)| wrapped(&format!("- *{name}:* {text}"), "  "));
        let [why, setting, model] =
            [(*why).to_owned(), format!("*Experiment.* {setting}"), format!("In taffeta: {model}.")]
                .map(|text| wrapped(&text, ""));
        format!(
            "### {id}\n\n**{paper}, {place}**\n\n{printed}\n{corrected}\n\n{why}\n\n{setting}\n\n\
             | | printed | corrected | exact |\n|---|---:|---:|---:|\n{rows}\n{model}\n\n"
        )
    }
}

/// Markdown as a cell of a table may have it.
fn in_table(words: &str) -> String {
    words.replace('|', "\\|")
}

/// Words in lines of at most 120 characters, where they may break; from the second on with an indent.
fn wrapped(words: &str, indent: &str) -> String {
    let mut lines = vec![String::new()];
    for word in words.split(' ') {
        let line = lines.last_mut().expect("there is one from the start");
        let long = line.chars().count() + 1 + word.chars().count() > 120;
        if long && !begins_block(word) {
            lines.push(format!("{indent}{word}"));
        } else {
            let space = if line.is_empty() { "" } else { " " };
            *line += &format!("{space}{word}");
        }
    }
    lines.join("\n")
}

/// Whether Markdown takes a line that begins with this word for more than text.
fn begins_block(word: &str) -> bool {
    let number = word.trim_end_matches(['.', ')']);
    let is_count = number.len() < word.len() && number.chars().all(|c| c.is_ascii_digit());
    is_count || ["+", "-", "*"].contains(&word) || word.starts_with(['#', '>', '|', '='])
}

/// The page of them.
fn file() -> PathBuf {
    root().join("docs/errata.md")
}

/// Writes the page again.
///
/// # Errors
/// Where it cannot be written.
pub fn write() -> Result<(), Failure> {
    std::fs::write(file(), page()).map_err(|error| Failure::Work(format!("docs/errata.md: {error}")))?;
    program::say("docs/errata.md")
}

/// The page `docs/errata.md`.
fn page() -> String {
    let all = all();
    let mut text = format!("# Errata of three papers\n\n{}\n\n", wrapped(INTRODUCTION, ""));
    for paper in Paper::ALL {
        text += &wrapped(&format!("- **{}**: {}.", paper.name(), paper.citation()), "  ");
        text.push('\n');
    }
    text += &format!("\n{}\n\n## How to cite\n\n{}\n\n", wrapped(NUMBERS, ""), wrapped(CITING, ""));
    text += "## Contents\n\n| Erratum | Place | Corrected |\n|---|---|---|\n";
    for Erratum { id, paper, place, corrected, .. } in &all {
        text += &format!("| [{id}](#{id}) | {}, {place} | {} |\n", paper.name(), in_table(corrected));
    }
    for paper in Paper::ALL {
        text += &format!("\n## {}\n\n", paper.name());
        let own: String = all.iter().filter(|one| one.paper == paper).map(Erratum::words).collect();
        text += own.trim_end();
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::page::Block;
    use std::collections::BTreeSet;

    #[test]
    fn the_page_is_what_the_experiments_find() {
        let text = std::fs::read_to_string(file()).unwrap_or_default();
        let again = "`cargo run --release -p taffeta-papers -- errata` writes it again";
        let [text, page] = [text, page()];
        let differs = text.lines().zip(page.lines()).find(|(old, new)| old != new);
        assert!(text == page, "docs/errata.md is not what the experiments find, first {differs:?}: {again}");
    }

    #[test]
    fn identifiers_are_words_of_their_own_that_begin_with_the_paper() {
        let all = all();
        let ids: BTreeSet<&str> = all.iter().map(|erratum| erratum.id).collect();
        assert_eq!(ids.len(), all.len());
        for erratum in &all {
            assert!(erratum.id.starts_with(&erratum.paper.name().to_lowercase()), "{}", erratum.id);
            let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
            assert!(erratum.id.chars().all(is_plain), "{}", erratum.id);
        }
    }

    #[test]
    fn every_experiment_has_a_number_that_is_printed_wrong_and_one_that_is_corrected() {
        for erratum in all() {
            let differs = |f: &Finding| f.printed.map(f64::to_bits) != f.corrected.map(f64::to_bits);
            let found = (erratum.experiment)();
            assert!(found.iter().any(differs), "{}", erratum.id);
            for Finding { what, corrected, exact, .. } in &found {
                let [Some(corrected), Some(exact)] = [corrected, exact] else { continue };
                let off = (corrected - exact).abs();
                assert!(off <= 1e-4 * exact.abs().max(1e-2), "{}, {what}: {corrected}, {exact}", erratum.id);
            }
        }
    }

    /// As GitHub makes an anchor of a heading.
    fn anchor(heading: &str) -> String {
        let kept = heading
            .chars()
            .filter(|c| c.is_alphabetic() || c.is_ascii_digit() || [' ', '-', '_'].contains(c));
        kept.collect::<String>().to_lowercase().replace(' ', "-")
    }

    #[test]
    fn links_lead_to_headings_that_exist() {
        let docs = root().join("docs");
        let page = page();
        let words = page.replace('\n', " ");
        for link in words.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let read =
                || std::fs::read_to_string(docs.join(file)).unwrap_or_else(|why| panic!("{link}: {why}"));
            let text = if file.is_empty() { page.clone() } else { read() };
            let headings = text.lines().filter(|line| line.starts_with('#'));
            let mut anchors = headings.map(|line| anchor(line.trim_start_matches('#').trim()));
            assert!(heading.is_empty() || anchors.any(|one| one == heading), "{link}");
        }
    }

    #[test]
    fn lines_break_where_they_stay_text() {
        let words = "a ".repeat(59) + "b + 12. #c d";
        assert_eq!(wrapped(&words, "  "), "a ".repeat(59) + "b + 12. #c\n  d");
    }

    #[test]
    fn a_report_lists_them_all() {
        let section = section();
        let tables = section.blocks.iter().filter_map(|block| match block {
            Block::Table(table) => Some(table),
            _ => None,
        });
        let text: String = tables.map(Table::markdown).collect();
        assert!(all().iter().all(|erratum| text.contains(&format!("| `{}` |", erratum.id))));
        assert!(!text.contains("](#"));
    }
}
