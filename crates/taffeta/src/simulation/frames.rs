//! Frames of a simulation: submitted, and then polled.

use crate::backend::Lost;
use crate::diagnostics::advice::runaway;
use crate::report::FrameReport;
use crate::simulation::{Simulation, StepError};

impl Simulation {
    /// Submits frames without waiting for their reports. On a GPU nothing waits, and nothing is read back, except where a frame may be
    /// repeated: with contact between triangles, and in implicit steps of many iterations.
    ///
    /// # Errors
    /// A GPU may be lost. After [`StepError::Stopped`] no frame runs before [`Self::restore`].
    pub fn submit(&mut self, frames: u32) -> Result<(), StepError> {
        for before in self.frame()..self.frame() + frames {
            if self.is_between_frames {
                return Err(StepError::Stopped { frame: before + 1 });
            }
            let lost = |Lost(why)| StepError::Lost { frame: before + 1, why };
            let driven = self.start_frame(before).map_err(lost)?;
            if self.backend.was_stopped() {
                self.is_between_frames = true;
                return Err(StepError::Stopped { frame: before + 1 });
            }
            self.submitted = (self.submitted.0 + 1, self.submitted.1 | driven);
        }
        Ok(())
    }

    /// Waits for the frames that were submitted, and reports the last.
    ///
    /// # Errors
    /// As [`Self::advance`].
    pub fn poll(&mut self) -> Result<&FrameReport, StepError> {
        let (frames, driven) = std::mem::take(&mut self.submitted);
        if frames > 0 {
            let frame = self.report.frame + frames;
            let sums = self.backend.sums().map_err(|Lost(why)| StepError::Lost { frame, why })?;
            self.held.clone_from(&sums.held);
            let report = self.report_of(sums, frame);
            if let Some(what) = runaway(&self.start, &self.report, &report, driven) {
                return Err(self.diverged([self.report.frame + 1, frame], what).into());
            }
            self.report = report;
        }
        Ok(&self.report)
    }

    /// Gives the backend the frame after `before`; returns whether anything but gravity drives the scene in it.
    fn start_frame(&mut self, before: u32) -> Result<bool, Lost> {
        let start = f64::from(before) * self.backend.assembly().time.dt;
        let input = std::mem::take(&mut self.input);
        let driven =
            self.backend.assembly().is_driven() || !input.forces.is_empty() || !input.moves.is_empty();
        let goes_on = |node: u32| input.moves.binary_search_by_key(&node, |&(node, ..)| node).is_ok();
        for node in std::mem::take(&mut self.moved).into_iter().filter(|&node| !goes_on(node)) {
            let at = self.backend.position(node as usize);
            self.backend.set(node as usize, at, [0.0; 3]);
        }
        self.moved = input.moves.iter().map(|&(node, ..)| node).collect();
        self.backend.frame(start, input)?;
        Ok(driven)
    }
}
