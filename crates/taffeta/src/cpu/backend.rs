//! Memory of the CPU backend, and one frame of it.

#[cfg(feature = "gpu")]
mod apart;

use crate::attachments::cpu::{AttachSetup, AttachWork};
use crate::backend::{Backend, Device, FrameInput, Lost, SolverState};
use crate::build::Assembly;
use crate::contact::collider_mesh::cache::{Meshes, NearWork};
use crate::contact::nodes::cpu::{Found, PairScratch, PairSetup, PairWork};
use crate::cpu::balance::Balance;
use crate::cpu::column::Column;
use crate::cpu::shared::Shared;
use crate::cpu::simd::SimdLevel;
use crate::cpu::team::Team;
use crate::cpu::tiles::{self, TilePlan, TiledSprings};
use crate::cpu::timed::{Clock, Timed};
use crate::cpu::worker::{Scratch, Worker};
use crate::diagnostics::cpu::{VolumeChunk, frame_sums};
use crate::diagnostics::{FrameSums, PairSums, SolverReport, StateSums};
use crate::elements::aero::cpu::{self as air, AirPanels};
use crate::elements::hinge::hinge::Rest;
use crate::plan;
use crate::real::Real;
use crate::solvers::dual::cpu::{SolveSetup, SolveWork};
use crate::solvers::implicit::cpu::{PrimalSetup, PrimalWork};
use crate::step;
use crate::topology::{Csr, LANES};
use crate::volume::cpu::{Corrections, VolumeBody};
use std::ops::Range;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

#[cfg(feature = "gpu")]
pub use apart::{Between, KeptParts};

/// Cache lines between the starts of the arrays that a kernel walks through together: twelve of them share the 64
/// sets of a first-level cache evenly.
const STAGGER: usize = 5;

/// Position [m] and velocity [m/s] by axis: x, y, z, then their rates.
pub type Fields<T> = [Column<T>; 6];

/// What does not change while a frame runs.
pub struct Setup<T> {
    /// The scene.
    pub assembly: Assembly,
    /// Springs of each body.
    pub springs: Vec<TiledSprings<T>>,
    /// All tiles, in order.
    pub tiles: Vec<TilePlan>,
    /// Inverse mass [1/kg]; 0: held, or no node.
    pub inverse_mass: Column<T>,
    /// Mass [kg]; 0: no node.
    pub mass: Column<T>,
    /// Hinges of all bodies.
    pub hinges: Hinges<T>,
    /// Triangles that air acts on.
    pub panels: AirPanels<T>,
    /// Bodies that keep their volume, or are under a pressure.
    pub volumes: Vec<VolumeBody<T>>,
    /// Which of them each body is.
    pub volume_of_body: Vec<Option<usize>>,
    /// Springs that are, or become, constraints, if any do.
    pub solve: Option<SolveSetup<T>>,
    /// Springs that are solved for by nodes, if that is asked.
    pub primal: Option<PrimalSetup<T>>,
    /// Joints and tethers, if there are any.
    pub attach: Option<AttachSetup<T>>,
    /// Nodes that touch each other, if any do.
    pub pairs: Option<PairSetup<T>>,
    /// Colliders of triangles.
    pub meshes: Meshes<T>,
    /// Triangles of closed bodies, in chunks.
    pub volume_chunks: Vec<VolumeChunk>,
    /// Instructions in use.
    pub level: SimdLevel,
    /// What the program does in this frame.
    pub input: FrameInput,
}

/// Hinges by solver index.
#[derive(Default)]
pub struct Hinges<T> {
    /// Corners `[a, b, left, right]`.
    pub corners: Vec<[u32; 4]>,
    /// Each at rest.
    pub rest: Vec<Rest<T>>,
    /// Hinges, stiffness [N·m/rad] and damping [N·m·s/rad] of each body that has some.
    pub bodies: Vec<(Range<usize>, T, T)>,
    /// For each place: 4·hinge + corner. No rows where there are no hinges.
    pub by_node: Csr,
}

