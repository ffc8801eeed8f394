//! The dual solver on the CPU: the active constraints, and the system of their forces.
//!
//! The rows (constraints) and nodes of the system are lists, cut into chunks of one body each, but for bodies of constraints
//! that are not adaptive and lie in few [bands](bands). Workers get even parts of the chunks. Sums are taken by chunk in [`LANES`](crate::topology::LANES) lanes, then chunk by chunk. This order
//! depends on neither threads nor vector width.

mod active;
mod band_kernels;
mod bands;
mod conjugate;
pub(crate) mod kernels;
mod layout;
mod tile;

use crate::backend::SolverState;
use crate::contact::collider_mesh::cache::MeshCache;
use crate::contact::colliders::cpu::Colliders;
use crate::contact::colliders::met::MetColliders;
use crate::contact::colliders::predicted_contact::PredictedContact;
use crate::cpu::backend::Context;
use crate::cpu::cells::PerWorker;
use crate::cpu::feature::{Feature, Flow};
use crate::cpu::numbers::Numbers;
use crate::cpu::shared::Shared;
use crate::cpu::tile::Tile;
use crate::cpu::tiles::TilePlan;
use crate::cpu::worker::Worker;
use crate::plan::Substep;
use crate::real::Real;
use crate::report::{FrameSums, SolverReport};
use crate::scene::{Method, Solver};
use crate::solvers::constraints::Constraints;
use crate::solvers::dual::distance::Softness;
use crate::solvers::waiting;
use crate::step::{Marks, Op};
use crate::topology::Csr;
use bands::{BandState, Bands};
use layout::Layout;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// Four numbers side by side: a vector, and one more.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(16))]
pub struct Quad<T>(pub [T; 4]);

/// Springs that are, or become, constraints.
pub struct Dual<T> {
    /// Ends, materials, bodies.
    list: Constraints,
    /// Rest lengths [m].
    rest: Vec<T>,
    /// For each place: 2·constraint + end.
    by_place: Csr,
    /// For each tile: the constraints that its nodes own (are the first ends of).
    of_tile: Vec<Vec<Range<usize>>>,
    /// Method and numbers.
    solver: Solver,
    /// Whether constraints are adaptive: springs act as well, and only those that are too long are constraints.
    adaptive: bool,
    /// Whether contacts are predicted. Adaptive constraints predict none: the forces of the last active ones say too
    /// little about the next contacts, and contact alone is more accurate.
    surfaces: bool,
    /// Nodes of each body of the scene, and tiles.
    bodies: Vec<Range<usize>>,
    tiles: Vec<TilePlan>,
    scratch: PerWorker<SolveScratch<T>>,
    work: Work<T>,
    /// The bands of each body that has few, and what their rows and nodes have.
    bands: Vec<Option<Bands<T>>>,
    band_state: BandState<T>,
}

/// State that changes. Forces and activity are kept from one sub-step to the next.
struct Work<T> {
    /// Force of each constraint [N].
    multiplier: Shared<T>,
    /// Whether it is active.
    active: Vec<AtomicBool>,
    /// By tile: the number of active constraints that its nodes own; the number of nodes with active constraints, and
    /// of their ends.
    tile_rows: Vec<AtomicU32>,
    tile_nodes: Vec<[AtomicU32; 2]>,
    /// Constraint of each row.
    which: Shared<u32>,
    /// The row of a constraint and the node of a place in the system.
    row_of: Shared<u32>,
    node_of: Shared<u32>,
    /// Place of each node of the system.
    places: Shared<u32>,
    /// Entries of each node: 2·row + end.
    spans: Shared<[u32; 2]>,
    entries: Shared<u32>,
    /// Nodes of each row.
    ends: Shared<[u32; 2]>,
    /// Direction, scaled, and compliance of each row.
    rows: Shared<Quad<T>>,
    /// Scale of each row; force of the spring that it replaces, divided by the scale.
    scale: Shared<T>,
    offset: Shared<T>,
    /// Right side without nodes' velocities; vectors of the iteration.
    right: Shared<T>,
    x: Shared<T>,
    r: Shared<T>,
    p: Shared<T>,
    s: Shared<T>,
    w: Shared<T>,
    /// The force of a vector along each row's direction.
    row_forces: Shared<Quad<T>>,
    /// By node: the velocity change by constraint forces, divided by the sub-step.
    response: Shared<Quad<T>>,
    /// By node: its predicted contact, and the collider.
    predicted: Shared<PredictedContact<T>>,
    collider: Shared<u32>,
    /// By chunk of rows: squared residual (at first, right side), squared noise, and r·A r.
    sums: Numbers<3>,
}

