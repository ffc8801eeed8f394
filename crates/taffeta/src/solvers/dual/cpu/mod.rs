//! Constraints on the CPU: which springs are constraints now, and the system that their pulls solve.
//!
//! Rows (constraints) and nodes of the system are lists of their own, cut into chunks of one body each, which the workers
//! share evenly. Sums are taken by chunk in [`LANES`](crate::topology::LANES) lanes, then chunk by chunk: an order that
//! depends on neither threads nor vector width.

mod active;
mod conjugate;
mod kernels;
mod layout;
mod remember;
mod tile;

pub use layout::Layout;

use crate::build::Assembly;
use crate::contact::collider_mesh::cache::Near;
use crate::contact::colliders::moving::ColliderNow;
use crate::contact::colliders::press::Press;
use crate::cpu::backend::Setup;
use crate::cpu::shared::Shared;
use crate::cpu::tiles::TilePlan;
use crate::diagnostics::SolverReport;
use crate::plan::Substep;
use crate::real::Real;
use crate::scene::{Method, Solver};
use crate::solvers::constraints::Constraints;
use crate::solvers::dual::distance::Softness;
use crate::topology::Csr;
use std::ops::Range;

/// Four numbers side by side: a vector, and one more.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(16))]
pub struct Quad<T>(pub [T; 4]);

/// What does not change.
pub struct SolveSetup<T> {
    /// Ends, materials, bodies.
    pub list: Constraints,
    /// Rest lengths [m].
    rest: Vec<T>,
    /// For each place: 2·constraint + end.
    by_place: Csr,
    /// For each tile: the constraints that its nodes own (are the first ends of).
    of_tile: Vec<Vec<Range<usize>>>,
    /// Method and numbers.
    pub solver: Solver,
    /// Whether springs act as well, and constraints only where they are too long.
    pub adaptive: bool,
    /// Whether surfaces hold nodes while pulls are solved for. Where constraints come and go, what the last ones pulled says
    /// too little of what will be pressed: contact alone is nearer the truth.
    surfaces: bool,
}

/// What changes. Pulls and activity are remembered from one sub-step to the next.
pub struct SolveWork<T> {
    /// Pull of each constraint [N].
    pub pull: Vec<T>,
    /// Whether it is active.
    pub active: Vec<bool>,
    /// Whether the nodes of a tile wait for constraints, how many active ones it owns, and how many nodes with active
    /// constraints and ends of such it has.
    waits: Vec<bool>,
    tile_rows: Vec<u32>,
    tile_nodes: Vec<[u32; 2]>,
    /// Constraint of each row.
    which: Vec<u32>,
    /// Where a constraint and a place are in the system.
    row_of: Vec<u32>,
    node_of: Vec<u32>,
    /// Place of each node of the system.
    places: Vec<u32>,
    /// Entries of each node: 2·row + end.
    spans: Vec<[u32; 2]>,
    entries: Vec<u32>,
    /// Nodes of each row.
    ends: Vec<[u32; 2]>,
    /// Direction, scaled, and compliance of each row.
    rows: Vec<Quad<T>>,
    /// Scale of each row; pull of the spring that it stands in for, by the scale.
    scale: Vec<T>,
    offset: Vec<T>,
    /// Right side without nodes' velocities; vectors of the iteration.
    right: Vec<T>,
    x: Vec<T>,
    r: Vec<T>,
    p: Vec<T>,
    s: Vec<T>,
    w: Vec<T>,
    /// A vector's part along each row's direction.
    pulled: Vec<Quad<T>>,
    /// By node: what pulls do to its velocity, by the step.
    response: Vec<Quad<T>>,
    /// By node: how a surface holds it, and which.
    press: Vec<Press<T>>,
    surface: Vec<u32>,
    /// By chunk of rows: squared residual (at first, right side), squared noise, and residual times the system times residual.
    sums: Vec<[f64; 3]>,
}

/// The same, lent to all workers.
pub struct SharedSolve<'a, T> {
    pull: Shared<'a, T>,
    active: Shared<'a, bool>,
    waits: Shared<'a, bool>,
    tile_rows: Shared<'a, u32>,
    tile_nodes: Shared<'a, [u32; 2]>,
    which: Shared<'a, u32>,
    row_of: Shared<'a, u32>,
    node_of: Shared<'a, u32>,
    places: Shared<'a, u32>,
    spans: Shared<'a, [u32; 2]>,
    entries: Shared<'a, u32>,
    ends: Shared<'a, [u32; 2]>,
    rows: Shared<'a, Quad<T>>,
    scale: Shared<'a, T>,
    offset: Shared<'a, T>,
    right: Shared<'a, T>,
    x: Shared<'a, T>,
    r: Shared<'a, T>,
    p: Shared<'a, T>,
    s: Shared<'a, T>,
    w: Shared<'a, T>,
    pulled: Shared<'a, Quad<T>>,
    response: Shared<'a, Quad<T>>,
    press: Shared<'a, Press<T>>,
    surface: Shared<'a, u32>,
    sums: Shared<'a, [f64; 3]>,
}

/// What a worker keeps.
#[derive(Default)]
pub struct SolveScratch<T> {
    /// Chunks of the system.
    layout: Layout,
    /// How each material gives way in this sub-step.
    softness: Vec<Softness<T>>,
    /// How far each body's system is.
    bodies: Vec<conjugate::Progress>,
    /// What the frame's report is to say.
    pub report: SolverReport,
}

