//! The report: one file that needs nothing else, with the raw numbers in it.

use crate::report::page::{Block, Picture, Section};
use crate::report::store::{Kept, Store};
use crate::report::table::Cell;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use pulldown_cmark::{Event, Options, Parser, html};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// What stands above the first section.
pub struct Head {
    /// Of the report.
    pub title: String,
    /// Below it, as Markdown.
    pub words: String,
}

/// How to read the page, and the Markdown of it.
const LEGEND: &str = "Every number of ours is a link to the run that it comes from: its command, its machine and all that it left, at the \
    end of this page. Numbers that are printed in a paper are brown. *Open* is what was not measured; its row or its tooltip says what \
    would fill it: where that is a hardware GPU, run the same command on a machine with one, and bring its raw.jsonl here with --merge. \
    A software adapter is never a row of speed.";
const PLAIN_LEGEND: &str = "Every number of ours comes from a run. report.html, which is made with this page, has each run: its command, \
    its machine and all that it left. *Open* is what was not measured; report.html says what would fill it.";

const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;max-width:1180px;margin:2rem auto;padding:0 1rem;color:#1c1c1c;background:#fff}\
h1,h2{line-height:1.2}h2{margin-top:2.5rem;border-bottom:1px solid #ccc}\
.wide{overflow-x:auto}table{border-collapse:collapse;font-size:14px;margin:.7rem 0 1.2rem}\
th,td{padding:.22rem .6rem;border-bottom:1px solid #ddd;vertical-align:top}th{text-align:left;background:#f3f3f3}\
td.open{color:#777;font-style:italic}td.theirs{color:#8a4b00}td a{white-space:nowrap}a{color:#00588f}figure{margin:1rem 0}\
figure svg,figure img{max-width:100%;height:auto}figcaption{font-size:14px;color:#444}\
pre{background:#f6f6f6;padding:.7rem;overflow:auto;max-height:24rem;font-size:12px}details{margin:.2rem 0}summary{cursor:pointer;font-size:14px}";

/// Writes `report.html` and `report.md`, and each table as CSV, each plot and picture into folders of their own.
///
/// # Errors
/// Where a number of ours has no run behind it, which would be a mistake of this program; and where a file cannot be written.
pub fn write(folder: &Path, head: &Head, sections: &[Section], store: &Store) -> Result<(), String> {
    let runs = runs(sections, store)?;
    let text = text(head, sections, &runs);
    let put = |file: &Path, bytes: &[u8]| {
        fs::write(file, bytes).map_err(|error| format!("{}: {error}", file.display()))
    };
    for part in ["tables", "plots", "pictures"] {
        let part = folder.join(part);
        fs::create_dir_all(&part).map_err(|error| format!("{}: {error}", part.display()))?;
    }
    for block in sections.iter().flat_map(|section| &section.blocks) {
        match block {
            Block::Words(_) => {}
            Block::Table(table) => {
                put(&folder.join("tables").join(table.name).with_extension("csv"), table.csv().as_bytes())?
            }
            Block::Plot(plot) => {
                put(&folder.join("plots").join(&plot.name).with_extension("svg"), plot.svg.as_bytes())?
            }
            Block::Picture(picture) => {
                put(&folder.join("pictures").join(&picture.name).with_extension("png"), &picture.png)?
            }
        }
    }
    put(&folder.join("report.md"), plain(head, sections).as_bytes())?;
    put(&folder.join("report.html"), text.as_bytes())
}

/// The runs behind the numbers of ours, in the order of their names.
fn runs<'a>(sections: &[Section], store: &'a Store) -> Result<BTreeMap<String, &'a Kept>, String> {
    let mut runs = BTreeMap::new();
    for block in sections.iter().flat_map(|section| &section.blocks) {
        let Block::Table(table) = block else { continue };
        for ours in table
            .rows
            .iter()
            .flatten()
            .filter_map(|cell| if let Cell::Ours(ours) = cell { Some(ours) } else { None })
        {
            let kept = store.get(ours.source()).ok_or_else(|| {
                format!(
                    "table {}: {} comes from {}, of which nothing is kept",
                    table.name,
                    ours.text(),
                    ours.source()
                )
            })?;
            runs.insert(kept.name.clone(), kept);
        }
    }
    Ok(runs)
}

fn text(head: &Head, sections: &[Section], runs: &BTreeMap<String, &Kept>) -> String {
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title>\
         <meta name=\"viewport\" content=\"width=device-width\"><style>{STYLE}</style></head><body>\n<h1>{0}</h1>\n{1}<ul>\n",
        escaped(&head.title),
        markdown(&format!("{}\n\n{LEGEND}", head.words))
    );
    // Writing to a string cannot fail.
    for (index, section) in sections.iter().enumerate() {
        let _ = writeln!(page, "<li><a href=\"#part-{index}\">{}</a></li>", escaped(&section.title));
    }
    page += "<li><a href=\"#runs\">The runs behind the numbers</a></li>\n</ul>\n";
    for (index, section) in sections.iter().enumerate() {
        let _ = writeln!(page, "<h2 id=\"part-{index}\">{}</h2>", escaped(&section.title));
        section.blocks.iter().for_each(|block| page += &html_of(block));
    }
    page += "<h2 id=\"runs\">The runs behind the numbers</h2>\n";
    runs.values().for_each(|kept| page += &run(kept));
    page + "</body></html>\n"
}

/// As Markdown, with drawings beside it.
fn plain(head: &Head, sections: &[Section]) -> String {
    let block = |block: &Block| match block {
        Block::Words(words) => format!("{words}\n\n"),
        Block::Table(table) => format!("{}\n", table.markdown()),
        Block::Plot(plot) => format!("![{}](plots/{}.svg)\n\n", plot.caption, plot.name),
        Block::Picture(picture) => {
            let Picture { caption, name, .. } = picture;
            format!("{caption}:\n\n![{caption}](pictures/{name}.png)\n\n")
        }
    };
    let section = |section: &Section| {
        format!("## {}\n\n{}", section.title, section.blocks.iter().map(block).collect::<String>())
    };
    let parts: String = sections.iter().map(section).collect();
    format!("# {}\n\n{}\n\n{PLAIN_LEGEND}\n\n{parts}", head.title, head.words)
}

fn html_of(block: &Block) -> String {
    match block {
        Block::Words(words) => markdown(words),
        Block::Table(table) => {
            let heads: String =
                table.columns.iter().map(|column| format!("<th>{}</th>", inline(column))).collect();
            let row = |row: &Vec<Cell>| format!("<tr>{}</tr>\n", row.iter().map(cell).collect::<String>());
            let rows: String = table.rows.iter().map(row).collect();
            let caption = markdown(&table.caption);
            format!(
                "{caption}<div class=\"wide\"><table id=\"{}\"><thead><tr>{heads}</tr></thead><tbody>\n{rows}</tbody></table></div>\n",
                table.name
            )
        }
        Block::Plot(plot) => {
            format!(
                "<figure id=\"plot-{}\">{}<figcaption>{}</figcaption></figure>\n",
                plot.name,
                plot.svg,
                inline(&plot.caption)
            )
        }
        Block::Picture(picture) => {
            let png = STANDARD.encode(&picture.png);
            let caption = inline(&picture.caption);
            format!(
                "<figure><img alt=\"\" src=\"data:image/png;base64,{png}\"><figcaption>{caption}</figcaption></figure>\n"
            )
        }
    }
}

fn cell(cell: &Cell) -> String {
    match cell {
        Cell::Words(words) => format!("<td>{}</td>", inline(words)),
        Cell::Theirs(number) => format!("<td class=\"theirs\">{}</td>", escaped(number)),
        Cell::Ours(ours) => {
            format!("<td><a href=\"#run-{}\">{}</a></td>", ours.source(), escaped(ours.text()))
        }
        Cell::Open(why) => format!("<td class=\"open\" title=\"{}\">open</td>", escaped(why)),
    }
}

/// A run: its command, and what it left, without pictures, which stand above.
fn run(kept: &Kept) -> String {
    let mut result = kept.result.clone();
    if let Some(picture) = result.get_mut("picture").filter(|picture| picture.is_string()) {
        *picture = Value::from("above");
    }
    let note = if kept.quick { ", cut short" } else { "" };
    format!(
        "<details id=\"run-{}\"><summary><code>{}</code></summary>\n<p>{}, program {}{note}</p>\n<pre>{}</pre></details>\n",
        kept.name,
        escaped(&kept.command),
        escaped(&kept.machine),
        escaped(&kept.program),
        escaped(&result.to_string())
    )
}

fn markdown(words: &str) -> String {
    let mut page = String::new();
    // Tags are words: what was brought from elsewhere cannot add any.
    let plain = Parser::new_ext(words, Options::ENABLE_TABLES).map(|event| match event {
        Event::Html(tag) | Event::InlineHtml(tag) => Event::Text(tag),
        other => other,
    });
    html::push_html(&mut page, plain);
    page
}

/// Markdown of one paragraph, without the paragraph.
fn inline(words: &str) -> String {
    let page = markdown(words);
    let page = page.trim();
    page.strip_prefix("<p>").and_then(|page| page.strip_suffix("</p>")).unwrap_or(page).to_owned()
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::table::Table;

    fn kept() -> Kept {
        let [name, command, machine, program] =
            ["a-run", "taffeta bench", "a machine", "12"].map(str::to_owned);
        Kept { name, command, machine, program, quick: true, result: serde_json::json!({"ms": 2.0}) }
    }

    fn sections() -> Vec<Section> {
        let mut table = Table::new("times", "Times of *frames*.", &["what", "S1", "ours"]);
        let ours = Cell::ours(Ok(&kept()), |value| Some(value["ms"].to_string()));
        table.row(vec![Cell::words("a < b"), Cell::theirs(Some(3.0), 0), ours]);
        table.row(vec![Cell::words("open"), Cell::none(), Cell::Open("needs a GPU".to_owned())]);
        vec![Section::new("Times").table(table)]
    }

    #[test]
    fn every_number_of_ours_leads_to_its_run_and_what_is_open_says_why() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::open(folder.path()).unwrap();
        store.keep(kept()).unwrap();
        let head = Head { title: "R & D".to_owned(), words: "Words.".to_owned() };
        write(folder.path(), &head, &sections(), &store).unwrap();
        let page = fs::read_to_string(folder.path().join("report.html")).unwrap();
        for part in [
            "<h1>R &amp; D</h1>",
            "<td>a &lt; b</td><td class=\"theirs\">3</td><td><a href=\"#run-a-run\">2.0</a></td>",
            "<td class=\"open\" title=\"needs a GPU\">open</td>",
            "<details id=\"run-a-run\"><summary><code>taffeta bench</code></summary>\n<p>a machine, program 12, cut short</p>",
            "{&quot;ms&quot;:2.0}",
        ] {
            assert!(page.contains(part), "{part}\n{page}");
        }
        let csv = fs::read_to_string(folder.path().join("tables/times.csv")).unwrap();
        assert_eq!(csv, "what,S1,ours\na < b,3,2.0\nopen,,open\n");
    }

    #[test]
    fn tags_in_words_are_words() {
        assert_eq!(inline("a <script>b</script>"), "a &lt;script&gt;b&lt;/script&gt;");
        assert!(!markdown("<script>b</script>").contains("<script>"));
    }

    #[test]
    fn a_number_without_its_run_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path()).unwrap();
        let head = Head { title: String::new(), words: String::new() };
        let error = write(folder.path(), &head, &sections(), &store).unwrap_err();
        assert_eq!(error, "table times: 2.0 comes from a-run, of which nothing is kept");
        assert!(!folder.path().join("report.html").exists());
    }
}
