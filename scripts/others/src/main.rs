//! Runs the cloth of other engines on the scene of Va, Choi and Hong (2021), and writes what they did for the report of
//! `taffeta-papers`. See README.md.

mod rapier;
mod sheet;
mod swing;
mod xpbd;

use serde_json::{Value, json};
use sheet::{Engine, Look};
use std::fs::File;
use std::io::Write;
use std::process::ExitCode;
use std::time::{Duration, Instant};

const USAGE: &str = "others --out FILE [--sides 32,64,96,256]";
/// How long a sheet may take.
const PATIENCE: Duration = Duration::from_secs(60);
/// Frames until the sheet has come to rest: five seconds of it.
const FRAMES: u32 = 300;

/// An engine, and what a reader must know of it.
struct Entry {
    /// In names of runs.
    name: &'static str,
    /// As Cargo has it.
    package: &'static str,
    note: &'static str,
    make: fn(usize) -> Result<Box<dyn Engine>, String>,
}

const ENGINES: [Entry; 2] = [
    Entry {
        name: "rapier3d",
        package: "rapier3d",
        note: rapier::NOTE,
        make: |side| Ok(Box::new(rapier::Rapier::new(side))),
    },
    Entry {
        name: "rapier-cloth-core",
        package: "rapier-cloth-core",
        note: xpbd::NOTE,
        make: |side| match xpbd::Xpbd::new(side) {
            Ok(cloth) => Ok(Box::new(cloth)),
            Err(error) => Err(error.to_string()),
        },
    },
];

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), String> {
    let mut out = None;
    let mut sides = vec![32, 64, 96, 256];
    let all: Vec<String> = std::env::args().skip(1).collect();
    if all.first().is_some_and(|word| word == "swing") {
        return swing::run(&all[1..]);
    }
    let mut words = all.into_iter();
    while let Some(word) = words.next() {
        let value = words.next().ok_or(USAGE)?;
        match word.as_str() {
            "--out" => out = Some(value),
            "--sides" => sides = value.split(',').map(side).collect::<Result<_, _>>()?,
            _ => return Err(format!("{word} is not known: {USAGE}")),
        }
    }
    let path = out.ok_or(USAGE)?;
    let mut file = File::create(&path).map_err(|error| format!("{path}: {error}"))?;
    for entry in &ENGINES {
        for &side in &sides {
            match measured(entry, side) {
                Ok(kept) => writeln!(file, "{kept}").map_err(|error| format!("{path}: {error}"))?,
                Err(why) => eprintln!("{} {side} × {side}: no line, {why}", entry.name),
            }
        }
    }
    Ok(())
}

fn side(word: &str) -> Result<usize, String> {
    word.parse()
        .ok()
        .filter(|side| *side >= 2)
        .ok_or_else(|| format!("--sides {word} is not a number from 2: {USAGE}"))
}

/// A run of an engine, as the report keeps runs.
fn measured(entry: &Entry, side: usize) -> Result<Value, String> {
    let mut engine = (entry.make)(side)?;
    let run = Run::of(engine.as_mut())?;
    let program = format!("{} {}", entry.package, version(entry.package));
    eprintln!("{program}, {side} × {side}: {run}");
    run.last.lies()?;
    let mut spent: Vec<f64> = run.spent.iter().map(|(time, _)| time.as_secs_f64()).collect();
    let seconds: f64 = spent.iter().sum();
    spent.sort_by(f64::total_cmp);
    let mut steps: Vec<u32> = run.spent.iter().map(|(_, steps)| *steps).collect();
    steps.sort_unstable();
    let (Some(min), Some(max)) = (spent.first(), spent.last()) else {
        return Err("it never touched the ball".to_owned());
    };
    let stopped = if run.frames < FRAMES {
        format!("; stopped after {} of {FRAMES} frames", run.frames)
    } else {
        String::new()
    };
    let millis = |seconds: &f64| seconds * 1e3;
    Ok(json!({
        "name": format!("s1-other-{}-{side}", entry.name),
        "command": "cargo run --release --manifest-path scripts/others/Cargo.toml -- --out others.jsonl",
        "machine": processor(),
        "program": program,
        "quick": false,
        "result": {
            "device": format!("cpu, 1 thread, {program}"),
            "precision": "f32",
            "nodes": side * side,
            "springs": engine.spring_count(),
            "substeps_per_frame": steps[steps.len() / 2],
            "frames": spent.len(),
            "ms_per_frame": { "min": millis(min), "median": millis(&spent[spent.len() / 2]), "max": millis(max) },
            "steps_per_s": f64::from(steps.iter().sum::<u32>()) / seconds,
            "max_stretch": run.stretch,
            "lowest": run.last.heights[0],
            "highest": run.last.heights[1],
            "nearest": run.last.ball_gap,
            "nearest_ever": run.nearest,
            "note": format!("{}{stopped}", entry.note),
        },
    }))
}

/// What happened in a run.
struct Run {
    /// Frames that began with the cloth at the ball: how long, and of how many steps.
    spent: Vec<(Duration, u32)>,
    /// All frames.
    frames: u32,
    /// Largest of all frames.
    stretch: f32,
    /// Least distance of a node from the ball's surface in all frames, negative inside [m].
    nearest: f32,
    /// At the end.
    last: Look,
}

impl Run {
    fn of(engine: &mut dyn Engine) -> Result<Self, String> {
        let springs = engine.springs();
        let start = Instant::now();
        let last = sheet::look(&engine.positions(), &springs)?;
        let mut run =
            Self { spent: Vec::new(), frames: 0, stretch: last.stretch, nearest: last.ball_gap, last };
        while run.frames < FRAMES && start.elapsed() < PATIENCE {
            let begin = Instant::now();
            let steps = engine.frame()?;
            let time = begin.elapsed();
            if run.last.touching > 0 {
                run.spent.push((time, steps));
            }
            run.frames += 1;
            run.last = sheet::look(&engine.positions(), &springs)
                .map_err(|why| format!("frame {}: {why}", run.frames))?;
            run.stretch = run.stretch.max(run.last.stretch);
            run.nearest = run.nearest.min(run.last.ball_gap);
        }
        Ok(run)
    }
}

impl std::fmt::Display for Run {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Look { heights: [low, high], ball_gap, touching, stretch } = self.last;
        write!(
            f,
            "{} frames, {} of them timed; at the end from {low:.3} to {high:.3} m, {touching} nodes at the ball, none nearer to its \
             surface than {ball_gap:.4} m, stretch {stretch:.3}; in all frames stretch {:.3}, nearest {:.4} m",
            self.frames,
            self.spent.len(),
            self.stretch,
            self.nearest,
        )
    }
}

/// Of a package in the lock file that this program was built with.
fn version(package: &str) -> &'static str {
    let lock = include_str!("../Cargo.lock");
    let of = format!("name = \"{package}\"\nversion = \"");
    lock.split_once(&of).and_then(|(_, rest)| rest.split('"').next()).unwrap_or("of unknown version")
}

/// The processor's name, where the system tells it.
fn processor() -> String {
    let told = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name =
        told.lines().find(|line| line.starts_with("model name")).and_then(|line| line.split_once(": "));
    name.map_or(std::env::consts::ARCH, |(_, name)| name).to_owned()
}