impl<T: Real> SolveSetup<T> {
    /// Of a scene that has constraints. `tiles` are all of the backend's.
    pub fn new(assembly: &mut Assembly, tiles: &[TilePlan]) -> Option<Self> {
        let list = std::mem::take(&mut assembly.constraints);
        if list.is_empty() {
            return None;
        }
        let owned = |run: Range<usize>| {
            let from = |place: usize| list.ends.partition_point(|ends| (ends[0] as usize) < place);
            from(run.start)..from(run.end)
        };
        Some(Self {
            rest: list.rest.iter().map(|&rest| T::from_f64(rest)).collect(),
            by_place: Csr::corners(assembly.places, &list.ends),
            of_tile: tiles.iter().map(|tile| tile.runs().map(|(_, run)| owned(run)).collect()).collect(),
            solver: assembly.solver.clone(),
            adaptive: assembly.solver.method == Method::Acad,
            surfaces: assembly.solver.method == Method::Ice && !assembly.colliders.is_empty(),
            list,
        })
    }

    /// Colliders that hold nodes while pulls are solved for.
    pub fn colliders<'s>(&self, substep: &'s Substep<T>) -> &'s [ColliderNow<T>] {
        if self.surfaces { &substep.colliders } else { &[] }
    }

    /// Stretch to watch springs for.
    pub fn watched(&self) -> Option<T> {
        self.adaptive.then(|| T::from_f64(1.0 + self.solver.acad.threshold))
    }
}

impl<T: Real> SolveWork<T> {
    /// Room for all constraints of a scene; where they are not adaptive, its lists are made here for good.
    pub fn new(setup: Option<&SolveSetup<T>>, tiles: usize) -> Self {
        let count = setup.map_or(0, |setup| setup.list.len());
        let tiles = if count > 0 { tiles } else { 0 };
        let places = setup.map_or(0, |setup| setup.by_place.offsets.len() - 1);
        // What tells where an active constraint is, where they come and go.
        let [changing, placed] =
            if setup.is_some_and(|setup| setup.adaptive) { [count, places] } else { [0; 2] };
        let quads = |n| vec![Quad::default(); n];
        let numbers = || vec![T::ZERO; count];
        let mut work = Self {
            pull: numbers(),
            active: vec![false; changing],
            waits: vec![false; tiles],
            tile_rows: vec![0; tiles],
            tile_nodes: vec![[0; 2]; tiles],
            which: vec![0; count],
            row_of: vec![0; changing],
            node_of: vec![0; placed],
            places: vec![0; places],
            spans: vec![[0; 2]; places],
            entries: vec![0; 2 * count],
            ends: vec![[0; 2]; count],
            rows: quads(count),
            scale: numbers(),
            offset: numbers(),
            right: numbers(),
            x: numbers(),
            r: numbers(),
            p: numbers(),
            s: numbers(),
            w: numbers(),
            pulled: quads(count),
            response: quads(places),
            press: vec![Press::FREE; places],
            surface: vec![0; places],
            sums: vec![[0.0; 3]; setup.map_or(0, |setup| layout::most_chunks(&setup.list))],
        };
        if let Some(setup) = setup.filter(|setup| !setup.adaptive) {
            work.lay_out_all(setup);
        }
        work
    }

    /// Lends it to all workers.
    pub fn share(&mut self) -> SharedSolve<'_, T> {
        SharedSolve {
            pull: Shared::new(&mut self.pull),
            active: Shared::new(&mut self.active),
            waits: Shared::new(&mut self.waits),
            tile_rows: Shared::new(&mut self.tile_rows),
            tile_nodes: Shared::new(&mut self.tile_nodes),
            which: Shared::new(&mut self.which),
            row_of: Shared::new(&mut self.row_of),
            node_of: Shared::new(&mut self.node_of),
            places: Shared::new(&mut self.places),
            spans: Shared::new(&mut self.spans),
            entries: Shared::new(&mut self.entries),
            ends: Shared::new(&mut self.ends),
            rows: Shared::new(&mut self.rows),
            scale: Shared::new(&mut self.scale),
            offset: Shared::new(&mut self.offset),
            right: Shared::new(&mut self.right),
            x: Shared::new(&mut self.x),
            r: Shared::new(&mut self.r),
            p: Shared::new(&mut self.p),
            s: Shared::new(&mut self.s),
            w: Shared::new(&mut self.w),
            pulled: Shared::new(&mut self.pulled),
            response: Shared::new(&mut self.response),
            press: Shared::new(&mut self.press),
            surface: Shared::new(&mut self.surface),
            sums: Shared::new(&mut self.sums),
        }
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        let each = size_of::<T>() * 9 + 2 * size_of::<Quad<T>>() + 1 + 4 * 6;
        self.pull.len() * each + self.places.len() * (size_of::<Quad<T>>() + size_of::<Press<T>>() + 20)
    }
}

impl<T> SharedSolve<'_, T> {
    /// By tile: whether its nodes wait for constraints.
    ///
    /// # Safety
    /// Until the next barrier no worker notes anew which tiles wait.
    pub unsafe fn waits(&self) -> &[bool] {
        // SAFETY: promised by the caller.
        unsafe { self.waits.read() }
    }
}

/// A worker's part in the solution.
pub struct SolveWorker<'w, 'a, T> {
    /// What does not change.
    pub setup: &'w Setup<T>,
    pub solve: &'w SolveSetup<T>,
    pub shared: &'w SharedSolve<'a, T>,
    pub scratch: &'w mut SolveScratch<T>,
    /// Its tiles.
    pub share: Range<usize>,
    /// Which worker of how many.
    pub index: usize,
    pub workers: usize,
    pub barrier: &'w crate::cpu::team::Barrier,
    /// State before, and what waits where the state after will be.
    pub old: [&'w [T]; 6],
    pub next: &'w [Shared<'a, T>; 6],
    /// Step [s].
    pub h: T,
    pub colliders: &'w [ColliderNow<T>],
    pub near: Near<'w, T>,
}
