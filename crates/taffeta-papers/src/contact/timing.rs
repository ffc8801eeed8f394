//! Times of frames.

use std::time::Instant;

/// Time that is taken where nothing says how many frames [s], and the fewest batches of frames that are timed then.
pub const BUDGET: (f64, usize) = (3.0, 3);
/// Time between two waits for a GPU, about [ms]: so long that the wait does not count.
const BATCH: f64 = 50.0;

/// Times of frames.
pub struct Timed {
    /// Mean time of a frame of each batch [ms]; not empty.
    pub ms: Vec<f64>,
    /// Frames that were timed.
    pub frames: u32,
    /// What the reader should know.
    pub note: Option<String>,
}

impl Timed {
    /// Least, median and most [ms].
    pub fn spread(&self) -> [f64; 3] {
        let mut sorted = self.ms.clone();
        sorted.sort_by(f64::total_cmp);
        [0, sorted.len() / 2, sorted.len() - 1].map(|index| sorted[index])
    }
}

/// Times `frames` frames, or as many as the budget allows and up to `most`, after some that are not timed. `advance` does a number of frames and
/// returns the mean time of one [ms]; a GPU does several without the host.
pub fn of_frames<E>(
    frames: Option<u32>,
    most: u32,
    gpu: bool,
    mut advance: impl FnMut(u32) -> Result<f64, E>,
) -> Result<Timed, E> {
    advance(1)?;
    let batch = if gpu { ((BATCH / advance(1)?) as u32).max(1) } else { 1 };
    let mut timed = Timed { ms: Vec::new(), frames: 0, note: None };
    let start = Instant::now();
    loop {
        let count = match frames {
            Some(all) => batch.min(all - timed.frames),
            None if timed.frames >= most => 0,
            None if timed.ms.len() < BUDGET.1 || start.elapsed().as_secs_f64() < BUDGET.0 => batch,
            None => 0,
        };
        if count == 0 {
            return Ok(timed);
        }
        timed.ms.push(advance(count)?);
        timed.frames += count;
    }
}