/// The CPU backend in numbers of type `T`.
pub struct CpuBackend<T> {
    pub(crate) setup: Setup<T>,
    team: Team,
    pub(crate) shares: Vec<Range<usize>>,
    pub(crate) scratch: Vec<Mutex<Scratch<T>>>,
    /// The state before and after a sub-step, by turns.
    fields: [Fields<T>; 2],
    current: usize,
    hinge_forces: Vec<[[T; 3]; 4]>,
    panel_forces: [Column<T>; 3],
    corrections: Corrections<T>,
    solve: SolveWork<T>,
    primal: PrimalWork<T>,
    attach: AttachWork,
    pub(crate) pairs: PairWork<T>,
    near: NearWork<T>,
    pub(crate) balance: Balance,
    tile_sums: Vec<StateSums>,
    volumes: Vec<f64>,
    sums: FrameSums,
    /// Whether the next frame is timed by stages, and the times [s] of the last one that was.
    is_timed: bool,
    times: Vec<(&'static str, f64)>,
}

impl<T: Real> CpuBackend<T> {
    /// Takes a scene into memory.
    pub fn new(mut assembly: Assembly, threads: usize) -> Result<Self, String> {
        let mut springs = Vec::new();
        for body in &assembly.bodies {
            springs.push(TiledSprings::new(body)?);
        }
        let tiles = tiles::tiles(&assembly);
        let team = Team::new(threads);
        let shares = tiles::shares(&tiles, team.threads());
        let widest = tiles.iter().map(TilePlan::len).max().unwrap_or(0);
        let cols = tiles.iter().map(|tile| tile.cols.len()).max().unwrap_or(0);
        let hinges = Hinges::new(&assembly);
        let panels = AirPanels::new(&assembly);
        let volume_chunks = VolumeChunk::all(&assembly);
        let [inverse_mass, mass] = masses(&assembly);
        let (volumes, volume_of_body) = VolumeBody::all(&assembly);
        let level = SimdLevel::detect();
        let meshes = Meshes::new(&assembly, level);
        let clock = Instant::now();
        let pairs = PairSetup::new(&assembly, &tiles, &shares);
        let balance = Balance::new(shares.len(), clock.elapsed().as_secs_f64());
        let primal = PrimalSetup::new(&mut assembly);
        let solve = SolveSetup::new(&mut assembly, &tiles);
        let attach = AttachSetup::new(&assembly, &tiles);
        let watch = solve.as_ref().and_then(SolveSetup::watched);
        let fields = [start(&assembly, 0), start(&assembly, 6 * STAGGER)];
        assembly.release();
        Ok(Self {
            scratch: shares
                .iter()
                .map(|share| {
                    let pairs = pairs.as_ref().map(|_| PairScratch::new(assembly.places, share.len()));
                    Mutex::new(Scratch::new(widest, (cols, watch), volumes.len(), pairs))
                })
                .collect(),
            fields,
            current: 0,
            hinge_forces: vec![[[T::ZERO; 3]; 4]; hinges.corners.len()],
            panel_forces: air::room(&panels),
            corrections: Corrections::new(&volumes),
            solve: SolveWork::new(solve.as_ref(), tiles.len()),
            primal: PrimalWork::new(primal.as_ref()),
            attach: AttachWork::new(attach.as_ref()),
            pairs: PairWork::new(pairs.as_ref(), shares.len()),
            near: NearWork::new(&meshes, padded(&assembly)),
            balance,
            tile_sums: vec![StateSums::default(); tiles.len()],
            volumes: vec![0.0; volume_chunks.len()],
            setup: Setup {
                assembly,
                springs,
                tiles,
                inverse_mass,
                mass,
                hinges,
                panels,
                volumes,
                volume_of_body,
                solve,
                primal,
                attach,
                pairs,
                meshes,
                volume_chunks,
                level,
                input: FrameInput::default(),
            },
            team,
            shares,
            sums: FrameSums::default(),
            is_timed: false,
            times: Vec::new(),
        })
    }

    /// Runs sub-steps, and measures the state after them.
    fn run(&mut self, substeps: &[plan::Substep<T>]) {
        let clock = Instant::now();
        self.work_on_frame(substeps);
        let seconds = clock.elapsed().as_secs_f64();
        self.current = (self.current + substeps.len()) % 2;
        let state = self.fields[self.current].each_ref().map(|column| &column[..]);
        self.sums = frame_sums(&self.setup, state, &self.tile_sums, &self.volumes);
        self.sums.pairs = self.pair_sums(substeps.len());
        self.sums.solver = self.solver_report();
        self.sums.broken = self.attach.broken();
        if !substeps.is_empty() {
            self.balance(seconds);
        }
    }

