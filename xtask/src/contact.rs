//! `cargo xtask contact`: how fast nodes find each other, by our cells, by all pairs and by S2's programs for a GPU, beside what
//! it publishes.

use crate::lines::{self, Line};
use crate::results::measure;
use crate::{program, results, root};
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::process::{Command, ExitCode};
use taffeta_io::program::processor;

/// Sides of the sheets that S2 has, and of larger ones, which only cells can do.
const SIDES: [u32; 7] = [5, 10, 20, 40, 80, 120, 160];
const LARGER: [u32; 3] = [320, 640, 1000];
/// The side of which S2 gives numbers.
const PUBLISHED_SIDE: u32 = 160;
/// The largest side that a software adapter is asked for: its speed says nothing.
const SOFTWARE_SIDE: u32 = 40;
/// The rungs, by their names in the bench; with the speed-ups over its serial program that S2 ("CUDA Cloth Simulation") gives
/// at 160 × 160, on a GTX 1660 Ti against a Ryzen 7 3750H.
const RUNGS: [(&str, &str, Option<f64>); 8] = [
    ("serial", "one thread, all pairs", Some(1.0)),
    ("naive", "GPU, all pairs", Some(108.51)),
    ("constants", "what is not written is constant", Some(110.88)),
    ("squared", "squared distances", Some(154.90)),
    ("swapped", "buffers swapped", Some(154.68)),
    ("scanned", "bins, filled from all", Some(156.70)),
    ("refreshed", "bins, filled from neighbours", Some(1635.58)),
    ("binned", "ours: clusters of nodes, looked at when they may touch", None),
];

/// How a software adapter is listed.
const SOFTWARE: &str = ", software)";

const HEAD: &str = "# Contact of nodes with each other

Written by `cargo xtask contact`. The scene is S2's demo in any size: a sheet held at one edge falls on a ball, on the floor and
on itself; a frame is 1/30 s in 34 sub-steps; the first 60 frames are not timed. How it is done:
[docs/models/contact.md](../models/contact.md#nodes-with-each-other). *Serial* is what S2 starts from: one thread, every node
looks at all others; large sheets are timed for some sub-steps only. *Naive* to *refreshed* are its six programs for a GPU,
each of which goes on from the one before, written again from its text; their bins have a side of 1.5 thicknesses and 32
places. They are measured where there is a GPU, with `--software` on an adapter in software too: small sheets, which
prove that they run. *Binned* is ours. `taffeta bench contact --rungs` has them all.

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

/// What is asked for.
#[derive(Debug, PartialEq, Eq)]
enum Wanted {
    /// The page of what was kept.
    Page,
    /// Measurements, those on a GPU on a software adapter too.
    Measurements { software: bool },
}

/// Measures and writes the page; with `--page-only` writes it from what was kept.
pub fn run(words: &[&str]) -> ExitCode {
    let result = wanted(words).and_then(|wanted| match wanted {
        Wanted::Page => write(),
        Wanted::Measurements { software } => measure(software).and_then(|()| write()),
    });
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

fn wanted(words: &[&str]) -> Result<Wanted, String> {
    match words {
        [] => Ok(Wanted::Measurements { software: false }),
        ["--software"] => Ok(Wanted::Measurements { software: true }),
        ["--page-only"] => Ok(Wanted::Page),
        _ => Err(format!("contact {}: it takes --software, or --page-only", words.join(" "))),
    }
}

fn measure(software: bool) -> Result<(), String> {
    if !program::build().arg("--quiet").status().map_err(|error| format!("cargo: {error}"))?.success() {
        return Err("the program was not built".into());
    }
    let folder = root().join("docs/results/contact");
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let commit = program::commit()?;
    let adapter = adapter(&info()?);
    let before: Vec<Measured> = lines::kept(&folder).unwrap_or_default();
    for (side, rung) in jobs(adapter, software) {
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
            machine: processor(),
            device: text("device").unwrap_or_default(),
            commit: commit.clone(),
        };
        if measured.may_replace(&before) {
            lines::keep(&folder, &measured)?;
        }
    }
    Ok(())
}

/// What there is to run the rungs of a GPU on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Adapter {
    Hardware,
    Software,
    None,
}