/// The scratch memory of a worker.
#[derive(Default)]
pub struct SolveScratch<T> {
    /// Chunks of the system.
    layout: Layout,
    /// The softness of each material in this sub-step.
    softness: Vec<Softness<T>>,
    /// The state of conjugate gradients on each body's system.
    bodies: Vec<conjugate::CgState>,
    /// The part of the frame's report.
    report: SolverReport,
}

impl<T: Real> Dual<T> {
    /// The solver of a scene with constraints.
    pub fn new(context: &mut Context<'_, T>) -> Option<Self> {
        let (assembly, tiles) = (&mut *context.assembly, &context.nodes.tiles);
        let list = assembly.take_constraints();
        if list.is_empty() {
            return None;
        }
        let owned = |run: Range<usize>| {
            let from = |place: usize| list.ends.partition_point(|ends| (ends[0] as usize) < place);
            from(run.start)..from(run.end)
        };
        let adaptive = assembly.solver.method == Method::Acad;
        let by_place = Csr::corners(assembly.places, &list.ends);
        let bodies: Vec<_> = assembly.bodies.iter().map(|body| body.solver_range()).collect();
        let bands =
            if adaptive { bodies.iter().map(|_| None).collect() } else { Bands::of_bodies(&list, &bodies) };
        let work = Work::new(&list, &by_place, &bands, tiles.len(), adaptive);
        Some(Self {
            band_state: BandState::new(&bands),
            bands,
            rest: list.rest.iter().map(|&rest| T::from_f64(rest)).collect(),
            by_place,
            of_tile: tiles.iter().map(|tile| tile.runs().map(|(_, run)| owned(run)).collect()).collect(),
            solver: assembly.solver.clone(),
            adaptive,
            surfaces: assembly.solver.method == Method::Ice && !assembly.colliders().is_empty(),
            bodies,
            tiles: tiles.clone(),
            scratch: PerWorker::new(context.chunks.len(), |_| SolveScratch::default()),
            work,
            list,
        })
    }

    /// Colliders whose contacts are predicted.
    fn colliders<'s>(&self, substep: &'s Substep<T>) -> MetColliders<'s, T> {
        if self.surfaces { substep.met_colliders() } else { MetColliders::NONE }
    }
}

impl<T: Real> Work<T> {
    /// Memory for all constraints of a scene. If they are not adaptive, the lists are made here, once.
    fn new(
        list: &Constraints,
        by_place: &Csr,
        bands: &[Option<Bands<T>>],
        tiles: usize,
        adaptive: bool,
    ) -> Self {
        let (all, places) = (list.len(), by_place.offsets.len() - 1);
        // Without lists, if all bodies have bands.
        let is_listed = bands.iter().any(Option::is_none);
        let (count, nodes) = if is_listed { (all, places) } else { (0, 0) };
        // Indices of active constraints, if they are adaptive.
        let [changing, placed] = if adaptive { [count, places] } else { [0; 2] };
        let quads = |n| Shared::from(vec![Quad::default(); n]);
        let numbers = || Shared::from(vec![T::ZERO; count]);
        let span = |place| [by_place.offsets[place], by_place.offsets[place + 1]];
        // The lists of a system of all constraints.
        let [which, all_places] = [count, nodes].map(|n| (0..n as u32).collect::<Vec<_>>().into());
        Self {
            multiplier: numbers(),
            active: (0..changing).map(|_| AtomicBool::new(false)).collect(),
            tile_rows: (0..tiles).map(|_| AtomicU32::new(0)).collect(),
            tile_nodes: (0..tiles).map(|_| [const { AtomicU32::new(0) }; 2]).collect(),
            which,
            row_of: vec![0; changing].into(),
            node_of: vec![0; placed].into(),
            places: all_places,
            spans: (0..nodes).map(span).collect::<Vec<_>>().into(),
            entries: by_place.items[..2 * count].to_vec().into(),
            ends: list.ends[..count].to_vec().into(),
            rows: quads(count),
            scale: numbers(),
            offset: numbers(),
            right: numbers(),
            x: numbers(),
            r: numbers(),
            p: numbers(),
            s: numbers(),
            w: numbers(),
            row_forces: quads(count),
            response: quads(nodes),
            predicted: vec![PredictedContact::FREE; places].into(),
            collider: vec![0; places].into(),
            sums: Numbers::new(layout::most_chunks(list, bands)),
        }
    }
}

