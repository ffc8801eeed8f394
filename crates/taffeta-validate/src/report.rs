//! The report: as JSON, as one HTML page with plots, and in short as Markdown.

use crate::bench::{Extent, Row};
use crate::groups::Group;
use serde::Serialize;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use taffeta_plot::{Series, log_log, marked};

/// All that was tested.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The program's version.
    pub version: String,
    /// The processor, and the GPU where there is one.
    pub machine: String,
    /// Whether it is the quick form.
    pub is_quick: bool,
    /// Group by group.
    pub groups: Vec<Section>,
}

/// A group that was tested.
#[derive(Clone, Debug, Serialize)]
pub struct Section {
    /// The group's name.
    pub name: &'static str,
    /// Its heading.
    pub title: &'static str,
    /// What is tested.
    pub words: &'static str,
    /// What was found.
    pub rows: Vec<Row>,
    /// Scenes that did not run, and why.
    pub failures: Vec<String>,
    /// Its plot as SVG.
    #[serde(skip)]
    pub plot: Option<String>,
}

impl Report {
    /// An empty one.
    pub fn new(version: String, machine: String, extent: Extent) -> Self {
        Self { version, machine, is_quick: extent == Extent::Quick, groups: Vec::new() }
    }

    /// How many numbers are as near as they must be, and how many are not; scenes that did not run count as one each.
    pub fn counts(&self) -> [usize; 2] {
        let of = |section: &Section| section.counts();
        self.groups.iter().map(of).fold([0, 0], |[a, b], [c, d]| [a + c, b + d])
    }

    /// Writes `report.html`, `report.json`, `report.md` and the plots.
    ///
    /// # Errors
    /// Where a file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), String> {
        let put = |name: String, text: &str| {
            let path = folder.join(name);
            fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))
        };
        for section in &self.groups {
            if let Some(plot) = &section.plot {
                put(format!("{}.svg", section.name), plot)?;
            }
        }
        let json = serde_json::to_string_pretty(self).map_err(|error| error.to_string())?;
        put("report.json".into(), &json)?;
        put("report.md".into(), &self.markdown())?;
        put("report.html".into(), &self.html())
    }

    /// In short: of each number the mesh and solver that is farthest off, and all that fail.
    pub fn markdown(&self) -> String {
        let [good, bad] = self.counts();
        let form = if self.is_quick { ", quick form" } else { "" };
        let mut text = format!(
            "# Cloth beside theory\n\ntaffeta {}, {}{form}: {good} numbers are as near as they must be, {bad} are not. A line has the \
             worst of all meshes and solvers.\n",
            self.version, self.machine
        );
        for section in &self.groups {
            text += &section.markdown();
        }
        text
    }

    fn html(&self) -> String {
        let [good, bad] = self.counts();
        let mut page = format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Cloth beside theory</title><meta name=\"viewport\" \
             content=\"width=device-width\"><style>{STYLE}</style></head><body>\n<h1>Cloth beside theory</h1>\n<p>taffeta {}, {}{}: \
             <b>{good}</b> numbers are as near as they must be, <b class=\"{}\">{bad}</b> are not.</p>\n<ul>\n",
            escaped(&self.version),
            escaped(&self.machine),
            if self.is_quick { ", quick form" } else { "" },
            if bad == 0 { "good" } else { "bad" },
        );
        // Writing to a string cannot fail.
        for section in &self.groups {
            let [good, bad] = section.counts();
            let verdict = if bad == 0 { "good" } else { "bad" };
            let (name, title) = (section.name, escaped(section.title));
            let _ = writeln!(
                page,
                "<li><a href=\"#{name}\">{title}</a>: {good} passed, <span class=\"{verdict}\">{bad} failed</span></li>"
            );
        }
        page += "</ul>\n";
        self.groups.iter().for_each(|section| page += &section.html());
        page + "</body></html>\n"
    }
}

