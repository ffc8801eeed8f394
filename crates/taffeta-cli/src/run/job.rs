//! The frames of a run, its checkpoints, and the ways in which it ends.

use super::args::Verify;
use super::outputs::{self, Mark, Outputs};
use super::plan::Plan;
use super::progress::Progress;
use super::tally::Tally;
use crate::console::{self, counted};
use crate::intersections;
use crate::memory::{Growth, Watch};
use crate::summary::Status;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use taffeta::scene::{Body, Scene};
use taffeta::{OnDivergence, Simulation, StepError};
use taffeta_io::Checkpoint;
use taffeta_io::program::{Failure, complain};

/// How long a frame may take [ms] that is not stopped on its way: others need the state before them.
const SHORT: f64 = 40.0;
/// A snapshot that takes less than this part of the last frame is taken before each.
const CHEAP: f64 = 0.02;

/// Part of their thickness to which surfaces are squeezed before they are pressed through each other.
const THIN: f64 = 0.1;
/// Frames between two looks at them, which take long.
const LOOKS: u32 = 8;

/// A run under way.
pub struct Job<'a> {
    pub plan: &'a Plan,
    pub simulation: Simulation,
    pub outputs: Outputs,
    pub tally: Tally,
    memory: Watch,
    /// The frame from which on surfaces that are squeezed thin are looked at; none where nothing is to be said of them.
    next_look: Option<u32>,
    /// Time of the last frame [ms].
    last: f64,
    /// Time of the last snapshot before a frame [ms].
    snapshot_ms: f64,
    /// Frame of the last checkpoint.
    pub saved: Option<u32>,
    /// How many bodies are frozen, as far as that has been said.
    frozen: usize,
}

/// How the frames ended.
pub enum Ending {
    Done,
    Diverged(StepError),
    Interrupted,
    /// Surfaces pass through each other, in words, and the run was to stop there.
    Intersected(String),
    /// Another frame may need more memory than is free, in words.
    Full(String),
    /// A file could not be written.
    Failed(io::Error),
    /// The device does not answer any more, and the state that it had is gone.
    Lost(StepError),
}

impl From<io::Error> for Ending {
    fn from(error: io::Error) -> Self {
        Self::Failed(error)
    }
}

impl From<StepError> for Ending {
    fn from(error: StepError) -> Self {
        match error {
            StepError::Stopped { .. } => Self::Interrupted,
            StepError::Diverged(_) => Self::Diverged(error),
            _ => Self::Lost(error),
        }
    }
}

impl Ending {
    /// Whether the simulation has the state of the last frame.
    pub fn is_orderly(&self) -> bool {
        matches!(self, Self::Done | Self::Interrupted | Self::Full(_) | Self::Intersected(_))
    }

    /// The ending in one word.
    pub fn status(&self) -> Status {
        match self {
            Self::Done => Status::Done,
            Self::Diverged(_) => Status::Diverged,
            Self::Interrupted | Self::Full(_) => Status::Interrupted,
            Self::Intersected(_) => Status::Intersected,
            Self::Failed(_) | Self::Lost(_) => Status::Failed,
        }
    }
}

impl<'a> Job<'a> {
    /// Starts the files, or takes up what the plan says was done before. Nothing is touched before all is found there.
    pub fn new(plan: &'a Plan, mut simulation: Simulation, scene: &Scene) -> Result<Self, Failure> {
        let mut tally = Tally::new(&simulation);
        if let Some(earlier) = &plan.earlier {
            simulation
                .restore(&earlier.snapshot)
                .map_err(|why| Failure::Input(format!("--resume: {why}")))?;
            tally = earlier.run.tally.clone();
            outputs::check_left(plan, &simulation, &earlier.run.mark)?;
            // What is asked for now holds from now on, whatever happens; the files are longer than it says.
            write_checkpoint(plan, &simulation, &earlier.run.mark, &tally)?;
        }
        let mut outputs = Outputs::open(plan, &simulation, scene.time.dt)?;
        if let Some(earlier) = &plan.earlier {
            outputs.rewind(&earlier.run.mark, &simulation)?;
        }
        let saved = plan.earlier.as_ref().map(|earlier| earlier.snapshot.report.frame);
        let memory = Watch::new(scene, &simulation);
        let next_look =
            (plan.verify.is_none() && scene.bodies.iter().any(Body::has_surface_contact)).then_some(0);
        let (last, snapshot_ms, frozen) = (f64::INFINITY, f64::INFINITY, simulation.frozen().len());
        Ok(Self { plan, simulation, outputs, tally, memory, next_look, last, snapshot_ms, saved, frozen })
    }