impl<T: Real> Feature<T> for Dual<T> {
    fn ops(&self) -> &'static [Op] {
        &[Op::Predict, Op::Solve, Op::ConstraintForces]
    }

    fn marks(&self, plan: &TilePlan) -> Marks {
        // With adaptive constraints, springs make the tile wait.
        let all = !self.adaptive && !self.list.bodies[plan.body].is_empty();
        if all { Marks::IMPLICIT.and(Marks::SOLVED) } else { Marks::NONE }
    }

    /// Where nodes are held, constraint forces go on to the solution from one sub-step to the next.
    fn lets_rest(&self) -> bool {
        false
    }

    fn begin(&self, worker: &mut Worker<'_, T>) {
        if self.adaptive {
            for tile in worker.tiles.clone() {
                // Constraints that were active in the last sub-step are checked again.
                let waits = self.work.tile_nodes[tile][0].load(Ordering::Relaxed) > 0;
                let marks = worker.marks[tile].get().without(Marks::SOLVED);
                worker.marks[tile].set(if waits { marks.and(Marks::SOLVED) } else { marks });
            }
        }
    }

    fn run(&self, _: Op, worker: &mut Worker<'_, T>) -> Flow {
        if !self.adaptive || worker.any_tile_has(Marks::SOLVED) {
            SolveWorker {
                solve: self,
                shared: &self.work,
                scratch: &mut self.scratch.of(worker.index),
                worker,
                colliders: self.colliders(worker.substep),
                mesh_cache: worker.features.get::<Colliders<T>>().map(|colliders| &colliders.cache),
            }
            .solve();
        }
        Flow::Go
    }

    fn tile(&self, op: Op, tile: &mut Tile<'_, T>) {
        if op == Op::Predict {
            waiting::suspend(tile);
        } else {
            waiting::resume(tile);
            self.add_constraint_forces(tile);
        }
    }

    fn measure(&mut self, _: [&[T]; 6], _: usize, sums: &mut FrameSums) {
        // All workers have the same report.
        for (index, scratch) in self.scratch.iter_mut().enumerate() {
            let report = std::mem::take(&mut scratch.report);
            if index == 0 {
                sums.solver = report;
            }
        }
    }

    /// Constraint forces, if the solver starts from them or predicts contacts with them; and which constraints are
    /// active, if they are adaptive.
    fn save(&self, state: &mut SolverState) {
        let asked = self.solver.ice.warm_start || self.surfaces;
        // SAFETY: no worker works between frames.
        let (listed, of_bands) = unsafe { (self.work.multiplier.read(), self.band_state.multipliers.read()) };
        state.warm_start.clear();
        for (rows, bands) in self.list.bodies.iter().zip(&self.bands).filter(|_| asked) {
            match bands {
                Some(bands) => {
                    state.warm_start.extend(bands.own_multipliers().map(|row| of_bands[row].to_f64()))
                }
                None => state.warm_start.extend(listed[rows.clone()].iter().map(|force| force.to_f64())),
            }
        }
        state.active = self.work.active.iter().map(|active| active.load(Ordering::Relaxed)).collect();
    }

    fn load(&mut self, state: &SolverState) {
        // A frame that was stopped has left its own.
        self.scratch.iter_mut().for_each(|scratch| scratch.report = SolverReport::default());
        let (listed, of_bands) = (self.work.multiplier.get_mut(), self.band_state.multipliers.get_mut());
        for (rows, bands) in self.list.bodies.iter().zip(&self.bands) {
            let saved = state.warm_start.get(rows.clone()).unwrap_or_default();
            let at = |i: usize| bands.as_ref().map_or(rows.start + i, |bands| bands.multiplier_of(i));
            let all = if bands.is_some() { &mut *of_bands } else { &mut *listed };
            saved.iter().enumerate().for_each(|(i, &from)| all[at(i)] = T::from_f64(from));
        }
        if self.adaptive {
            for (active, &from) in self.work.active.iter_mut().zip(&state.active) {
                *active.get_mut() = from;
            }
            self.recount(&state.active);
        }
    }

    fn bytes(&self) -> usize {
        let Self { work, list, by_place, .. } = self;
        let of_bands: usize = self.bands.iter().flatten().map(Bands::bytes).sum();
        // Ends, material and rest length, in 64 bits and in those of the simulation.
        let of_list =
            list.len() * (20 + size_of::<T>()) + 4 * (by_place.offsets.len() + by_place.items.len());
        // Numbers and quads of each row; its constraint, entries and ends.
        let of_rows = work.multiplier.len() * (9 * size_of::<T>() + 2 * size_of::<Quad<T>>() + 20);
        let of_nodes = work.places.len() * (12 + size_of::<Quad<T>>());
        let of_places = work.predicted.len() * (4 + size_of::<PredictedContact<T>>());
        of_bands + of_list + of_rows + of_nodes + of_places + 5 * work.active.len() + work.node_of.bytes()
    }
}

/// A worker's part of the solve.
struct SolveWorker<'w, 'a, T> {
    solve: &'w Dual<T>,
    shared: &'w Work<T>,
    scratch: &'w mut SolveScratch<T>,
    worker: &'w Worker<'a, T>,
    colliders: MetColliders<'w, T>,
    mesh_cache: Option<&'w MeshCache<T>>,
}
