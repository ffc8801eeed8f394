//! Frames of a simulation: submitted, and then polled.

use crate::backend::{FrameInput, Lost};
use crate::diagnostics::advice::runaway;
use crate::report::FrameReport;
use crate::simulation::{InputError, OnDivergence, Simulation, StepError};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

impl Simulation {
    /// Submits frames without waiting for their reports. On a GPU nothing waits, and nothing is read back, except where a frame may be
    /// repeated: with contact between triangles, and in implicit steps of many iterations; that [`OnDivergence::Freeze`] keeps what
    /// solvers remember, once after each poll; and that positions are read before each frame of a scene whose bodies may
    /// [sleep](crate::scene::Sleep), while one is awake.
    ///
    /// # Errors
    /// A GPU may be lost. After [`StepError::Stopped`] or [`StepError::Diverged`] no frame runs before [`Self::restore`]: the error
    /// is the same again. So it is where frames would be more than 32 bits count.
    pub fn submit(&mut self, frames: u32) -> Result<(), StepError> {
        if let Some(error) = &self.halted {
            return Err(error.clone());
        }
        let before = self.frame();
        let end = before.checked_add(frames).ok_or(InputError::TooManyFrames { before, frames })?;
        self.keep_given(frames);
        for before in before..end {
            let driven = match self.start_frame(before) {
                Err(error @ StepError::Stopped { .. }) => return Err(self.halt(error)),
                driven => driven?,
            };
            self.submitted = (self.submitted.0 + 1, self.submitted.1 | driven);
        }
        Ok(())
    }

    /// Runs one frame, unless `stop` becomes true on the way: then it ends as soon as possible, for a program that wants to react while
    /// frames take long. On the CPU that is within a stage of a sub-step or an iteration of a solver, mostly some milliseconds; frames
    /// on a GPU are not stopped.
    ///
    /// ```
    /// # use taffeta::scene::{Body, Mass, Mesh, Scene, Select};
    /// # use taffeta::{Options, Simulation};
    /// # let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2));
    /// # let scene = Scene::new("").time(0.01, 1e-3).body(cloth.structural(50.0, 0.05).pin(Select::nodes([0])));
    /// # let mut simulation = Simulation::new(&scene, &Options::default())?;
    /// use std::sync::Arc;
    /// use std::sync::atomic::{AtomicBool, Ordering};
    /// use taffeta::StepError;
    ///
    /// // Another thread sets it when the user presses a key.
    /// let stop = Arc::new(AtomicBool::new(false));
    /// simulation.step_unless(&stop)?;
    /// let before = simulation.snapshot();
    /// stop.store(true, Ordering::Relaxed);
    /// let stopped = simulation.step_unless(&stop);
    /// assert!(matches!(stopped, Err(StepError::Stopped { frame: 2 })));
    /// simulation.restore(&before)?;
    /// assert_eq!(simulation.step()?.frame, 2);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::step`]; and [`StepError::Stopped`] where it was stopped. Positions and velocities stay those of the frame before, and
    /// no further frame runs before [`Self::restore`], as solvers remember a part of the frame.
    pub fn step_unless(&mut self, stop: &Arc<AtomicBool>) -> Result<&FrameReport, StepError> {
        // Frames under way are whole, whatever becomes of this one.
        self.poll()?;
        self.backend.stop_on(Some(Arc::clone(stop)));
        let ended = self.submit(1).and_then(|()| self.poll().map(drop));
        self.backend.stop_on(None);
        ended.map(|()| &self.report)
    }