const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;max-width:1180px;margin:2rem auto;padding:0 1rem;color:#1c1c1c}\
h1,h2{line-height:1.2}h2{margin-top:2.5rem;border-bottom:1px solid #ccc}table{border-collapse:collapse;font-size:14px}\
th,td{padding:.2rem .6rem;border-bottom:1px solid #ddd;text-align:left}td.n{text-align:right;font-variant-numeric:tabular-nums}\
.bad{color:#b00020;font-weight:bold}.good{color:#006b3c}tr.bad td{background:#fdecef;font-weight:normal}svg{max-width:100%;height:auto}";

impl Section {
    /// Of a group, with what its jobs found.
    pub fn new(group: &Group, rows: Vec<Row>, failures: Vec<String>) -> Self {
        let plot = plot(group, &rows);
        Self { name: group.name, title: group.title, words: group.words, rows, failures, plot }
    }

    /// How many numbers pass, and how many fail.
    pub fn counts(&self) -> [usize; 2] {
        let good = self.rows.iter().filter(|row| row.passed()).count();
        [good, self.rows.len() - good + self.failures.len()]
    }

    /// Of each quantity, what is farthest off.
    fn worst(&self) -> Vec<&Row> {
        let mut worst: Vec<&Row> = Vec::new();
        for row in &self.rows {
            match worst.iter_mut().find(|other| other.quantity == row.quantity) {
                Some(other) if by_allowed(row) > by_allowed(other) => *other = row,
                Some(_) => {}
                None => worst.push(row),
            }
        }
        worst
    }

    fn markdown(&self) -> String {
        let [good, bad] = self.counts();
        let mut text = format!("\n## {}\n\n{}\n\n{good} passed, {bad} failed.\n\n", self.title, self.words);
        if self.plot.is_some() {
            text += &format!("![{}]({}.svg)\n\n", self.title, self.name);
        }
        text += "| number | expected | ours | off by | allowed | mesh | solver |\n|---|---:|---:|---:|---:|---|---|\n";
        let failed = self.rows.iter().filter(|row| !row.passed());
        let worst = self.worst();
        let more = failed.filter(|row| !worst.iter().any(|other| std::ptr::eq(*other, *row)));
        for row in worst.iter().copied().chain(more) {
            let [expected, ours, error, allowed] = cells(row);
            let verdict = if row.passed() { "" } else { "**failed** " };
            let note =
                if row.passed() || row.note.is_empty() { String::new() } else { format!(" ({})", row.note) };
            text += &format!(
                "| {verdict}{}{note} | {expected} | {ours} | {error} | {allowed} | {} | {} |\n",
                row.quantity, row.mesh, row.solver
            );
        }
        self.failures.iter().for_each(|failure| text += &format!("\n**Did not run**: {failure}\n"));
        text
    }

    fn html(&self) -> String {
        let mut text = format!(
            "<h2 id=\"{}\">{}</h2>\n<p>{}</p>\n",
            self.name,
            escaped(self.title),
            escaped(self.words)
        );
        if let Some(plot) = &self.plot {
            text += plot;
        }
        for failure in &self.failures {
            text += &format!("<p class=\"bad\">Did not run: {}</p>\n", escaped(failure));
        }
        text += "<table><thead><tr><th>number</th><th>mesh</th><th>solver</th><th>expected</th><th>ours</th><th>off by</th>\
                 <th>allowed</th><th>scene</th></tr></thead><tbody>\n";
        for row in &self.rows {
            let [expected, ours, error, allowed] = cells(row);
            text += &format!(
                "<tr class=\"{}\"><td>{}{}</td><td>{}</td><td>{}</td><td class=\"n\">{expected}</td><td class=\"n\">{ours}</td>\
                 <td class=\"n\">{error}</td><td class=\"n\">{allowed}</td><td><a href=\"{}\">scene</a></td></tr>\n",
                if row.passed() { "" } else { "bad" },
                escaped(&row.quantity),
                if row.note.is_empty() { String::new() } else { format!(" ({})", escaped(&row.note)) },
                escaped(&row.mesh),
                escaped(&row.solver),
                escaped(&row.scene),
            );
        }
        text + "</tbody></table>\n"
    }
}

/// How far off a row is, by what is allowed.
fn by_allowed(row: &Row) -> f64 {
    match (row.error, row.allowed) {
        (Some(error), Some(allowed)) => error.abs() / allowed.max(1e-300),
        (None, Some(_)) => f64::INFINITY,
        _ => 0.0,
    }
}

/// Expected, ours, error and allowed, in writing.
fn cells(row: &Row) -> [String; 4] {
    let unit = if row.unit.is_empty() { String::new() } else { format!(" {}", row.unit) };
    let some =
        |number: Option<f64>, unit: &str| number.map_or_else(String::new, |number| short(number) + unit);
    [some(row.expected, ""), short(row.ours), some(row.error, &unit), some(row.allowed, &unit)]
}

/// Four digits that count.
fn short(number: f64) -> String {
    match number.abs() {
        0.0 => "0".into(),
        n if !(1e-4..1e5).contains(&n) => format!("{number:.2e}"),
        n => format!("{number:.0$}", (3 - n.log10().floor() as i32).clamp(0, 7) as usize),
    }
}

fn plot(group: &Group, rows: &[Row]) -> Option<String> {
    let mut lines: Vec<Series> = Vec::new();
    for (row, (name, x)) in rows.iter().filter_map(|row| Some((row, row.plot.as_ref()?))) {
        match lines.iter_mut().find(|line| line.name == *name) {
            Some(line) => *line = line.clone().point((*x, row.ours), ""),
            None => lines.push(Series::new(name.clone()).point((*x, row.ours), "")),
        }
    }
    if lines.is_empty() {
        return None;
    }
    let theory = group.theory.map(|theory| Series::of("theory", theory()));
    let all: Vec<Series> = lines.into_iter().chain(theory).collect();
    let [x, y] = group.axes;
    Some(if group.is_logarithmic {
        log_log(group.title, x, y, &all)
    } else {
        marked(group.title, x, y, &all, 0.0)
    })
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
