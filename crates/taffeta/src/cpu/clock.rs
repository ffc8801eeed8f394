//! Times of a frame by stage: what the first worker spends on each. Waiting for the others between sub-steps, and going over
//! tiles, have a name of their own.

use crate::step::Stage;
use std::cell::Cell;
use std::time::Instant;

/// What is no part of a stage.
const BETWEEN: usize = Stage::ALL.len();

/// Time that stages take [s], each without those inside it.
#[derive(Default)]
pub struct Clock {
    times: [Cell<f64>; BETWEEN + 1],
}

impl Clock {
    /// Times by the names of stages, those that took none left out.
    pub fn by_name(&self) -> Vec<(&'static str, f64)> {
        let names = Stage::ALL.into_iter().map(Stage::name).chain(["between"]);
        names.zip(self.times.iter().map(Cell::get)).filter(|&(_, time)| time > 0.0).collect()
    }

    fn total(&self) -> f64 {
        self.times.iter().map(Cell::get).sum()
    }

    /// Does a job of a stage, or of none; where there is a clock, it counts what other stages inside it do not.
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