    /// Has all workers do a frame; the first one has a clock, if that was asked for.
    fn work_on_frame(&mut self, substeps: &[plan::Substep<T>]) {
        if substeps.is_empty() || !std::mem::take(&mut self.is_timed) {
            return self.work(|worker| step::frame(worker, substeps));
        }
        let times = Mutex::new(Vec::new());
        self.work(|worker| {
            if worker.index > 0 {
                return step::frame(worker, substeps);
            }
            let clock = Clock::default();
            step::frame(&mut Timed { worker, clock: &clock }, substeps);
            *times.lock().unwrap_or_else(PoisonError::into_inner) = clock.by_name();
        });
        self.times = times.into_inner().unwrap_or_else(PoisonError::into_inner);
    }

    /// What the solver did in a frame; all workers know it.
    fn solver_report(&mut self) -> SolverReport {
        let first = self.scratch.first_mut().map(|one| one.get_mut().unwrap_or_else(PoisonError::into_inner));
        let primal = self.setup.primal.is_some();
        let report = |scratch: &mut Scratch<T>| {
            std::mem::take(if primal { &mut scratch.primal.report } else { &mut scratch.solve.report })
        };
        first.map(report).unwrap_or_default()
    }

    /// What was found of nodes in contact in the last of some sub-steps.
    fn pair_sums(&mut self, substeps: usize) -> PairSums {
        let found = if substeps > 0 { self.pairs.found() } else { Found::default() };
        let first = self.scratch.first_mut().map(|one| one.get_mut().unwrap_or_else(PoisonError::into_inner));
        let searches = first.and_then(|scratch| Some(std::mem::take(&mut scratch.pairs.as_mut()?.searches)));
        PairSums { pairs: found.ends / 2, nearest: found.nearest, searches: searches.unwrap_or(0) }
    }

    /// Runs `job` on every worker at once.
    fn work(&mut self, job: impl Fn(&mut Worker<'_, T>) + Sync) {
        let [a, b] = &mut self.fields;
        let buffers = [a, b].map(|fields| fields.each_mut().map(|column| Shared::new(column)));
        let hinge_forces = Shared::new(&mut self.hinge_forces);
        let panel_forces = self.panel_forces.each_mut().map(|column| Shared::new(column));
        let tile_sums = Shared::new(&mut self.tile_sums);
        let volumes = Shared::new(&mut self.volumes);
        let corrections = self.corrections.share();
        let solve = self.solve.share();
        let primal = self.primal.share();
        let attach = self.attach.share();
        let pairs = self.pairs.share();
        let near = self.near.share();
        let (setup, shares, scratch, current) = (&self.setup, &self.shares, &self.scratch, self.current);
        self.team.run(|index, barrier| {
            let mut scratch = scratch[index].lock().unwrap_or_else(PoisonError::into_inner);
            job(&mut Worker {
                setup,
                index,
                workers: shares.len(),
                share: shares[index].clone(),
                buffers: &buffers,
                current,
                hinge_forces: &hinge_forces,
                panel_forces: &panel_forces,
                corrections: &corrections,
                solve: &solve,
                primal: &primal,
                attach: &attach,
                pairs: &pairs,
                near: &near,
                tile_sums: &tile_sums,
                volumes: &volumes,
                scratch: &mut scratch,
                barrier,
            });
        });
    }
}

impl<T: Real> Backend for CpuBackend<T> {
    fn frame(&mut self, start: f64, input: FrameInput) -> Result<(), Lost> {
        self.setup.input = input;
        let substeps = plan::frame(&self.setup.assembly, start);
        self.run(&substeps);
        Ok(())
    }

    fn measure(&mut self) -> Result<(), Lost> {
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
        &self.setup.assembly
    }

    fn alter(&mut self, how: &mut dyn FnMut(&mut Assembly)) {
        how(&mut self.setup.assembly);
    }

    fn position(&self, node: usize) -> [f64; 3] {
        std::array::from_fn(|axis| self.fields[self.current][axis][node].to_f64())
    }

    fn velocity(&self, node: usize) -> [f64; 3] {
        std::array::from_fn(|axis| self.fields[self.current][3 + axis][node].to_f64())
    }

    fn set(&mut self, node: usize, position: [f64; 3], velocity: [f64; 3]) {
        for axis in 0..3 {
            self.fields[self.current][axis][node] = T::from_f64(position[axis]);
            self.fields[self.current][3 + axis][node] = T::from_f64(velocity[axis]);
        }
        self.near.forget(node);
    }

