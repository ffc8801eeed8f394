//! Times of a frame by stage, as the first worker spends them. Waiting for other workers between sub-steps, and
//! iterating over tiles, have names of their own.

use crate::step::Stage;
use std::cell::Cell;
use web_time::Instant;

/// Time outside of stages.
const BETWEEN: usize = Stage::ALL.len();

/// Time of each stage [s], without stages inside it.
#[derive(Default)]
pub struct Clock {
    times: [Cell<f64>; BETWEEN + 1],
}

impl Clock {
    /// Times by the names of stages, without those that took none.
    pub fn by_name(&self) -> Vec<(&'static str, f64)> {
        let names = Stage::ALL.into_iter().map(Stage::name).chain(["between"]);
        names.zip(self.times.iter().map(Cell::get)).filter(|&(_, time)| time > 0.0).collect()
    }

    fn total(&self) -> f64 {
        self.times.iter().map(Cell::get).sum()
    }

    /// Runs a job of a stage, or of none. If there is a clock, it measures the job without other stages inside it.
    #[inline]
    pub fn time<R>(clock: Option<&Self>, stage: Option<Stage>, job: impl FnOnce() -> R) -> R {
        let Some(clock) = clock else { return job() };
        let (before, start) = (clock.total(), Instant::now());
        let result = job();
        let inside = clock.total() - before;
        let time = &clock.times[stage.map_or(BETWEEN, |stage| stage as usize)];
        time.set(time.get() + (start.elapsed().as_secs_f64() - inside).max(0.0));
        result
    }
}
