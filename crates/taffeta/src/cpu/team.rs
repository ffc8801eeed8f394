//! A team of threads that runs a whole frame, and synchronises at a spinning barrier between stages.
//!
//! A sub-step of a small cloth lasts tens of microseconds. Starting tasks for it would take longer.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;
use web_time::Instant;

/// Threads of a program that simulations work on, each for a frame at a time. A simulation with a pool starts no threads of its own.
///
/// ```
/// # use taffeta::{Options, Pool, Simulation, scene::{Body, Mass, Mesh, Scene}};
/// # let cloth = Body::cloth("cloth", Mesh::grid(4, 4, [1.0, 1.0])).with_mass(Mass::Node(0.1)).structural(9.0, 0.1);
/// # let scene = Scene::new("").body(cloth);
/// use taffeta::rayon::ThreadPoolBuilder;
///
/// let pool = Pool::from(ThreadPoolBuilder::new().num_threads(2).build()?);
/// let options = Options { threads: Some(2), pool: Some(pool.clone()), ..Options::default() };
/// let mut rooms = [Simulation::new(&scene, &options)?, Simulation::new(&scene, &options)?];
/// for room in &mut rooms {
///     room.step()?;
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Clones share the threads: where two simulations ask for them at once, one waits for the frame of the other. Of one `ThreadPool` there
/// should be no second `Pool`, whose simulations would not wait. A simulation that is stepped on a thread of any pool of rayon works on
/// that thread alone from then on, as the others may be waiting for it; `Simulation::limit_threads` gives it more again. No result
/// depends on it.
#[derive(Clone, Debug)]
pub struct Pool(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    threads: Arc<rayon::ThreadPool>,
    /// Held by whoever works.
    turn: Mutex<()>,
}

impl Pool {
    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.0.threads.current_num_threads()
    }
}

impl From<Arc<rayon::ThreadPool>> for Pool {
    fn from(threads: Arc<rayon::ThreadPool>) -> Self {
        Self(Arc::new(Shared { threads, turn: Mutex::new(()) }))
    }
}

impl From<rayon::ThreadPool> for Pool {
    fn from(threads: rayon::ThreadPool) -> Self {
        Arc::new(threads).into()
    }
}

/// Worker threads, which wait between frames.
pub struct Team {
    pool: Option<Pool>,
    is_lent: bool,
    threads: usize,
    barrier: Barrier,
}

impl Team {
    /// A team of `threads` (at least one). One thread is the caller itself; if the system gives no threads, too.
    pub fn new(threads: usize) -> Self {
        let build = || {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.thread_name(|i| format!("taffeta-{i}")).build().ok().map(Pool::from)
        };
        let pool = if threads > 1 { build() } else { None };
        let threads = if pool.is_some() { threads } else { 1 };
        Self { threads, pool, is_lent: false, barrier: Barrier::new(threads) }
    }

    /// A team of up to `threads` of a pool.
    pub fn of(pool: Pool, threads: usize) -> Self {
        let threads = threads.clamp(1, pool.threads());
        let pool = (threads > 1).then_some(pool);
        Self { threads, pool, is_lent: true, barrier: Barrier::new(threads) }
    }

    /// Whether the caller must not wait for lent threads: it is one of them, or one of another pool, which goes on with other work of
    /// that while it waits, and so may come to wait for itself.
    pub fn must_be_alone(&self) -> bool {
        self.is_lent && rayon::current_thread_index().is_some()
    }

    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// Number of workers, at most one on each thread.
    pub fn workers(&self) -> usize {
        self.barrier.workers
    }

    /// Has so many workers from now on, at least one and at most as many as there are threads.
    pub fn set_workers(&mut self, workers: usize) {
        let stop = self.barrier.stop.take();
        self.barrier = Barrier { stop, ..Barrier::new(workers.clamp(1, self.threads)) };
    }

    /// Has work that is run from now on end early once `stop` is true.
    pub fn stop_on(&mut self, stop: Option<Arc<AtomicBool>>) {
        self.barrier.stop = stop;
    }

    /// Whether the last work was to end early.
    pub fn was_stopped(&self) -> bool {
        self.barrier.is_stopped()
    }

