//! The bench beside other programs: several threads and one, while other threads that only count take the cores.

use super::measure::Bench;
use super::{Args, say};
use super::{contact, ice, scenes};
use crate::run::{Backend, at_once};
use serde::Serialize;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Instant;
use taffeta::scene::Scene;
use taffeta::{Options, Simulation};
use taffeta_io::program::Failure;

/// How many others there are, by turns.
const OTHERS: [usize; 3] = [0, 1, 2];
/// How long one thread takes for the frames of a case [s], about.
const LONG: f64 = 1.5;

/// The line that is printed for each scene and number of others.
#[derive(Serialize)]
struct Line {
    bench: &'static str,
    case: &'static str,
    others: usize,
    frames: u32,
    threads: usize,
    /// All frames [s]: two runs with one thread, and two with all.
    seconds_alone: [f64; 2],
    seconds_together: [f64; 2],
    /// Both runs with all threads by both with one.
    together_by_alone: f64,
}

/// Runs each scene with one thread and with all of them, in both orders, beside others.
pub fn run(args: &Args) -> Result<(), Failure> {
    if args.backend == Backend::Gpu {
        return Err(Failure::Input("`bench busy` is for the CPU".into()));
    }
    let threads =
        at_once(args.threads).unwrap_or_else(|| thread::available_parallelism().map_or(1, Into::into));
    for (case, bench) in cases() {
        let frames = frames(&bench, args)?;
        for others in OTHERS {
            let mut seconds = [[0.0; 2]; 2];
            for (turn, order) in [[0, 1], [1, 0]].into_iter().enumerate() {
                for which in order {
                    let threads = if which == 0 { 1 } else { threads };
                    seconds[which][turn] = beside(others, || timed(&bench.scene, args, threads, frames))?;
                }
            }
            let [seconds_alone, seconds_together] = seconds;
            let together_by_alone = seconds_together.iter().sum::<f64>() / seconds_alone.iter().sum::<f64>();
            let line = Line {
                bench: "busy",
                case,
                others,
                frames,
                threads,
                seconds_alone,
                seconds_together,
                together_by_alone,
            };
            say(&line, || line.table(), args)?;
        }
    }
    Ok(())
}

/// Explicit and implicit ones, large and small.
fn cases() -> [(&'static str, Bench); 4] {
    [
        ("springs, 160×160", scenes::grid(160, 160)),
        ("implicit, 34×34", ice::flag([34, 34])),
        ("implicit, 100×100", ice::flag([100, 100])),
        ("self-contact, 60×60", contact::bench(60, 60)),
    ]
}

/// How many frames one thread does in [`LONG`].
fn frames(bench: &Bench, args: &Args) -> Result<u32, Failure> {
    if let Some(frames) = args.frames {
        return Ok(frames);
    }
    let mut simulation = built(&bench.scene, args, 1)?;
    let (start, mut frames) = (Instant::now(), 0);
    while start.elapsed().as_secs_f64() < LONG && frames < bench.most {
        simulation.step().map_err(|error| Failure::Work(error.to_string()))?;
        frames += 1;
    }
    Ok(frames)
}

/// Does something while so many threads count.
fn beside<R>(others: usize, job: impl FnOnce() -> R) -> R {
    let ends = AtomicBool::new(false);
    thread::scope(|scope| {
        for _ in 0..others {
            scope.spawn(|| {
                let mut count = 0_u64;
                while !ends.load(Ordering::Relaxed) {
                    count = std::hint::black_box(count + 1);
                }
            });
        }
        let done = job();
        ends.store(true, Ordering::Relaxed);
        done
    })
}

fn built(scene: &Scene, args: &Args, threads: usize) -> Result<Simulation, Failure> {
    let options =
        Options { threads: Some(threads), precision: args.precision.precision(), ..Options::default() };
    Simulation::new(scene, &options).map_err(|error| Failure::Work(error.to_string()))
}

/// All frames of a scene, one by one [s].
fn timed(scene: &Scene, args: &Args, threads: usize, frames: u32) -> Result<f64, Failure> {
    let mut simulation = built(scene, args, threads)?;
    let start = Instant::now();
    for _ in 0..frames {
        simulation.step().map_err(|error| Failure::Work(error.to_string()))?;
    }
    Ok(start.elapsed().as_secs_f64())
}

impl Line {
    /// For people.
    fn table(&self) -> String {
        let Self { case, others, frames, threads, together_by_alone, .. } = self;
        let [[a, b], [c, d]] = [self.seconds_alone, self.seconds_together];
        format!(
            "{case}, {frames} frames, beside {others} others\n  one thread {a:.2} and {b:.2} s, {threads} threads {c:.2} \
             and {d:.2} s: {together_by_alone:.2} times as long"
        )
    }
}
