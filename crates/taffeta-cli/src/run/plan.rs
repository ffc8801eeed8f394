//! What a run does: what the user asked for, and, of a run that goes on, what it did before.

use super::args::{Args, Arithmetic, Verify};
use super::format::Format;
use super::outputs::Mark;
use super::tally::Tally;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use taffeta::{OnDivergence, Precision, Simulation};
use taffeta_io::checkpoint::{Checkpoint, difference, identity};
use taffeta_io::program::Failure;
use taffeta_io::{Loaded, output::Begin};

/// Name of a run's checkpoint, in its folder.
const NAME: &str = "checkpoint.taffeta";

/// What a run remembers of itself, beside the state of the simulation.
#[derive(Clone, Serialize, Deserialize)]
pub struct Record {
    /// Formats of its results.
    pub formats: Vec<Format>,
    /// Arithmetic.
    pub precision: Precision,
    /// Precision of the numbers in its caches.
    pub cache_precision: Precision,
    /// Frames asked for on the command line.
    pub frames: Option<u32>,
    /// Frames that it was to do.
    pub end: u32,
    /// Frames between checkpoints.
    pub every: Option<u32>,
    /// Whether intersections are counted.
    pub verify: Option<Verify>,
    /// What becomes of bodies that diverge.
    pub on_divergence: OnDivergence,
    /// Where its files end.
    pub mark: Mark,
    /// What it adds up to so far.
    pub tally: Tally,
    /// What it computed on: `cpu` or `gpu`.
    pub backend: String,
    /// The device in words.
    pub device: String,
}

/// A run's options, all decided.
pub struct Plan {
    /// Folder of the results.
    pub dir: PathBuf,
    /// Identity of the scene.
    pub scene: String,
    /// Arithmetic.
    pub precision: Precision,
    /// As [`Record`] has them; mark and tally are still those of the checkpoint.
    pub formats: Vec<Format>,
    /// Precision of the numbers in the caches.
    pub cache_precision: Precision,
    /// Frames asked for on the command line, now or when the run began.
    pub frames: Option<u32>,
    /// The last frame.
    pub end: u32,
    /// Frames between checkpoints; `None`: a checkpoint only where the user stops the run.
    pub every: Option<u32>,
    /// Whether intersections are counted.
    pub verify: Option<Verify>,
    /// What becomes of bodies that diverge.
    pub on_divergence: OnDivergence,
    /// Full paths of the files that the scene was read from.
    pub inputs: Vec<PathBuf>,
    /// Where the run goes on.
    pub earlier: Option<Checkpoint<Record>>,
}

impl Plan {
    /// Decides, and refuses a checkpoint that does not fit the scene.
    pub fn new(args: &Args, loaded: &Loaded) -> Result<Self, Failure> {
        let scene = identity(&loaded.scene);
        let Some(path) = &args.resume else {
            let plan = Self::afresh(args, scene, loaded);
            return plan.refuse_to_overwrite(args);
        };
        let path = if path.is_dir() { &path.join(NAME) } else { path };
        let dir = Self::dir(args);
        let earlier = Checkpoint::<Record>::read(path).map_err(|why| refused(&why))?;
        if let Some(difference) = difference(&earlier.scene, &scene) {
            let why = format!("{}: it is of another scene: {difference}", path.display());
            return Err(refused(&why));
        }
        let record = &earlier.run;
        let frames = args.frames.or(record.frames);
        let plan = Self {
            dir,
            scene,
            precision: args.precision.map_or(record.precision, Arithmetic::precision),
            formats: formats(args, record)?,
            cache_precision: record.cache_precision,
            frames,
            end: frames.unwrap_or(loaded.scene.time.frames),
            every: args.checkpoint_every.or(record.every),
            verify: args.verify_contact.or(record.verify),
            on_divergence: args.on_divergence.map_or(record.on_divergence, |what| what.of_engine()),
            inputs: loaded.files.clone(),
            earlier: Some(earlier),
        };
        plan.refuse_to_go_back()
    }

    fn afresh(args: &Args, scene: String, loaded: &Loaded) -> Self {
        let precision = args.precision.unwrap_or(Arithmetic::F32).precision();
        Self {
            dir: Self::dir(args),
            scene,
            precision,
            formats: sorted(args.format.as_deref().unwrap_or(&[Format::Npy])),
            cache_precision: precision,
            frames: args.frames,
            end: args.frames.unwrap_or(loaded.scene.time.frames),
            every: args.checkpoint_every,
            verify: args.verify_contact,
            on_divergence: args.on_divergence.map_or_else(Default::default, |what| what.of_engine()),
            inputs: loaded.files.clone(),
            earlier: None,
        }
    }