    /// Runs `work(worker, barrier)` on every worker at once and waits for all.
    pub fn run<'t>(&'t self, work: impl Fn(usize, &'t Barrier) + Sync) {
        let barrier = &self.barrier;
        barrier.mend();
        let work = |worker: usize| {
            let guard = BreakOnPanic(barrier);
            work(worker, barrier);
            drop(guard);
        };
        let Some(Pool(pool)) = self.pool.as_ref().filter(|_| self.workers() > 1) else { return work(0) };
        // Workers of two teams would wait for each other's threads.
        let _turn = pool.turn.lock().unwrap_or_else(PoisonError::into_inner);
        if self.workers() == pool.threads.current_num_threads() {
            // Each on the thread that it was on before: that has its data at hand.
            pool.threads.broadcast(|context| work(context.index()));
        } else {
            // Threads that have no worker are not woken.
            pool.threads.in_place_scope(|scope| {
                (1..self.workers()).for_each(|worker| scope.spawn(move |_| work(worker)));
                work(0);
            });
        }
    }

    /// How long workers have waited past what they spin since they were asked last, all together [s].
    pub fn waited(&self) -> f64 {
        Duration::from_nanos(self.barrier.waited.swap(0, Ordering::Relaxed)).as_secs_f64()
    }
}

/// Times that a waiting worker looks before it lets other programs pass, where each worker may have a core of its own: some 50 µs.
const SPINS: u32 = 4096;

/// How long it then lets other programs pass before it sleeps: waking it takes longer than most waits.
const NAP: Duration = Duration::from_millis(1);

/// The barrier of a team. It spins briefly, lets other programs pass, and then sleeps. It has cache lines of its own: what
/// workers read all the time must not share one with what each arrival writes.
#[repr(align(128))]
pub struct Barrier {
    workers: usize,
    spins: u32,
    arrived: AtomicUsize,
    generation: AtomicUsize,
    broken: AtomicBool,
    /// Whether the user wants the work to end early.
    stop: Option<Arc<AtomicBool>>,
    /// Whether a worker has left something out for that.
    gave_up: AtomicBool,
    /// Whether that was so at the last barrier: all workers see the same between two of them.
    stopped: AtomicBool,
    /// How many sleep, or are about to.
    sleepers: AtomicUsize,
    bed: Mutex<()>,
    bell: Condvar,
    /// How long all have waited past what they spin [ns].
    waited: AtomicU64,
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
            stop: None,
            gave_up: AtomicBool::new(false),
            stopped: AtomicBool::new(false),
            sleepers: AtomicUsize::new(0),
            bed: Mutex::new(()),
            bell: Condvar::new(),
            waited: AtomicU64::new(0),
        }
    }

    /// Resets it after a panic or an early end, when no worker waits.
    fn mend(&self) {
        self.arrived.store(0, Ordering::Relaxed);
        self.broken.store(false, Ordering::Relaxed);
        self.gave_up.store(false, Ordering::Relaxed);
        self.stopped.store(false, Ordering::Relaxed);
        self.sleepers.store(0, Ordering::Relaxed);
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
            self.look();
            return;
        }
        let generation = self.generation.load(Ordering::Acquire);
        if self.arrived.fetch_add(1, Ordering::AcqRel) + 1 == self.workers {
            self.look();
            self.arrived.store(0, Ordering::Relaxed);
            self.generation.store(generation.wrapping_add(1), Ordering::SeqCst);
            self.wake();
            return;
        }
        for _ in 0..self.spins {
            if self.is_over(generation) {
                return;
            }
            std::hint::spin_loop();
        }
        let start = Instant::now();
        while start.elapsed() < NAP {
            if self.is_over(generation) {
                self.note_wait(start);
                return;
            }
            std::thread::yield_now();
        }
        self.sleep(generation);
        self.note_wait(start);
    }

    /// Whether the work is to end: the same for all workers from one barrier to the next.
    pub fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }

    /// Whether this worker may leave out what is left until the next barrier, because the work is to end there.
    pub fn gives_up(&self) -> bool {
        let gives_up = self.stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed));
        if gives_up {
            // Even if the user thinks better of it.
            self.gave_up.store(true, Ordering::Relaxed);
        }
        gives_up
    }

    /// Looks whether the work is to end, before others go on.
    fn look(&self) {
        if self.gives_up() || self.gave_up.load(Ordering::Relaxed) {
            self.stopped.store(true, Ordering::Relaxed);
        }
    }

    #[cold]
    fn note_wait(&self, since: Instant) {
        let waited = u64::try_from(since.elapsed().as_nanos()).unwrap_or(u64::MAX);
        self.waited.fetch_add(waited, Ordering::Relaxed);
    }

    /// Whether all have arrived.
    fn is_over(&self, generation: usize) -> bool {
        assert!(!self.broken.load(Ordering::SeqCst), "another worker of the team panicked");
        self.generation.load(Ordering::SeqCst) != generation
    }

    /// Sleeps until all have arrived.
    #[cold]
    fn sleep(&self, generation: usize) {
        // Whoever ends the wait looks for sleepers after it has written that, and this looks for that after it is one of them: one
        // of both sees the other.
        self.sleepers.fetch_add(1, Ordering::SeqCst);
        let mut bed = self.bed.lock().unwrap_or_else(PoisonError::into_inner);
        while !self.is_over(generation) {
            bed = self.bell.wait(bed).unwrap_or_else(PoisonError::into_inner);
        }
        drop(bed);
        self.sleepers.fetch_sub(1, Ordering::SeqCst);
    }

    /// Wakes those that sleep.
    fn wake(&self) {
        if self.sleepers.load(Ordering::SeqCst) > 0 {
            // Whoever has the lock and has not seen it sleeps before this has it.
            drop(self.bed.lock().unwrap_or_else(PoisonError::into_inner));
            self.bell.notify_all();
        }
    }
}

