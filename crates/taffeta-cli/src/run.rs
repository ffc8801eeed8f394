//! `taffeta run`: a scene to files.

mod outputs;
mod progress;
mod tally;

use crate::console::{self, grouped};
use crate::failure::Failure;
use crate::memory;
use crate::summary::{Status, Summary};
use clap::ValueEnum;
use outputs::{Format, Outputs};
use progress::Progress;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use taffeta::{Diverged, Options, Precision, Simulation};
use taffeta_io::Loaded;
use tally::Tally;
pub use tally::{median, rate};

/// Run a scene and write its results
#[derive(clap::Args)]
pub struct Args {
    /// The scene, a TOML file
    scene: PathBuf,
    /// Folder for the results [default: out/<name of the scene>]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Number of frames, instead of the scene's
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    frames: Option<u32>,
    /// Where to compute
    #[arg(long, value_enum, default_value_t = Backend::Auto)]
    backend: Backend,
    /// Worker threads [default: all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Arithmetic
    #[arg(long, value_enum, default_value_t = Arithmetic::F32)]
    precision: Arithmetic,
    /// Change a value of the scene: body.flag.springs.structural.k=500
    #[arg(long = "set", value_name = "PATH=VALUE")]
    sets: Vec<String>,
    /// Formats of the results, with commas between
    #[arg(long, value_enum, value_delimiter = ',', default_value = "npy")]
    format: Vec<Format>,
    /// Write a checkpoint every N frames (not yet supported)
    #[arg(long, value_name = "N")]
    checkpoint_every: Option<u32>,
    /// Go on from a checkpoint (not yet supported)
    #[arg(long, value_name = "FILE")]
    resume: Option<PathBuf>,
    /// Print the summary as JSON, and nothing else on standard output
    #[arg(long)]
    json: bool,
    /// Say nothing unless something is wrong
    #[arg(long)]
    quiet: bool,
}

/// Where to compute.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    /// What is best for the scene
    Auto,
    /// CPU threads
    Cpu,
    /// A GPU (not yet supported)
    Gpu,
}

/// Arithmetic of a run.
#[derive(Clone, Copy, ValueEnum)]
pub enum Arithmetic {
    /// 32 bits: fast
    F32,
    /// 64 bits: the oracle
    F64,
}

impl Arithmetic {
    /// As the engine calls it.
    pub fn precision(self) -> Precision {
        match self {
            Self::F32 => Precision::F32,
            Self::F64 => Precision::F64,
        }
    }

    /// As the user calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }
}

/// Runs a scene.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.refuse_unsupported()?;
    let mut loaded = taffeta_io::load_scene(&args.scene, &args.sets)?;
    loaded.scene.time.frames = args.frames.unwrap_or(loaded.scene.time.frames);
    memory::check(&loaded.scene)?;
    let options = Options { threads: args.threads.map(usize::from), precision: args.precision.precision() };
    let mut simulation =
        Simulation::new(&loaded.scene, &options).map_err(|error| loaded.source.locate(&error))?;
    let stop = stop_on_ctrl_c()?;
    args.say(&opening(&loaded, &simulation, args.backend))?;

    let dir = args.out_dir();
    let mut outputs = Outputs::create(&dir, &args.format, &simulation, loaded.scene.time.dt)?;
    let mut tally = Tally::new(&simulation);
    let ending = frames(args, &loaded, &mut simulation, &mut outputs, &mut tally, &stop)?;
    let files = outputs.finish(&simulation, matches!(ending, Ending::Diverged(_)))?;
    let mut summary = tally.summary(args, &loaded.scene.time, &simulation, ending.status());
    summary.files = files;
    outputs::write_summary(&dir, &summary)?;
    if args.json {
        console::say(&console::json(&summary)?)?;
    }
    args.say(&closing(&summary, &dir))?;
    ending.verdict(&summary, &dir)
}

/// How the frames ended.
enum Ending {
    Done,
    Diverged(Diverged),
    Interrupted,
}

impl Ending {
    fn status(&self) -> Status {
        match self {
            Self::Done => Status::Done,
            Self::Diverged(_) => Status::Diverged,
            Self::Interrupted => Status::Interrupted,
        }
    }

