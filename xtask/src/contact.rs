//! `cargo xtask contact`: how fast nodes find each other, by our cells and by all pairs, beside what S2 publishes.

use crate::lines::{self, Line};
use crate::results::measure;
use crate::{program, results, root};
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::process::ExitCode;

/// Sides of the sheets that S2 has, and of larger ones, which only cells can do.
const SIDES: [u32; 7] = [5, 10, 20, 40, 80, 120, 160];
const LARGER: [u32; 3] = [320, 640, 1000];
/// The side of which S2 gives numbers.
const PUBLISHED_SIDE: u32 = 160;
/// Speed-ups over its serial program that S2 ("CUDA Cloth Simulation") gives at 160 × 160, on a GTX 1660 Ti against a Ryzen 7
/// 3750H.
const PUBLISHED: [(&str, f64); 7] = [
    ("serial, all pairs", 1.0),
    ("naive GPU", 108.51),
    ("constants", 110.88),
    ("squared distances", 154.90),
    ("buffers swapped", 154.68),
    ("bins, scanned by all", 156.70),
    ("bins, from neighbours", 1635.58),
];

const HEAD: &str = "# Contact of nodes with each other

Written by `cargo xtask contact`. The scene is S2's demo in any size: a sheet held at one edge falls on a ball, on the floor and
on itself; a frame is 1/30 s in 34 sub-steps; the first 60 frames are not timed. How it is done:
[docs/models/contact.md](../models/contact.md#nodes-with-each-other). *Serial* is what S2 starts from: one thread, every node
looks at all others; large sheets are timed for some sub-steps only. *Binned* is ours, `taffeta bench contact`.

S2 is the article \"CUDA Cloth Simulation\".
";

/// A sheet by one rung: a line of `contact.jsonl`.
#[derive(Clone, Serialize, Deserialize)]
struct Measured {
    side: u32,
    rung: String,
    ms_per_frame: f64,
    note: Option<String>,
    machine: String,
    device: String,
    commit: String,
}

impl Line for Measured {
    const FILE: &str = "contact.jsonl";
    fn same(&self, other: &Self) -> bool {
        self.side == other.side && self.rung == other.rung
    }
}

/// Measures and writes the page; with `--page-only` writes it from what was kept.
pub fn run(words: &[&str]) -> ExitCode {
    let result = match words {
        [] => measure().and_then(|()| write()),
        ["--page-only"] => write(),
        _ => Err("contact: it takes --page-only, or nothing".into()),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

fn measure() -> Result<(), String> {
    if !program::build().arg("--quiet").status().map_err(|error| format!("cargo: {error}"))?.success() {
        return Err("the program was not built".into());
    }
    let folder = root().join("docs/results/contact");
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let commit = program::commit()?;
    let serial = SIDES.iter().map(|&side| (side, "serial"));
    for (side, rung) in serial.chain(SIDES.iter().chain(&LARGER).map(|&side| (side, "binned"))) {
        let frames = if LARGER.contains(&side) { " --frames 10" } else { "" };
        let words = format!("bench contact --n {side} --rungs {rung} --json{frames}");
        println!("taffeta {words}");
        let line = measure::bench(&words)?;
        let text = |key: &str| line[key].as_str().map(str::to_owned);
        let measured = Measured {
            side,
            rung: rung.to_owned(),
            ms_per_frame: line["ms_per_frame"]["median"].as_f64().ok_or("the bench gave no time")?,
            note: text("note"),
            machine: measure::processor(),
            device: text("device").unwrap_or_default(),
            commit: commit.clone(),
        };
        lines::keep(&folder, &measured)?;
    }
    Ok(())
}

fn write() -> Result<(), String> {
    let results = root().join("docs/results");
    let lines: Vec<Measured> = lines::kept(&results.join("contact"))?;
    let page = results.join("contact.md");
    std::fs::write(&page, text(&lines)).map_err(|error| format!("{}: {error}", page.display()))?;
    results::write_readme(&results)
}

fn text(lines: &[Measured]) -> String {
    let mut page = HEAD.to_owned();
    let mut devices: Vec<String> = lines
        .iter()
        .map(|line| format!("{}, {}, commit {}", line.machine, line.device, line.commit))
        .collect();
    devices.sort();
    devices.dedup();
    let find = |side: u32, rung: &str| lines.iter().find(|line| line.side == side && line.rung == rung);
    let ms = |side: u32, rung: &str| find(side, rung).map(|line| line.ms_per_frame);
    // Writing to a string cannot fail.
    let _ =
        write!(page, "\nMeasured on: {}.\n\n## Speed-up over serial at 160 × 160\n\n", devices.join("; "));
    page += "| technique | S2, GTX 1660 Ti over Ryzen 7 3750H | here |\n|---|---:|---:|\n";
    for (technique, speed_up) in PUBLISHED {
        let own = if speed_up == 1.0 { "1" } else { "" };
        let _ = writeln!(page, "| {technique} | {speed_up} | {own} |");
    }
    if let (Some(serial), Some(binned)) = (ms(PUBLISHED_SIDE, "serial"), ms(PUBLISHED_SIDE, "binned")) {
        let device = find(PUBLISHED_SIDE, "binned").map_or("", |line| line.device.as_str());
        let _ = writeln!(page, "| cells, candidates with a margin ({device}) | | {:.0} |", serial / binned);
    }
    page += "\nS2's bins on an RTX 4070 take about 5 ms a frame. Its rungs on a GPU are not there yet here.\n\n## By size\n\n";
    page += "| side | nodes | serial, ms a frame | binned, ms a frame | M particle-substeps/s |\n|---:|---:|---:|---:|---:|\n";
    for &side in SIDES.iter().chain(&LARGER) {
        let cell = |rung: &str| ms(side, rung).map_or_else(String::new, |ms| format!("{ms:.3}"));
        let nodes = f64::from(side * side);
        let speed =
            ms(side, "binned").map_or_else(String::new, |ms| format!("{:.0}", nodes * 34.0 / ms * 1e-3));
        let _ = writeln!(page, "| {side} | {nodes} | {} | {} | {speed} |", cell("serial"), cell("binned"));
    }
    page
}
