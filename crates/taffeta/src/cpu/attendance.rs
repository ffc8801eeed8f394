//! How many workers take part: fewer while other programs need the cores.
//!
//! Workers meet after every pass, so all of them wait for one whose core another program has just then. If they wait much of
//! their time, some frames are tried with fewer of them, and whatever is faster goes on. From time to time more are tried again. No
//! result depends on it.

/// Frames are judged together until they have taken so long [s]: programs get cores for some milliseconds at a time.
const WINDOW: f64 = 0.02;
/// Share of their time that workers wait, past what they spin, from which fewer of them are tried.
const WAITING: f64 = 0.2;
/// Time of a sub-step, relative to that before a trial, up to which another number of workers is kept: frames are not all alike.
const GAIN: f64 = 0.9;
/// Windows between two trials after one that was kept, and at most: each that fails doubles them.
const PATIENCE: [u32; 2] = [8, 256];

/// What is known of the frames since the last judgement.
#[derive(Clone, Copy, Debug, Default)]
struct Window {
    seconds: f64,
    substeps: usize,
    /// How long workers have waited past what they spin, all together [s].
    waited: f64,
}

/// A trial: how many workers there were before, and the time of a sub-step with them [s].
#[derive(Clone, Copy, Debug)]
struct Trial {
    before: usize,
    cost: f64,
}

/// Trials of fewer or of more workers.
#[derive(Clone, Copy, Debug)]
struct Direction {
    /// Windows until the next one, and after that if it fails.
    rest: u32,
    patience: u32,
    /// How many have failed in a row.
    failed: u32,
}

/// How many workers there are, and how many there may be.
#[derive(Debug)]
pub struct Attendance {
    most: usize,
    workers: usize,
    window: Window,
    trial: Option<Trial>,
    /// Whether the last frame has begun a trial: in the first one with other workers their data is still on its way.
    is_new: bool,
    fewer: Direction,
    more: Direction,
}

impl Direction {
    /// The first frames have more to do than others.
    const START: Self = Self { rest: 2, patience: 1, failed: 0 };

    fn kept(&mut self) {
        *self = Self { rest: 0, ..Self::START };
    }

    fn failed(&mut self, least: u32) {
        self.patience = (2 * self.patience).clamp(least, PATIENCE[1]);
        (self.rest, self.failed) = (self.patience, self.failed + 1);
    }
}

impl Attendance {
    /// All of so many workers.
    pub fn new(most: usize) -> Self {
        Self {
            most,
            workers: most,
            window: Window::default(),
            trial: None,
            is_new: false,
            fewer: Direction::START,
            more: Direction::START,
        }
    }

    /// Has at most so many workers from now on. Returns how many there are to be, where that is another limit than before.
    pub fn limit(&mut self, most: usize) -> Option<usize> {
        (most != self.most).then(|| {
            *self = Self::new(most);
            most
        })
    }

    /// Notes a frame of `seconds` with so many sub-steps, in which workers have `waited` past what they spin [s]. Returns how many
    /// there are to be, where that changes.
    pub fn after(&mut self, seconds: f64, substeps: usize, waited: f64) -> Option<usize> {
        if self.most == 1 || substeps == 0 || std::mem::take(&mut self.is_new) {
            return None;
        }
        self.window.seconds += seconds;
        self.window.substeps += substeps;
        self.window.waited += waited;
        if self.window.seconds < WINDOW {
            return None;
        }
        let window = std::mem::take(&mut self.window);
        let workers = self.judge(&window);
        self.is_new = workers != self.workers;
        self.workers = workers;
        self.is_new.then_some(workers)
    }

    fn judge(&mut self, window: &Window) -> usize {
        let cost = window.seconds / window.substeps as f64;
        if let Some(trial) = self.trial.take() {
            return self.end(trial, cost);
        }
        for direction in [&mut self.fewer, &mut self.more] {
            direction.rest = direction.rest.saturating_sub(1);
        }
        let waits = window.waited > WAITING * window.seconds * self.workers as f64;
        let next = if waits && self.workers > 1 && self.fewer.rest == 0 {
            // One core of many may be taken, or all of them.
            if self.fewer.failed.is_multiple_of(2) {
                self.workers - 1
            } else {
                self.workers.div_ceil(2).min(self.workers - 1)
            }
        } else if self.workers < self.most && self.more.rest == 0 {
            if self.more.failed.is_multiple_of(2) { self.most } else { self.workers + 1 }
        } else {
            return self.workers;
        };
        self.trial = Some(Trial { before: self.workers, cost });
        next
    }

