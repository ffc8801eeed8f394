//! Memory of the CPU backend, and one frame of it.

use crate::assembly::Assembly;
use crate::backend::{Backend, Device, FrameInput, Lost, SolverState};
use crate::cpu::attendance::Attendance;
use crate::cpu::balance::Balance;
use crate::cpu::cells::PerWorker;
use crate::cpu::clock::Clock;
use crate::cpu::column::Column;
use crate::cpu::feature::{Feature, Features};
use crate::cpu::numbers::TileMarks;
use crate::cpu::resting::Resting;
use crate::cpu::simd::SimdLevel;
use crate::cpu::states::{States, Turn};
use crate::cpu::team::Team;
use crate::cpu::tile::{Fields, Nodes, Scratch};
use crate::cpu::tiles::{self, TilePlan};
use crate::cpu::worker::{Program, Worker};
use crate::plan::refinement::{InVain, Refinement};
use crate::plan::{self, Parameters, Substep};
use crate::real::Real;
use crate::report::FrameSums;
use crate::step::{self, Marks, Parts};
use crate::topology::LANES;
use std::collections::HashMap;
use std::ops::Range;
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use web_time::Instant;

/// Cache lines between the starts of the arrays that a kernel walks through together: twelve of them share the 64
/// sets of a first-level cache evenly.
const STAGGER: usize = 5;

/// Cache lines before the first column of each state: two of them are in use at once, beside [`masses`].
const LEADS: [usize; 3] = [0, 6 * STAGGER, 12 * STAGGER + 2];

/// What features are constructed from.
pub struct Context<'a, T> {
    /// The scene. A feature may take parts that nothing else needs.
    pub assembly: &'a mut Assembly,
    /// Its nodes, and their tiles.
    pub nodes: &'a Nodes<T>,
    /// The chunk of tiles of each worker.
    pub chunks: &'a [Range<usize>],
}

impl<T> Context<'_, T> {
    /// Number of workers.
    pub fn workers(&self) -> usize {
        self.chunks.len()
    }

    /// Nodes of the largest tile.
    pub fn largest_tile(&self) -> usize {
        self.nodes.tiles.iter().map(TilePlan::len).max().unwrap_or(0)
    }
}

/// What a frame starts from.
struct Kept<T> {
    /// The state, where it is not the last good one.
    columns: Option<[Vec<T>; 6]>,
    solvers: SolverState,
    is_timed: bool,
}

