//! A team of threads that runs a whole frame, and synchronises at a spinning barrier between stages.
//!
//! A sub-step of a small cloth lasts tens of microseconds. Starting tasks for it would take longer.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;

/// Worker threads, which wait between frames.
pub struct Team {
    pool: Option<rayon::ThreadPool>,
    threads: usize,
    barrier: Barrier,
}

impl Team {
    /// A team of `threads` (at least one). One thread is the caller itself; if the system gives no threads, too.
    pub fn new(threads: usize) -> Self {
        let pool = (threads > 1)
            .then(|| {
                rayon::ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .thread_name(|i| format!("taffeta-{i}"))
                    .build()
            })
            .and_then(Result::ok);
        let threads = if pool.is_some() { threads } else { 1 };
        Self { threads, pool, barrier: Barrier::new(threads) }
    }

    /// Number of workers.
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// Runs `work(worker, barrier)` on every worker at once and waits for all.
    pub fn run<'t>(&'t self, work: impl Fn(usize, &'t Barrier) + Sync) {
        let barrier = &self.barrier;
        barrier.mend();
        match &self.pool {
            Some(pool) => {
                pool.broadcast(|context| {
                    let guard = BreakOnPanic(barrier);
                    work(context.index(), barrier);
                    drop(guard);
                });
            }
            None => work(0, barrier),
        }
    }
}

/// Times that a waiting worker looks before it yields to other programs, where each worker may have a core of its own.
const SPINS: u32 = 4096;

/// The barrier of a team. It spins briefly, then yields to other programs. It has cache lines of its own: what workers read
/// all the time must not share one with what each arrival writes.
#[repr(align(128))]
pub struct Barrier {
    workers: usize,
    spins: u32,
    arrived: AtomicUsize,
    generation: AtomicUsize,
    broken: AtomicBool,
}

impl Barrier {
    fn new(workers: usize) -> Self {
        // On fewer cores than workers, one that spins keeps off those that it waits for.
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        Self {
            workers,
            spins: if workers > cores { 0 } else { SPINS },
            arrived: AtomicUsize::new(0),
            generation: AtomicUsize::new(0),
            broken: AtomicBool::new(false),
        }
    }

    /// Resets it after a panic, when no worker waits.
    fn mend(&self) {
        self.arrived.store(0, Ordering::Relaxed);
        self.broken.store(false, Ordering::Relaxed);
    }

    /// As [`Self::wait`]; returns how long that took [s].
    pub fn wait_timed(&self) -> f64 {
        let start = Instant::now();
        self.wait();
        start.elapsed().as_secs_f64()
    }

    /// Waits for all workers. What a worker wrote before it is visible to all of them after it.
    pub fn wait(&self) {
        if self.workers == 1 {
            return;
        }
        let generation = self.generation.load(Ordering::Acquire);
        if self.arrived.fetch_add(1, Ordering::AcqRel) + 1 == self.workers {
            self.arrived.store(0, Ordering::Relaxed);
            self.generation.store(generation.wrapping_add(1), Ordering::Release);
            return;
        }
        let mut spins = 0_u32;
        while self.generation.load(Ordering::Acquire) == generation {
            assert!(!self.broken.load(Ordering::Relaxed), "another worker of the team panicked");
            spins += 1;
            if spins < self.spins {
                std::hint::spin_loop();
            } else {
                std::thread::yield_now();
            }
        }
    }
}

/// Releases the others if a worker panics, so that the panic is reported and nobody waits forever.
struct BreakOnPanic<'a>(&'a Barrier);

impl Drop for BreakOnPanic<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.broken.store(true, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn after_the_barrier_every_worker_sees_all_arrivals() {
        for threads in [1, 2, 3, 8] {
            let team = Team::new(threads);
            let count = AtomicUsize::new(0);
            team.run(|_, barrier| {
                for round in 1..=100 {
                    count.fetch_add(1, Ordering::Relaxed);
                    barrier.wait();
                    assert_eq!(count.load(Ordering::Relaxed), round * threads);
                    barrier.wait();
                }
            });
        }
    }

    #[test]
    #[should_panic(expected = "panicked")]
    fn a_panic_in_one_worker_ends_the_frame_for_all() {
        Team::new(2).run(|worker, barrier| {
            assert!(worker == 0, "worker 1 panicked on purpose");
            barrier.wait();
        });
    }
}