    /// Waits for the frames that were submitted, and reports the last.
    ///
    /// # Errors
    /// As [`Self::advance`].
    pub fn poll(&mut self) -> Result<&FrameReport, StepError> {
        let (frames, driven) = std::mem::take(&mut self.submitted);
        if frames > 0 {
            let frame = self.report.frame + frames;
            if let Some(what) = self.judge(frame, driven)? {
                let suspects = self.suspects();
                let why = self.diverged([self.report.frame + 1, frame], what, &suspects);
                let now = self.given(0);
                self.return_to_good().map_err(|Lost(why)| StepError::Lost { frame, why })?;
                match self.on_divergence {
                    OnDivergence::Stop => return Err(self.halt(why.into())),
                    OnDivergence::Freeze => self.go_on_without(&now, suspects, why)?,
                }
            }
        }
        match &self.halted {
            Some(error) => Err(error.clone()),
            None => Ok(&self.report),
        }
    }

    /// Waits for the frames until `frame`. They are reported if they are good, else it is said why they are not.
    pub(super) fn judge(&mut self, frame: u32, driven: bool) -> Result<Option<String>, StepError> {
        let ran = frame - self.sleeping.idle;
        let what = if ran > self.report.frame { self.judge_run(ran, driven)? } else { None };
        if what.is_none() && ran < frame {
            let time = f64::from(frame) * self.dt();
            let volume_targets = self.backend.assembly().volume_targets(time);
            self.report =
                FrameReport { frame, time, substeps: 0, volume_targets, ..std::mem::take(&mut self.report) };
            self.mark_good();
        }
        Ok(what)
    }

    /// The same of frames of which the last was run.
    fn judge_run(&mut self, frame: u32, driven: bool) -> Result<Option<String>, StepError> {
        let sums = self.backend.sums().map_err(|Lost(why)| StepError::Lost { frame, why })?;
        let held = sums.held.clone();
        let far = sums.blown_up;
        let report = self.report_of(sums, frame);
        let what = runaway(&self.start, &self.report, &report, driven).or_else(|| {
            (far > 0.0).then(|| {
                format!(
                    "a node would have gone {far:.0} mean edges further in a sub-step than contact has let it"
                )
            })
        });
        if what.is_none() {
            (self.report, self.held) = (report, held);
            self.mark_good();
        }
        Ok(what)
    }

    /// No frame runs from now on.
    pub(super) fn halt(&mut self, error: StepError) -> StepError {
        self.halted.insert(error).clone()
    }

    /// Gives the backend the frame after `before`; returns whether anything but gravity drives the scene in it.
    pub(super) fn start_frame(&mut self, before: u32) -> Result<bool, StepError> {
        let frame = before + 1;
        let start = f64::from(before) * self.backend.assembly().time.dt;
        let mut input = std::mem::take(&mut self.input);
        self.follow_poses(before, &mut input);
        let lost = |Lost(why)| StepError::Lost { frame, why };
        if self.decide_who_sleeps(before, &input).map_err(lost)? {
            self.sleeping.idle += 1;
            return Ok(false);
        }
        self.sleeping.idle = 0;
        let driven =
            self.backend.assembly().is_driven() || !input.forces.is_empty() || !input.moves.is_empty();
        let goes_on = |node: u32| input.moves.binary_search_by_key(&node, |&(node, ..)| node).is_ok();
        for node in std::mem::take(&mut self.moved).into_iter().filter(|&node| !goes_on(node)) {
            let at = self.backend.position(node as usize);
            self.backend.set(node as usize, at, [0.0; 3]);
        }
        self.moved = input.moves.iter().map(|&(node, ..)| node).collect();
        self.backend.frame(start, input).map_err(lost)?;
        if self.backend.was_stopped() { Err(StepError::Stopped { frame }) } else { Ok(driven) }
    }

    /// Adds what poses of pins move in the frame after `before`.
    fn follow_poses(&self, before: u32, input: &mut FrameInput) {
        let (assembly, dt) = (self.backend.assembly(), self.dt());
        let moves = assembly.posed_moves([f64::from(before) * dt, f64::from(before + 1) * dt]);
        input
            .moves
            .extend(moves.into_iter().filter(|&(node, ..)| !self.is_frozen(assembly.number_of_body(node))));
        input.moves.sort_unstable_by_key(|&(node, ..)| node);
    }
}