/// The CPU backend in numbers of type `T`.
pub struct CpuBackend<T> {
    /// Adds what features tell a sub-step.
    pub(crate) parameters: Parameters<T>,
    pub(crate) assembly: Assembly,
    pub(crate) nodes: Nodes<T>,
    pub(crate) features: Features<T>,
    /// The parts of the scene.
    #[cfg(feature = "gpu")]
    pub(crate) parts: Parts,
    /// Inverse masses [1/kg] of nodes that were free before they were pinned.
    when_free: HashMap<usize, T>,
    program: Program,
    team: Team,
    pub(crate) chunks: Vec<Range<usize>>,
    pub(crate) states: States<T>,
    pub(crate) turn: Turn,
    marks: Vec<TileMarks>,
    scratch: PerWorker<Scratch<T>>,
    pub(crate) input: FrameInput,
    resting: Resting,
    balance: Balance,
    attendance: Attendance,
    sums: FrameSums,
    refinement: Refinement,
    /// How much of a node's way was taken at most in a sub-step of the last frame, relative to an edge.
    taken: f64,
    /// The same since the last good frame, where only a scene that blows up comes to it; 0 else.
    blown_up: f64,
    /// Whether the next frame is timed by stages, and the times [s] of the last timed frame.
    is_timed: bool,
    times: Vec<(&'static str, f64)>,
}

impl<T: Real> CpuBackend<T> {
    /// Allocates the memory of a scene, whose features `make` constructs.
    pub fn new(
        mut assembly: Assembly,
        parts: &Parts,
        parameters: Parameters<T>,
        team: Team,
        make: impl FnOnce(&mut Context<'_, T>) -> Result<Vec<Box<dyn Feature<T>>>, String>,
    ) -> Result<Self, String> {
        let [inverse_mass, mass] = masses(&assembly);
        let nodes = Nodes { tiles: tiles::tiles(&assembly), inverse_mass, mass, level: SimdLevel::detect() };
        let chunks = tiles::chunks_by_nodes(&nodes.tiles, team.threads());
        let states = LEADS.map(|lead| start(&assembly, lead));
        let clock = Instant::now();
        let mut context = Context { assembly: &mut assembly, nodes: &nodes, chunks: &chunks };
        let (workers, largest) = (context.workers(), context.largest_tile());
        let lists = [step::substep(parts), step::frame_end()];
        let features = Features::new(make(&mut context)?, lists.iter().flatten())?;
        let marks = |plan: &TilePlan| features.iter().fold(Marks::NONE, |all, one| all.and(one.marks(plan)));
        assembly.release();
        Ok(Self {
            marks: nodes.tiles.iter().map(|plan| marks(plan).into()).collect(),
            scratch: PerWorker::new(workers, |_| Scratch::new(largest)),
            balance: Balance::new(workers, clock.elapsed().as_secs_f64()),
            attendance: Attendance::new(workers),
            resting: Resting::new(assembly.bodies.len()),
            program: Program::new(&lists[0], &lists[1]),
            #[cfg(feature = "gpu")]
            parts: *parts,
            parameters,
            assembly,
            nodes,
            features,
            team,
            chunks,
            states,
            turn: Turn::default(),
            when_free: HashMap::new(),
            input: FrameInput::default(),
            sums: FrameSums::default(),
            refinement: Refinement::default(),
            taken: 0.0,
            blown_up: 0.0,
            is_timed: false,
            times: Vec::new(),
        })
    }

    /// Leaves out bodies that rest, of which each buffer of the state has the same.
    fn begin_resting(&mut self) {
        self.resting.leave_out(self.features.iter().all(|feature| feature.lets_rest()));
        for buffer in self.resting.unwritten(self.turn) {
            let Ok([from, to]) = self.states.get_disjoint_mut([self.turn.now, buffer]) else { continue };
            for (number, body) in self.assembly.bodies.iter().enumerate() {
                let places = body.first..body.first + body.places();
                if self.resting.has(number) {
                    for (from, to) in from.iter_mut().zip(to.iter_mut()) {
                        to.get_mut()[places.clone()].copy_from_slice(&from.get_mut()[places.clone()]);
                    }
                }
            }
        }
    }

    /// Something of a node was changed from outside.
    fn forget(&mut self, node: usize) {
        self.features.iter_mut().for_each(|feature| feature.forget(node));
        self.resting.forget(self.assembly.number_of_body(node as u32));
    }

    /// Runs the frame that starts at time `start` [s], as finely as it was before.
    fn run_frame(&mut self, start: f64) {
        self.begin_resting();
        let state = self.states[self.turn.now].each_mut().map(|column| &*column.get_mut());
        for feature in self.features.iter_mut() {
            feature.prepare(&self.assembly, start, state);
        }
        let parts = self.refinement.parts;
        let in_vain = InVain::of(&self.assembly, parts, !self.input.moves.is_empty());
        let substeps = plan::frame(&self.assembly, start, (parts, in_vain), self.parameters);
        self.run(&substeps);
        let is_last = parts == self.assembly.time.most_parts();
        let was_in_vain = self.taken > in_vain.taken() || self.features.iter().any(|one| one.is_in_vain());
        if is_last && was_in_vain {
            self.blown_up = self.blown_up.max(self.taken);
        }
        self.resting.end();
        (self.sums.parts, self.sums.blown_up) = (parts, self.blown_up);
    }

    /// The state of now, where a frame may be repeated.
    fn keep(&mut self) -> Option<Kept<T>> {
        let may_repeat = self.features.iter_mut().any(|feature| feature.taken().is_some());
        may_repeat.then(|| Kept {
            columns: (!self.turn.is_good()).then(|| std::array::from_fn(|axis| self.column(axis).to_vec())),
            solvers: self.solver_state(),
            is_timed: self.is_timed,
        })
    }

    /// Puts a state back.
    fn put_back(&mut self, kept: &Kept<T>) {
        match &kept.columns {
            None => self.turn.return_to_good(),
            Some(columns) => {
                for (column, numbers) in self.states[self.turn.now].iter_mut().zip(columns) {
                    column.get_mut().copy_from_slice(numbers);
                }
            }
        }
        for feature in self.features.iter_mut() {
            (0..self.assembly.places).for_each(|node| feature.forget(node));
            feature.load(&kept.solvers);
        }
        self.resting.forget_all();
        self.is_timed = kept.is_timed;
    }

    /// Runs sub-steps, and measures the state after them.
    fn run(&mut self, substeps: &[Substep<T>]) {
        let start = Instant::now();
        let done = self.work_on_frame(substeps);
        if self.team.was_stopped() {
            // Nobody is to learn from it.
            self.team.waited();
            return;
        }
        let seconds = start.elapsed().as_secs_f64();
        (0..done).for_each(|_| self.turn.pass());
        self.sums = FrameSums { volumes: self.assembly.no_volumes(), ..FrameSums::default() };
        let state = self.states[self.turn.now].each_mut().map(|column| &*column.get_mut());
        for feature in self.features.iter_mut() {
            feature.measure(state, done, &mut self.sums);
        }
        // Before there are other workers.
        self.taken = self.features.iter_mut().filter_map(|feature| feature.taken()).fold(0.0, f64::max);
        let workers = self.attendance.after(seconds, done, self.team.waited());
        if let Some(workers) = workers {
            self.set_workers(workers);
        } else if !substeps.is_empty() {
            self.balance(seconds);
        }
    }

    /// Has one worker from now on where the caller is a thread that others would wait for.
    fn enter(&mut self) {
        if self.team.workers() > 1 && self.team.must_be_alone() {
            self.limit_threads(1);
        }
    }

    /// Has so many workers from now on, at most one on each thread.
    pub(crate) fn set_workers(&mut self, workers: usize) {
        let start = Instant::now();
        self.team.set_workers(workers);
        let workers = self.team.workers();
        self.redistribute(tiles::chunks_by_nodes(&self.nodes.tiles, workers));
        self.balance = Balance::new(workers, start.elapsed().as_secs_f64());
    }

    fn redistribute(&mut self, chunks: Vec<Range<usize>>) {
        for feature in self.features.iter_mut() {
            feature.redistribute(&self.assembly, &self.nodes.tiles, &chunks);
        }
        self.chunks = chunks;
    }

    /// Redistributes tiles if workers were busy unevenly in a frame of `seconds`. No result depends on who computes
    /// it.
    fn balance(&mut self, seconds: f64) {
        if self.chunks.len() == 1 || !self.features.iter().any(|feature| feature.has_uneven_work()) {
            return;
        }
        let start = Instant::now();
        let Some(chunks) = self.balance.after(seconds, &self.nodes.tiles, &self.chunks) else { return };
        self.redistribute(chunks);
        self.balance.set_cost(start.elapsed().as_secs_f64());
    }

    /// Runs a frame on all workers, and says how many sub-steps it came to. The first one has a clock if the frame is timed.
    fn work_on_frame(&mut self, substeps: &[Substep<T>]) -> usize {
        let (at_rest, timed) =
            (Substep::at_rest(), std::mem::take(&mut self.is_timed) && !substeps.is_empty());
        let (times, waited) = (Mutex::new(Vec::new()), Mutex::new(vec![0.0; self.chunks.len()]));
        let (program, done) = (&self.program, AtomicUsize::new(0));
        self.work(&at_rest, |worker| {
            worker.clock = (timed && worker.index == 0).then(|| Rc::new(Clock::default()));
            worker.frame(program, substeps, &at_rest);
            if let Some(clock) = &worker.clock {
                *times.lock().unwrap_or_else(PoisonError::into_inner) = clock.by_name();
            }
            waited.lock().unwrap_or_else(PoisonError::into_inner)[worker.index] = worker.waited;
            done.store(worker.done, Ordering::Relaxed);
        });
        self.balance.waited = waited.into_inner().unwrap_or_else(PoisonError::into_inner);
        if timed {
            self.times = times.into_inner().unwrap_or_else(PoisonError::into_inner);
        }
        done.into_inner()
    }

    /// Runs `job` on every worker at once.
    pub(crate) fn work<'s>(&'s self, substep: &'s Substep<T>, job: impl Fn(&mut Worker<'s, T>) + Sync) {
        self.team.run(|index, barrier| {
            job(&mut Worker {
                nodes: &self.nodes,
                features: &self.features,
                input: &self.input,
                substep,
                index,
                workers: self.chunks.len(),
                tiles: self.chunks[index].clone(),
                states: &self.states,
                turn: self.turn,
                marks: &self.marks,
                resting: &self.resting,
                scratch: &self.scratch,
                barrier,
                waited: 0.0,
                done: 0,
                clock: None,
            });
        });
    }