    /// All frames. Where a file cannot be written, all files are as they were after the frame before.
    pub fn run(&mut self, quiet: bool, stop: &Arc<AtomicBool>) -> Ending {
        let (Ok(ending) | Err(ending)) = self.frames(quiet, stop);
        match (&ending, self.plan.every) {
            (Ending::Failed(_), _) => self.outputs.go_back(),
            (Ending::Interrupted | Ending::Full(_), _) | (Ending::Done, Some(_)) => {
                if let Err(error) = self.save() {
                    return Ending::Failed(error);
                }
            }
            _ => {}
        }
        // After the checkpoint: a run that goes on counts at its own end.
        if ending.is_orderly() {
            self.count();
        }
        ending
    }

    fn frames(&mut self, quiet: bool, stop: &Arc<AtomicBool>) -> Result<Ending, Ending> {
        let progress = Progress::new(self.simulation.frame(), self.plan.end, quiet);
        if self.outputs.frames() == 0 {
            self.simulation.fetch()?;
            self.keep(0.0)?;
            self.count();
        }
        while self.simulation.frame() < self.plan.end {
            if stop.load(Ordering::Relaxed) {
                return Ok(Ending::Interrupted);
            }
            progress.frame(self.frame(stop)?);
        }
        Ok(Ending::Done)
    }

    /// One frame, and a checkpoint where it is time for one; the frame's time [ms].
    fn frame(&mut self, stop: &Arc<AtomicBool>) -> Result<f64, Ending> {
        let ms = self.step(stop)?;
        self.last = ms;
        self.tally.add(self.simulation.report(), ms);
        self.keep(ms)?;
        if self.plan.every.is_some_and(|every| self.simulation.frame().is_multiple_of(every)) {
            self.save()?;
        }
        self.look_at_squeezed();
        self.look_at_frozen();
        match self.memory.look(self.simulation.memory() as u64) {
            Some(Growth::TooMuch(words)) if self.simulation.frame() < self.plan.end => {
                return Err(Ending::Full(words));
            }
            Some(Growth::Beyond(words)) => complain(&words),
            _ => {}
        }
        Ok(ms)
    }

    /// One frame, unless the user wants to stop while it takes long: then the state is that before it. The frame's time [ms].
    fn step(&mut self, stop: &Arc<AtomicBool>) -> Result<f64, Ending> {
        // A frame in which a body diverges is run again as often as it takes.
        let may_be_long = self.last >= SHORT || self.plan.on_divergence == OnDivergence::Freeze;
        // One that follows short ones may take long, too: it can be given up where the way back costs next to nothing.
        let is_cheap = self.snapshot_ms < CHEAP * self.last;
        let start = Instant::now();
        let before = ((may_be_long || is_cheap) && self.simulation.backend() == "cpu").then(|| {
            let snapshot = self.simulation.snapshot();
            self.snapshot_ms = start.elapsed().as_secs_f64() * 1e3;
            snapshot
        });
        let start = Instant::now();
        let Some(before) = before else {
            self.simulation.step()?;
            // A device that is lost now must not be seen in the files.
            self.simulation.fetch()?;
            return Ok(start.elapsed().as_secs_f64() * 1e3);
        };
        let stepped = self.simulation.step_unless(stop).map(|_| start.elapsed().as_secs_f64() * 1e3);
        if matches!(stepped, Err(StepError::Stopped { .. })) {
            self.simulation.restore(&before).map_err(|why| Ending::Failed(io::Error::other(why)))?;
        }
        Ok(stepped?)
    }