/// What the program says of this machine.
fn info() -> Result<String, String> {
    let output = Command::new(program::path()).arg("info").output();
    let output = output.map_err(|error| format!("{}: {error}", program::path().display()))?;
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// The adapter that the bench would take, by what `taffeta info` says.
fn adapter(info: &str) -> Adapter {
    match info.lines().find_map(|line| line.strip_prefix("--backend gpu takes ")) {
        Some(name) if name.contains(SOFTWARE) => Adapter::Software,
        Some(_) => Adapter::Hardware,
        None => Adapter::None,
    }
}

/// Sides and rungs to measure.
fn jobs(adapter: Adapter, software: bool) -> Vec<(u32, &'static str)> {
    let largest = match adapter {
        Adapter::Hardware => PUBLISHED_SIDE,
        Adapter::Software if software => SOFTWARE_SIDE,
        _ => 0,
    };
    let sides = |rung: &str| match rung {
        "serial" => SIDES.to_vec(),
        "binned" => [&SIDES[..], &LARGER].concat(),
        _ => SIDES.into_iter().filter(|&side| side <= largest).collect(),
    };
    RUNGS.iter().flat_map(|&(rung, ..)| sides(rung).into_iter().map(move |side| (side, rung))).collect()
}

impl Measured {
    /// Whether it may take the place of what is there: a software adapter's does not take that of a GPU's.
    fn may_replace(&self, kept: &[Self]) -> bool {
        let on_hardware = |line: &&Self| !line.device.contains(SOFTWARE);
        !self.device.contains(SOFTWARE) || !kept.iter().filter(on_hardware).any(|line| line.same(self))
    }
}

fn write() -> Result<(), String> {
    let results = root().join("docs/results");
    let lines: Vec<Measured> = lines::kept(&results.join("contact"))?;
    let page = results.join("contact.md");
    std::fs::write(&page, text(&lines)).map_err(|error| format!("{}: {error}", page.display()))?;
    results::write_readme(&results)
}

fn text(lines: &[Measured]) -> String {
    let mut devices: Vec<String> = lines
        .iter()
        .map(|line| format!("{}, {}, commit {}", line.machine, line.device, line.commit))
        .collect();
    devices.sort();
    devices.dedup();
    let (speed_ups, sizes) = (speed_ups(lines), sizes(lines));
    format!("{HEAD}\nMeasured on: {}.\n\n{speed_ups}\n{sizes}", devices.join("; "))
}

fn find<'a>(lines: &'a [Measured], side: u32, rung: &str) -> Option<&'a Measured> {
    lines.iter().find(|line| line.side == side && line.rung == rung)
}

/// Each rung beside S2's; over the serial program of the same machine.
fn speed_ups(lines: &[Measured]) -> String {
    let mut table = "## Speed-up over serial at 160 × 160\n\n\
         | rung | technique | S2, GTX 1660 Ti over Ryzen 7 3750H | here | ms a frame here | on |\n\
         |---|---|---:|---:|---:|---|\n"
        .to_owned();
    let serial = find(lines, PUBLISHED_SIDE, "serial");
    let mut notes = String::new();
    for (rung, technique, published) in RUNGS {
        let published = published.map_or_else(String::new, |speed_up| format!("{speed_up:.2}"));
        let own = find(lines, PUBLISHED_SIDE, rung);
        let base = serial.zip(own).filter(|(serial, own)| serial.machine == own.machine);
        let speed_up = base.map(|(serial, own)| format!("{:.2}", serial.ms_per_frame / own.ms_per_frame));
        let ms = own.map(|own| format!("{:.3}", own.ms_per_frame)).unwrap_or_default();
        let (speed_up, on) = (speed_up.unwrap_or_default(), own.map_or("", |own| own.device.as_str()));
        // Writing to a string cannot fail.
        let _ = writeln!(table, "| {rung} | {technique} | {published} | {speed_up} | {ms} | {on} |");
        let note = own.and_then(|own| own.note.as_ref());
        note.into_iter().for_each(|note| notes += &format!("- {rung}: {note}.\n"));
    }
    table += "\nS2's bins on an RTX 4070 take about 5 ms a frame. A row without numbers was not measured.\n";
    if notes.is_empty() { table } else { format!("{table}\n{notes}") }
}