    /// A column of the present state, or of that after the sub-step.
    pub(crate) fn column_of(&self, next: bool, axis: usize) -> &[T] {
        // SAFETY: workers work while a frame runs, which borrows the backend mutably.
        unsafe { self.states[if next { self.turn.next() } else { self.turn.now }][axis].read() }
    }

    fn column(&self, axis: usize) -> &[T] {
        self.column_of(false, axis)
    }
}

impl<T: Real> Backend for CpuBackend<T> {
    fn frame(&mut self, start: f64, input: FrameInput) -> Result<(), Lost> {
        if self.blown_up > 0.0 {
            // Nobody is to see what comes of it.
            return Ok(());
        }
        self.enter();
        self.input = input;
        let Some(kept) = self.keep() else {
            self.run_frame(start);
            return Ok(());
        };
        loop {
            self.run_frame(start);
            if self.was_stopped() {
                return Ok(());
            }
            let mut before = self.refinement.parts;
            let is_repeated = self.refinement.note(self.taken, self.assembly.time.most_parts());
            if is_repeated {
                self.put_back(&kept);
                before = kept.solvers.refinement.parts;
            }
            if self.refinement.parts != before {
                let by = f64::from(before) / f64::from(self.refinement.parts);
                self.features.iter_mut().for_each(|feature| feature.rescale(by));
            }
            if !is_repeated {
                return Ok(());
            }
        }
    }