    fn verdict(self, summary: &Summary, dir: &Path) -> Result<(), Failure> {
        let kept = format!("frames 0 to {} are in {}", summary.frames, dir.display());
        match self {
            Self::Done => Ok(()),
            Self::Diverged(error) => Err(Failure::Work(format!("{error}\n{kept}"))),
            Self::Interrupted => Err(Failure::Interrupted(format!("interrupted: {kept}"))),
        }
    }
}

/// Frame 0, then all others, to the outputs.
fn frames(
    args: &Args,
    loaded: &Loaded,
    simulation: &mut Simulation,
    outputs: &mut Outputs,
    tally: &mut Tally,
    stop: &AtomicBool,
) -> Result<Ending, Failure> {
    let count = loaded.scene.time.frames;
    let progress = Progress::new(count, args.quiet);
    outputs.frame(simulation, 0.0)?;
    for _ in 0..count {
        if stop.load(Ordering::Relaxed) {
            return Ok(Ending::Interrupted);
        }
        let start = Instant::now();
        if let Err(error) = simulation.step() {
            return Ok(Ending::Diverged(error));
        }
        let ms = start.elapsed().as_secs_f64() * 1e3;
        tally.add(simulation.report(), ms);
        outputs.frame(simulation, ms)?;
        progress.frame(ms);
    }
    Ok(Ending::Done)
}

fn stop_on_ctrl_c() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&stop);
    let asked = move || {
        if seen.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        eprintln!(
            "stopping after this frame; once more to stop at once, which leaves unfinished .part files"
        );
    };
    ctrlc::set_handler(asked).map_err(|error| Failure::Work(format!("cannot listen for Ctrl-C: {error}")))?;
    Ok(stop)
}

impl Args {
    fn refuse_unsupported(&self) -> Result<(), Failure> {
        let wanted = [
            (self.checkpoint_every.is_some(), "--checkpoint-every"),
            (self.resume.is_some(), "--resume"),
            (self.backend == Backend::Gpu, "--backend gpu"),
            (self.format.contains(&Format::Vtu), "--format vtu"),
        ];
        match wanted.into_iter().find(|(asked, _)| *asked) {
            Some((_, what)) => Err(Failure::not_yet(what)),
            None => Ok(()),
        }
    }

    fn out_dir(&self) -> PathBuf {
        let stem = self.scene.file_stem().unwrap_or("scene".as_ref());
        self.out.clone().unwrap_or_else(|| Path::new("out").join(stem))
    }

    /// To people, where the output is not for a program.
    fn say(&self, text: &str) -> Result<(), Failure> {
        if self.quiet || self.json { Ok(()) } else { console::say(text) }
    }
}

/// What is run, and what is to be known about it.
fn opening(loaded: &Loaded, simulation: &Simulation, backend: Backend) -> String {
    let mut lines = vec![match loaded.scene.title.as_str() {
        "" => "untitled scene".to_owned(),
        title => title.to_owned(),
    }];
    for body in simulation.bodies() {
        let springs = body.springs.iter().map(|(_, count)| count).sum();
        lines.push(format!("  {}: {} nodes, {} springs", body.name, grouped(body.nodes), grouped(springs)));
        lines.extend(body.repairs.iter().map(|repair| format!("    {}", console::mended(repair))));
    }
    lines.extend(loaded.notes.iter().map(|note| format!("note: {note}")));
    lines.extend(simulation.warnings().iter().map(|warning| format!("warning: {warning}")));
    lines.push(match backend {
        Backend::Auto => format!("{} (cpu: this build has no GPU backend yet)", simulation.device()),
        Backend::Cpu | Backend::Gpu => simulation.device(),
    });
    lines.join("\n")
}

fn closing(summary: &Summary, dir: &Path) -> String {
    format!(
        "{} frames, {:.3} ms a frame, largest stretch {:.3}, state {}\nresults in {}",
        summary.frames,
        summary.wall_ms_per_frame,
        summary.max_stretch,
        summary.state_hash,
        dir.display()
    )
}