    fn hold(&mut self, node: usize) {
        self.setup.inverse_mass[node] = T::ZERO;
        let at = self.position(node);
        self.set(node, at, [0.0; 3]);
    }

    fn let_go(&mut self, node: usize) {
        self.setup.inverse_mass[node] = T::ONE / self.setup.mass[node];
        self.near.forget(node);
    }

    fn is_free(&self, node: usize) -> bool {
        self.setup.inverse_mass[node] > T::ZERO
    }

    fn bytes(&self, node: usize, velocity: bool, sink: &mut Vec<u8>) {
        let first = if velocity { 3 } else { 0 };
        for column in &self.fields[self.current][first..first + 3] {
            column[node].bytes(sink);
        }
    }

    fn solver_state(&self) -> SolverState {
        let of_springs = match (&self.setup.primal, &self.setup.solve) {
            (Some(setup), _) => self.primal.solver_state(setup),
            (None, Some(setup)) => self.solve.solver_state(setup),
            (None, None) => SolverState::default(),
        };
        let joints = self.setup.attach.as_ref().map(|setup| self.attach.solver_state(setup));
        SolverState { joints: joints.unwrap_or_default(), ..of_springs }
    }

    fn set_solver_state(&mut self, from: &SolverState) {
        if self.setup.primal.is_some() {
            self.primal.set_solver_state(from);
        }
        if let Some(setup) = &self.setup.solve {
            self.solve.set_solver_state(setup, &self.setup.tiles, from);
        }
        if let Some(setup) = &self.setup.attach {
            self.attach.set_solver_state(setup, &from.joints);
        }
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

    fn device(&self) -> Device {
        let threads = self.threads();
        let plural = if threads == 1 { "" } else { "s" };
        Device { backend: "cpu", name: format!("cpu, {threads} thread{plural}, {}", self.setup.level) }
    }

    fn memory(&self) -> usize {
        let columns = 14 * self.setup.mass.len() * size_of::<T>();
        let springs: usize = self.setup.springs.iter().map(TiledSprings::bytes).sum();
        let hinges = self.hinge_forces.len() * (size_of::<[[T; 3]; 4]>() + 36);
        let air = self.setup.panels.bytes() + 3 * self.panel_forces[0].len() * size_of::<T>();
        let tables = self.setup.primal.as_ref().map_or(0, PrimalSetup::bytes);
        let solved = self.solve.bytes() + self.primal.bytes() + tables;
        let attached = self.setup.attach.as_ref().map_or(0, AttachSetup::bytes);
        columns + springs + hinges + air + attached + self.corrections.bytes() + solved + self.pairs.bytes()
    }
}

/// Places in every column: all nodes, and a margin that vector loads may read past the last row.
fn padded(assembly: &Assembly) -> usize {
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

/// The state at the start: in place, at rest. `lead` tells the two buffers of a state apart in the cache.
fn start<T: Real>(assembly: &Assembly, lead: usize) -> Fields<T> {
    let mut fields: Fields<T> =
        std::array::from_fn(|axis| Column::staggered(padded(assembly), lead + STAGGER * axis));
    for body in &assembly.bodies {
        for (local, place) in body.start.iter().enumerate() {
            for axis in 0..3 {
                fields[axis][body.first + local] = T::from_f64(place[axis]);
            }
        }
    }
    fields
}

impl<T: Real> Hinges<T> {
    fn new(assembly: &Assembly) -> Self {
        let mut hinges =
            Self { corners: Vec::new(), rest: Vec::new(), bodies: Vec::new(), by_node: Csr::default() };
        for body in assembly.bodies.iter().filter(|body| !body.hinges.is_empty()) {
            let from = hinges.corners.len();
            let first = body.first as u32;
            hinges.corners.extend(body.hinges.iter().map(|corners| corners.map(|node| node + first)));
            hinges.rest.extend(
                body.hinge_rest.iter().map(|rest| Rest {
                    angle: T::from_f64(rest.angle),
                    steepness: T::from_f64(rest.steepness),
                }),
            );
            let range = from..hinges.corners.len();
            hinges.bodies.push((range, T::from_f64(body.hinge.k), T::from_f64(body.hinge.d)));
        }
        if !hinges.corners.is_empty() {
            hinges.by_node = Csr::corners(assembly.places, &hinges.corners);
        }
        hinges
    }
}
