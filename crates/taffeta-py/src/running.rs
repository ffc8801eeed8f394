//! A simulation as Python's threads share it, and its frames.

use crate::arrays::Rows;
use crate::errors::{Failure, advised, guarded};
use crate::options::Choices;
use crate::scene::{Read, Written};
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};
use taffeta::scene::{Scene, World, identity};
use taffeta::{Simulation, Snapshot, StepError};
use taffeta_io::checkpoint::{Checkpoint, difference};

/// How long a frame may take that is not stopped on its way.
const SHORT: Duration = Duration::from_millis(40);
/// Time between two looks at signals.
const LOOK: Duration = Duration::from_millis(20);

/// A simulation, and what Python may ask of it that it does not keep itself.
pub struct Running {
    pub simulation: Simulation,
    /// The world as it is.
    pub world: World,
    /// What is read, before it goes into an array.
    pub rows: Rows,
    /// What was said when the scene was read.
    notes: Vec<String>,
    scene: Scene,
    /// What checkpoints call the scene, once it was asked for.
    identity: Option<String>,
    /// Time of the last frame; none before the first.
    last: Option<Duration>,
    /// Whether a mistake of ours has stopped it.
    broken: bool,
}

impl Running {
    /// Builds a scene, and says why it runs where it does.
    pub fn build(written: Written, choices: &Choices) -> Result<(Self, String), Failure> {
        let read = written.read()?;
        let (simulation, why) = choices.build(&read)?;
        let Read { loaded, .. } = read;
        let rows = Rows::empty(simulation.precision());
        let world = loaded.scene.world.clone();
        let (scene, notes) = (loaded.scene, loaded.notes);
        Ok((Self { simulation, world, rows, notes, scene, identity: None, last: None, broken: false }, why))
    }

    /// What the user should know before it runs.
    pub fn warnings(&self) -> Vec<String> {
        let warnings = self.simulation.warnings().iter();
        self.notes.iter().cloned().chain(warnings.map(|warning| advised(warning, &warning.advice))).collect()
    }

    /// Does `work`, unless a mistake of ours has stopped the simulation before, or does now.
    pub fn work<R>(&mut self, work: impl FnOnce(&mut Self) -> Result<R, Failure>) -> Result<R, Failure> {
        if self.broken {
            let what = "a mistake in taffeta has stopped this simulation before; a new one would do";
            return Err(Failure::Internal(what.to_owned()));
        }
        let result = guarded(|| work(self));
        self.broken = matches!(result, Err(Failure::Internal(_)));
        result
    }

    /// Runs a frame.
    pub fn frame(&mut self) -> Result<(), Failure> {
        let start = Instant::now();
        self.work(|running| Ok(running.simulation.step().map(drop)?))?;
        self.last = Some(start.elapsed());
        Ok(())
    }

    /// Runs a frame; where `stop` becomes true on the way, the state is that before it.
    fn frame_unless(&mut self, stop: &Arc<AtomicBool>) -> Result<(), Failure> {
        let start = Instant::now();
        self.work(|running| {
            let before = running.simulation.snapshot();
            match running.simulation.step_unless(stop) {
                Err(StepError::Stopped { .. }) => Ok(running.simulation.restore(&before)?),
                stepped => Ok(stepped.map(drop)?),
            }
        })?;
        self.last = Some(start.elapsed());
        Ok(())
    }

    /// Whether the next frame may take so long that one would want to stop it on its way. Those of GPUs are not stopped.
    fn may_be_long(&self) -> bool {
        self.simulation.backend() == "cpu" && self.last.is_none_or(|last| last >= SHORT)
    }

    /// The state as the bytes of a checkpoint.
    pub fn snapshot(&mut self) -> Result<Vec<u8>, Failure> {
        let snapshot = self.simulation.snapshot();
        if snapshot.halted {
            let frame = snapshot.report.frame;
            let what = format!(
                "the frame after frame {frame} diverged, and none goes on from there; a snapshot from before would do"
            );
            return Err(Failure::Snapshot(what));
        }
        let scene = self.identity().to_owned();
        Checkpoint { scene, snapshot, run: () }.to_bytes().map_err(Failure::Snapshot)
    }

    /// Takes up the state of a checkpoint.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), Failure> {
        let refuse = |what: String| Failure::Snapshot(format!("the snapshot is {what}"));
        let checkpoint = Checkpoint::<()>::parse(bytes).map_err(refuse)?;
        if let Some(difference) = difference(&checkpoint.scene, self.identity()) {
            return Err(refuse(format!("of another scene: {difference}")));
        }
        self.take_up(&checkpoint.snapshot)
    }

    /// Takes up a state.
    pub fn take_up(&mut self, snapshot: &Snapshot) -> Result<(), Failure> {
        self.simulation.restore(snapshot)?;
        self.world = snapshot.changes.world.clone();
        Ok(())
    }

    fn identity(&mut self) -> &str {
        let scene = &self.scene;
        self.identity.get_or_insert_with(|| identity(scene))
    }
}

/// Holds it. Whoever holds it must not wait for Python.
pub fn hold(shared: &Mutex<Running>) -> MutexGuard<'_, Running> {
    // What a panic leaves is marked as broken.
    shared.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// Runs frames without Python, which handles signals between them; after an exception the state is that of the last whole frame.
pub fn step(py: Python<'_>, shared: &Mutex<Running>, frames: u32) -> PyResult<()> {
    let mut left = frames;
    while left > 0 {
        left -= py.detach(|| some(shared, left))?;
        py.check_signals()?;
    }
    Ok(())
}

/// Runs some frames, at most so many, until it is time to look at signals.
fn some(shared: &Mutex<Running>, most: u32) -> Result<u32, Failure> {
    let mut running = hold(shared);
    if running.may_be_long() {
        drop(running);
        return watched(shared).map(|()| 1);
    }
    let (start, mut done) = (Instant::now(), 0);
    while done < most && start.elapsed() < LOOK {
        running.frame()?;
        done += 1;
    }
    Ok(done)
}

/// Runs a frame on another thread while this one looks at signals, which Python handles on its main thread alone.
fn watched(shared: &Mutex<Running>) -> Result<(), Failure> {
    let (stop, (ended, end)) = (Arc::new(AtomicBool::new(false)), channel());
    std::thread::scope(|scope| {
        let stopped = &stop;
        let work = move || {
            let result = hold(shared).frame_unless(stopped);
            // Somebody waits until this is dropped.
            let _ = ended.send(());
            result
        };
        let Ok(worker) = std::thread::Builder::new().spawn_scoped(scope, work) else {
            return hold(shared).frame();
        };
        let mut raised = None;
        while end.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
            if raised.is_none()
                && let Err(error) = Python::attach(|py| py.check_signals())
            {
                stop.store(true, Ordering::Relaxed);
                raised = Some(error);
            }
        }
        let result = worker.join();
        let result =
            result.unwrap_or_else(|_| Err(Failure::Internal("a thread of a frame panicked".to_owned())));
        raised.map_or(result, |error| Err(error.into()))
    })
}