    /// Ends a trial in which a sub-step took `cost` [s].
    fn end(&mut self, trial: Trial, cost: f64) -> usize {
        let is_fewer = self.workers < trial.before;
        if cost < GAIN * trial.cost {
            if is_fewer {
                // What has just been too many is not tried again at once.
                self.fewer.kept();
                self.more = Direction { rest: PATIENCE[0], patience: PATIENCE[0], failed: 0 };
            } else {
                self.more.kept();
            }
            return self.workers;
        }
        if is_fewer {
            self.fewer.failed(4)
        } else {
            self.more.failed(PATIENCE[0])
        }
        trial.before
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean time of a sub-step [s] in so many frames, and the workers at the end, where a frame of one sub-step takes `cost` of the
    /// workers that there are, who wait that share of it.
    fn run(attendance: &mut Attendance, frames: u32, cost: impl Fn(usize) -> (f64, f64)) -> (f64, usize) {
        let mut sum = 0.0;
        for _ in 0..frames {
            let workers = attendance.workers;
            let (seconds, waiting) = cost(workers);
            sum += seconds;
            attendance.after(seconds, 1, waiting * seconds * workers as f64);
        }
        (sum / f64::from(frames), attendance.workers)
    }

    #[test]
    fn workers_that_get_on_stay_all_of_them() {
        let mut attendance = Attendance::new(8);
        let even = |workers: usize| (0.01 / workers as f64, 0.02);
        let (cost, workers) = run(&mut attendance, 1000, even);
        assert!(workers == 8 && cost < 0.00126, "{cost} {workers}");
    }

    #[test]
    fn while_a_core_is_taken_it_takes_hardly_longer_than_with_one_worker() {
        for frame in [1e-4, 0.01, 0.5] {
            let mut attendance = Attendance::new(2);
            let busy = |workers: usize| if workers == 1 { (frame, 0.0) } else { (3.0 * frame, 0.4) };
            let frames = (20.0 / frame) as u32;
            let (cost, workers) = run(&mut attendance, frames.max(400), busy);
            assert!(
                (workers == 1 || attendance.trial.is_some()) && cost < 1.15 * frame,
                "{frame}: {cost} {workers}"
            );
            // The other program ends.
            let free = |workers: usize| (frame / workers as f64, 0.01);
            let (_, workers) = run(&mut attendance, frames.max(2000), free);
            assert!(workers == 2 || attendance.trial.is_some(), "{frame}");
        }
    }

    #[test]
    fn of_sixteen_cores_those_are_left_that_are_taken() {
        let taken = |free: usize| {
            move |workers: usize| {
                let late = if workers > free { (4.0, 0.3) } else { (1.0, 0.01) };
                (0.02 * late.0 / workers as f64, late.1)
            }
        };
        let mut attendance = Attendance::new(16);
        let (_, workers) = run(&mut attendance, 4000, taken(15));
        assert!(workers == 15 || attendance.trial.is_some(), "{workers}");
        let (_, workers) = run(&mut attendance, 4000, taken(8));
        assert!((7..=9).contains(&workers) || attendance.trial.is_some(), "{workers}");
        let (_, workers) = run(&mut attendance, 8000, taken(16));
        assert!(workers == 16, "{workers}");
    }

    #[test]
    fn uneven_work_is_no_reason_to_have_fewer_for_long() {
        let mut attendance = Attendance::new(4);
        let uneven = |workers: usize| (0.02 / workers.min(3) as f64, 0.2);
        let (cost, _) =
            run(&mut attendance, 4000, |workers| if workers == 4 { (0.005, 0.2) } else { uneven(workers) });
        assert!(cost < 0.0052, "{cost}");
    }
}