    fn stop_on(&mut self, stop: Option<Arc<AtomicBool>>) {
        self.team.stop_on(stop);
    }

    fn was_stopped(&self) -> bool {
        self.team.was_stopped()
    }

    fn mark_good(&mut self) {
        (self.blown_up, self.sums.blown_up) = (0.0, 0.0);
        self.turn.mark_good();
    }

    fn return_to_good(&mut self) -> Result<(), Lost> {
        self.blown_up = 0.0;
        self.turn.return_to_good();
        self.features.iter_mut().for_each(|feature| feature.relocate());
        self.resting.forget_all();
        Ok(())
    }

    fn measure(&mut self) -> Result<(), Lost> {
        self.enter();
        self.resting.forget_all();
        self.run(&[]);
        Ok(())
    }

    fn sums(&mut self) -> Result<FrameSums, Lost> {
        Ok(self.sums.clone())
    }

    fn fetch(&mut self) -> Result<(), Lost> {
        Ok(())
    }

    fn assembly(&self) -> &Assembly {
        &self.assembly
    }

    fn alter(&mut self, how: &mut dyn FnMut(&mut Assembly)) {
        how(&mut self.assembly);
    }

    fn position(&self, node: usize) -> [f64; 3] {
        std::array::from_fn(|axis| self.column(axis)[node].to_f64())
    }

    fn velocity(&self, node: usize) -> [f64; 3] {
        std::array::from_fn(|axis| self.column(3 + axis)[node].to_f64())
    }