/// Releases the others if a worker panics, so that the panic is reported and nobody waits forever.
struct BreakOnPanic<'a>(&'a Barrier);

impl Drop for BreakOnPanic<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.broken.store(true, Ordering::SeqCst);
            self.0.wake();
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
    fn all_workers_stop_at_the_same_barrier_even_if_the_wish_is_taken_back() {
        for threads in [1, 2, 3] {
            for gives_up in [false, true] {
                let mut team = Team::new(threads);
                let stop = Arc::new(AtomicBool::new(false));
                team.stop_on(Some(Arc::clone(&stop)));
                team.run(|worker, barrier| {
                    let mut rounds = 0;
                    while !barrier.is_stopped() && rounds < 100 {
                        rounds += 1;
                        if worker == 0 && rounds == 7 {
                            stop.store(true, Ordering::Relaxed);
                            if gives_up {
                                assert!(barrier.gives_up());
                                stop.store(false, Ordering::Relaxed);
                            }
                        }
                        barrier.wait();
                    }
                    assert_eq!(rounds, 7, "{threads} threads");
                });
                assert!(team.was_stopped());
                team.stop_on(None);
                team.run(|_, barrier| barrier.wait());
                assert!(!team.was_stopped());
            }
        }
    }

    /// Keeps a core for longer than others wait awake.
    fn be_late() {
        let start = Instant::now();
        while start.elapsed() < 3 * NAP {
            std::hint::spin_loop();
        }
    }

    #[test]
    fn those_that_sleep_are_woken_by_the_last_that_arrives() {
        let team = Team::new(3);
        let count = AtomicUsize::new(0);
        let mut runs = 0;
        for late in 0..3 {
            // On a busy machine the others may come late themselves; then once more.
            let mut waited = 0.0;
            while waited <= NAP.as_secs_f64() {
                runs += 1;
                assert!(runs < 1000, "nobody waits for worker {late}");
                team.run(|worker, barrier| {
                    if worker == late {
                        be_late();
                    }
                    count.fetch_add(1, Ordering::Relaxed);
                    barrier.wait();
                    assert_eq!(count.load(Ordering::Relaxed), 3 * runs);
                });
                waited = team.waited();
            }
            assert_eq!(team.waited(), 0.0);
        }
    }

    #[test]
    #[should_panic(expected = "panicked")]
    fn those_that_sleep_are_woken_by_a_panic() {
        Team::new(2).run(|worker, barrier| {
            if worker == 1 {
                be_late();
                panic!("worker 1 panicked on purpose");
            }
            barrier.wait();
        });
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