    /// Folder of the results: what was asked for, else that of the checkpoint to go on from, else one of the scene's name.
    pub fn dir(args: &Args) -> PathBuf {
        let stem = args.scene.file_stem().unwrap_or("scene".as_ref());
        let dir = match (&args.out, &args.resume) {
            (Some(dir), _) => dir.clone(),
            (None, Some(resume)) if resume.is_dir() => resume.clone(),
            (None, Some(file)) => file.parent().map(Path::to_owned).unwrap_or_default(),
            (None, None) => Path::new("out").join(stem),
        };
        if dir.as_os_str().is_empty() { PathBuf::from(".") } else { dir }
    }

    /// Frames of hours of work must not be lost because `--resume` was forgotten.
    fn refuse_to_overwrite(self, args: &Args) -> Result<Self, Failure> {
        let path = self.checkpoint();
        if !path.exists() {
            return Ok(self);
        }
        let earlier = Checkpoint::<Record>::read(&path).map_err(|why| {
            let what = "it may belong to an unfinished run; choose another --out, or remove it";
            Failure::Input(format!("{why}; {what}"))
        })?;
        let (frame, end) = (earlier.snapshot.report.frame, earlier.run.end);
        if earlier.run.every.is_none() || frame >= end {
            return Ok(self);
        }
        Err(Failure::Input(format!(
            "{} holds a run that stopped at frame {frame} of {end}; to go on: {}\nor choose another --out, or remove \
             {}",
            self.dir.display(),
            args.resume_command(&path),
            path.display()
        )))
    }

    fn refuse_to_go_back(self) -> Result<Self, Failure> {
        match self.frame() {
            frame if frame > self.end => Err(refused(&format!(
                "the checkpoint is at frame {frame}, after the last one, {}; --frames {frame} or more would do",
                self.end
            ))),
            _ => Ok(self),
        }
    }

    /// The frame from which the run goes on; 0 for a new one.
    pub fn frame(&self) -> u32 {
        self.earlier.as_ref().map_or(0, |earlier| earlier.snapshot.report.frame)
    }

    /// That a run goes on with `simulation`, and what changes thereby, in words.
    pub fn going_on(&self, simulation: &Simulation) -> Option<String> {
        let earlier = self.earlier.as_ref()?;
        let mut words = vec![format!("resuming from frame {} of {}", self.frame(), self.end)];
        let (was, is) = (earlier.snapshot.precision, self.precision);
        if was != is {
            words.push(format!("converted from {was} to {is}"));
        }
        let (was, is) = (earlier.run.backend.as_str(), simulation.backend());
        if was != is {
            words.push(format!("from {was} to {is}"));
        } else if is == "gpu" && earlier.run.device != simulation.device() {
            words.push(format!("on another device than `{}`", earlier.run.device));
        }
        let same = if words.len() > 1 { ": not bit by bit the same as without the stop" } else { "" };
        Some(words.join(", ") + same)
    }

    /// About how many bytes the frames to come will take.
    pub fn bytes(&self, simulation: &Simulation) -> u64 {
        let frames = u64::from(self.end - self.frame()) + 1;
        self.formats.iter().fold(0, |sum: u64, format| sum.saturating_add(format.bytes(simulation, frames)))
    }

    /// Whether files are started or taken up.
    pub fn begin(&self) -> Begin {
        if self.earlier.is_some() { Begin::Again } else { Begin::New }
    }

    /// Path of the run's checkpoint.
    pub fn checkpoint(&self) -> PathBuf {
        self.dir.join(NAME)
    }

    /// What the run remembers where its files end at `mark`.
    pub fn record(&self, simulation: &Simulation, mark: &Mark, tally: &Tally) -> Record {
        Record {
            formats: self.formats.clone(),
            precision: self.precision,
            cache_precision: self.cache_precision,
            frames: self.frames,
            end: self.end,
            every: self.every,
            verify: self.verify,
            on_divergence: self.on_divergence,
            mark: mark.clone(),
            tally: tally.clone(),
            backend: simulation.backend().to_owned(),
            device: simulation.device(),
        }
    }
}

/// Caches go on as they are; poses of the last frame may be asked for at any time.
fn formats(args: &Args, record: &Record) -> Result<Vec<Format>, Failure> {
    let Some(asked) = &args.format else { return Ok(record.formats.clone()) };
    let asked = sorted(asked);
    let caches = |formats: &[Format]| -> Vec<Format> {
        formats.iter().copied().filter(|format| format.is_cache()).collect()
    };
    if caches(&asked) == caches(&record.formats) {
        return Ok(asked);
    }
    Err(refused(&format!(
        "--format: the run writes {}, which cannot change half-way; leave --format out",
        names(&caches(&record.formats))
    )))
}

fn names(formats: &[Format]) -> String {
    match formats {
        [] => "no caches".to_owned(),
        some => some.iter().map(|format| format.name()).collect::<Vec<_>>().join(","),
    }
}

fn sorted(formats: &[Format]) -> Vec<Format> {
    let mut formats = formats.to_vec();
    formats.sort_unstable();
    formats.dedup();
    formats
}

fn refused(why: &str) -> Failure {
    Failure::Input(format!("--resume {why}"))
}