/// Times of all sizes, with a column for each rung that was measured.
fn sizes(lines: &[Measured]) -> String {
    let measured = |rung: &&str| lines.iter().any(|line| line.rung == **rung);
    let rungs: Vec<&str> = RUNGS.iter().map(|&(rung, ..)| rung).filter(measured).collect();
    let names = rungs.iter().fold(String::new(), |names, rung| format!("{names} {rung} |"));
    let mut table = format!(
        "## By size\n\nTime of a frame [ms], and for binned particle-substeps a second [M/s].\n\n\
         | side | nodes |{names} M/s |\n|---:|---:|{}---:|\n",
        "---:|".repeat(rungs.len())
    );
    for &side in SIDES.iter().chain(&LARGER) {
        let ms = |rung: &str| find(lines, side, rung).map(|line| line.ms_per_frame);
        let cell = |rung: &&str| format!(" {} |", ms(rung).map_or_else(String::new, |ms| format!("{ms:.3}")));
        let cells: String = rungs.iter().map(cell).collect();
        let nodes = f64::from(side * side);
        let speed = ms("binned").map_or_else(String::new, |ms| format!("{:.0}", nodes * 34.0 / ms * 1e-3));
        // Writing to a string cannot fail.
        let _ = writeln!(table, "| {side} | {nodes} |{cells} {speed} |");
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(side: u32, rung: &str, ms_per_frame: f64, machine: &str, device: &str) -> Measured {
        let [rung, machine, device] = [rung, machine, device].map(str::to_owned);
        Measured { side, rung, ms_per_frame, note: None, machine, device, commit: "1234567".to_owned() }
    }

    #[test]
    fn a_gpu_is_measured_where_there_is_one_and_software_where_it_is_asked_for() {
        let takes =
            |name: &str| adapter(&format!("threads: 2\n--backend gpu takes {name}; its kernels see 1 GB"));
        assert_eq!(takes("NVIDIA H200 (vulkan, discrete)"), Adapter::Hardware);
        assert_eq!(takes("llvmpipe (vulkan, software)"), Adapter::Software);
        assert_eq!(adapter("threads: 2\ngpu: no GPU was found"), Adapter::None);
        let naive = |adapter, software| {
            jobs(adapter, software).iter().filter(|(_, rung)| *rung == "naive").map(|(side, _)| *side).max()
        };
        assert_eq!(naive(Adapter::Hardware, false), Some(160));
        assert_eq!(naive(Adapter::Software, true), Some(40));
        assert_eq!((naive(Adapter::Software, false), naive(Adapter::None, true)), (None, None));
        assert_eq!(jobs(Adapter::None, false).len(), 17);
        assert_eq!(wanted(&["--software"]), Ok(Wanted::Measurements { software: true }));
        assert!(wanted(&["--page-only", "--software"]).is_err());
    }

    #[test]
    fn every_rung_has_a_row_and_a_speed_up_over_the_serial_of_its_own_machine_alone() {
        let lines = [
            line(160, "serial", 3000.0, "a", "cpu"),
            line(160, "naive", 20.0, "a", "gpu, H200 (vulkan, discrete)"),
            line(160, "refreshed", 2.0, "b", "gpu, H200 (vulkan, discrete)"),
        ];
        let page = text(&lines);
        let row = |start: &str| page.lines().find(|line| line.starts_with(start)).unwrap_or_default();
        let naive = "| naive | GPU, all pairs | 108.51 | 150.00 | 20.000 | gpu, H200 (vulkan, discrete) |";
        assert_eq!(row("| naive"), naive);
        assert_eq!(row("| squared"), "| squared | squared distances | 154.90 |  |  |  |");
        assert!(row("| refreshed").contains("| 1635.58 |  | 2.000 |"), "{page}");
        assert_eq!(row("| side"), "| side | nodes | serial | naive | refreshed | M/s |");
        assert_eq!(row("| 160"), "| 160 | 25600 | 3000.000 | 20.000 | 2.000 |  |");
    }

    #[test]
    fn a_software_adapter_does_not_take_a_gpu_s_place() {
        let hardware = line(40, "naive", 1.0, "a", "gpu, H200 (vulkan, discrete)");
        let software = line(40, "naive", 900.0, "a", "gpu, llvmpipe (vulkan, software)");
        assert!(!software.may_replace(std::slice::from_ref(&hardware)));
        assert!(hardware.may_replace(std::slice::from_ref(&software)));
        assert!(software.may_replace(std::slice::from_ref(&software)));
        assert!(software.may_replace(&[line(20, "naive", 1.0, "a", "gpu, H200 (vulkan, discrete)")]));
    }
}