    /// Puts the frame, which took `ms` [ms], into the files.
    fn keep(&mut self, ms: f64) -> Result<(), Ending> {
        let found = self.plan.verify.map(|_| self.simulation.intersections());
        // While surfaces are pulled apart the simulation counts them itself.
        let pairs = found.as_ref().map(|found| found.pairs).or(self.simulation.report().intersections);
        self.outputs.frame(&self.simulation, pairs, ms)?;
        let frame = self.simulation.frame();
        if let Some(pairs) = pairs {
            self.tally.intersections(frame, pairs);
        }
        let Some(found) = found else { return Ok(()) };
        match (self.plan.verify, found.first) {
            (Some(Verify::Stop), Some(first)) => Err(Ending::Intersected(format!(
                "frame {frame} has {}: {first}",
                counted(found.pairs as usize, "intersection", "intersections")
            ))),
            _ => Ok(()),
        }
    }

    /// Counts intersections where not every frame does.
    fn count(&mut self) {
        let found = if self.plan.verify.is_none() { intersections::counted(&self.simulation) } else { None };
        if let Some(found) = found {
            self.tally.intersections(self.simulation.frame(), found.pairs);
        }
    }

    /// Says which bodies have been frozen in the last frame.
    fn look_at_frozen(&mut self) {
        for one in self.simulation.frozen().iter().skip(self.frozen) {
            let what = console::advised(&one.why, &one.why.advice);
            complain(&format!("warning: {what}\nit stands still from now on; the others go on"));
        }
        self.frozen = self.simulation.frozen().len();
    }

    /// Says once where surfaces have been pressed through each other, as between colliders that leave no room.
    fn look_at_squeezed(&mut self) {
        let (report, frame) = (self.simulation.report(), self.simulation.frame());
        let is_thin = report.nearest_pair.is_some_and(|nearest| nearest < THIN);
        // Nobody looks after the last frame.
        let is_early = |next: u32| frame < next.min(self.plan.end);
        if !is_thin || report.intersections.is_some() || self.next_look.is_none_or(is_early) {
            return;
        }
        self.next_look = Some(frame + LOOKS);
        if let Some(first) = self.simulation.intersections().first {
            self.next_look = None;
            complain(&format!(
                "warning: frame {frame}: surfaces were pressed through each other: {first}. What is pinned or between two colliders \
                 cannot give way; more room or thinner contact would do (--verify-contact counts this in every frame)"
            ));
        }
    }

    /// Writes a checkpoint, unless there is one of this frame. The results are on the disk before it says so.
    fn save(&mut self) -> io::Result<()> {
        let frame = self.simulation.frame();
        if self.saved == Some(frame) && self.path().exists() {
            return Ok(());
        }
        let mark = self.outputs.sync()?;
        write_checkpoint(self.plan, &self.simulation, &mark, &self.tally)?;
        self.saved = Some(frame);
        Ok(())
    }

    /// Path of the checkpoint.
    pub fn path(&self) -> PathBuf {
        self.plan.checkpoint()
    }
}

/// Writes the checkpoint of a run whose files end at `mark`.
fn write_checkpoint(plan: &Plan, simulation: &Simulation, mark: &Mark, tally: &Tally) -> io::Result<()> {
    let run = plan.record(simulation, mark, tally);
    Checkpoint { scene: plan.scene.clone(), snapshot: simulation.snapshot(), run }.write(&plan.checkpoint())
}

/// Whether the user wants the run to end, from now on.
pub fn stop_on_ctrl_c() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&stop);
    let asked = move || {
        if seen.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        complain("stopping; once more to stop at once, without a checkpoint");
    };
    ctrlc::set_handler(asked).map_err(|error| Failure::Work(format!("cannot listen for Ctrl-C: {error}")))?;
    Ok(stop)
}

#[cfg(test)]
mod tests;