    fn set(&mut self, node: usize, position: [f64; 3], velocity: [f64; 3]) {
        if position != self.position(node) {
            self.features.iter_mut().for_each(|feature| feature.relocate());
        }
        let state = position.into_iter().chain(velocity);
        for (column, number) in self.states[self.turn.now].iter_mut().zip(state) {
            column.get_mut()[node] = T::from_f64(number);
        }
        self.forget(node);
    }

    fn pin(&mut self, node: usize) {
        let free = std::mem::replace(&mut self.nodes.inverse_mass[node], T::ZERO);
        self.when_free.entry(node).or_insert(free);
        let at = self.position(node);
        self.set(node, at, [0.0; 3]);
    }

    fn unpin(&mut self, node: usize) {
        if let Some(&free) = self.when_free.get(&node) {
            self.nodes.inverse_mass[node] = free;
        }
        self.forget(node);
    }

    fn let_rest(&mut self, bodies: &[bool]) {
        self.resting.want(bodies);
    }

    fn is_free(&self, node: usize) -> bool {
        self.nodes.inverse_mass[node] > T::ZERO
    }

    fn bytes(&self, node: usize, velocity: bool, sink: &mut Vec<u8>) {
        let first = if velocity { 3 } else { 0 };
        (first..first + 3).for_each(|axis| self.column(axis)[node].bytes(sink));
    }

    fn solver_state(&self) -> SolverState {
        let mut state = SolverState { refinement: self.refinement, ..SolverState::default() };
        self.features.iter().for_each(|feature| feature.save(&mut state));
        state
    }

    fn set_solver_state(&mut self, from: &SolverState) {
        self.refinement = from.refinement;
        self.features.iter_mut().for_each(|feature| feature.load(from));
        self.resting.forget_all();
    }

    fn time_stages(&mut self) {
        self.is_timed = true;
    }

    fn stage_times(&mut self) -> Vec<(&'static str, f64)> {
        std::mem::take(&mut self.times)
    }

    fn threads(&self) -> usize {
        self.team.threads()
    }

    fn limit_threads(&mut self, most: usize) {
        if let Some(workers) = self.attendance.limit(most.clamp(1, self.team.threads())) {
            self.set_workers(workers);
        }
    }

    fn device(&self) -> Device {
        let threads = self.threads();
        let plural = if threads == 1 { "" } else { "s" };
        Device { backend: "cpu", name: format!("cpu, {threads} thread{plural}, {}", self.nodes.level) }
    }

    fn memory(&self) -> usize {
        let state = (6 * LEADS.len() + 2) * padded(&self.assembly) * size_of::<T>();
        state + self.features.iter().map(|feature| feature.bytes()).sum::<usize>()
    }
}

/// Places in every column: all nodes, and a margin that vector loads may read past the last row.
pub fn padded(assembly: &Assembly) -> usize {
    assembly.places + 4 * LANES
}

/// Inverse mass and mass by solver index.
fn masses<T: Real>(assembly: &Assembly) -> [Column<T>; 2] {
    let column = |lead| Column::staggered(padded(assembly), lead);
    let mut columns = [column(12 * STAGGER), column(0)];
    for body in &assembly.bodies {
        for (local, (&mass, &free)) in body.mass.iter().zip(&body.free).enumerate() {
            columns[0][body.first + local] = if free { T::from_f64(1.0 / mass) } else { T::ZERO };
            columns[1][body.first + local] = T::from_f64(mass);
        }
    }
    columns
}

/// The state at the start. `lead` separates the buffers of a state in the cache.
fn start<T: Real>(assembly: &Assembly, lead: usize) -> Fields<T> {
    std::array::from_fn(|axis| {
        let mut column = Column::staggered(padded(assembly), lead + STAGGER * axis);
        for body in &assembly.bodies {
            let numbers = if axis < 3 { &body.start } else { &body.start_velocity };
            for (local, vector) in numbers.iter().enumerate() {
                column[body.first + local] = T::from_f64(vector[axis % 3]);
            }
        }
        column.into()
    })
}
