//! The primal form on the CPU: an implicit step of all springs, solved for by nodes with conjugate gradients and multigrid.
//!
//! A level is a graph; its nodes are cut into chunks of one body each, which the workers share evenly. Sums are taken by
//! chunk in sixteen lanes, then chunk by chunk.

mod assembled;
mod coarse_contacts;
mod columns;
mod conjugate;
mod contacts;
mod couple;
mod cycle;
mod elements;
mod galerkin;
pub(crate) mod kernels;
mod newton;
mod second_order;
mod setup;
mod sewn;
mod tables;
mod tile;

use crate::assembly::Assembly;
use crate::backend::SolverState;
use crate::contact::collider_mesh::cache::MeshCache;
use crate::contact::colliders::cpu::Colliders;
use crate::contact::colliders::met::MetColliders;
use crate::contact::colliders::predicted_contact::PredictedContact;
use crate::contact::triangles::cpu::TriangleContact;
use crate::cpu::backend::Context;
use crate::cpu::cells::PerWorker;
use crate::cpu::column::Column;
use crate::cpu::feature::{Feature, Flow};
use crate::cpu::numbers::Numbers;
use crate::cpu::shared::Shared;
use crate::cpu::tile::Tile;
use crate::cpu::tiles::TilePlan;
use crate::cpu::worker::Worker;
use crate::plan::Substep;
use crate::real::Real;
use crate::report::{FrameSums, SolverReport};
use crate::scene::Ice;
use crate::solvers::implicit::implicit::Stiff;
use crate::solvers::implicit::levels::Level;
use crate::solvers::implicit::scheme::Scheme;
use crate::solvers::implicit::sewn::{Matrix, SewnPoints};
use crate::solvers::implicit::slots::NO_EDGE;
use crate::solvers::waiting;
use crate::step::{Marks, Op};
use crate::topology::LANES;
use coarse_contacts::CoarseContacts;
use columns::Columns;
use contacts::{Joined, Places};
use elements::ElementBlocks;
use kernels::{COARSE, FINE};
use std::ops::Range;
use tables::Table;

/// Springs that are integrated implicitly.
pub struct Implicit<T> {
    multigrid: Multigrid<T>,
    /// The same once all seams are closed, where that makes a difference.
    sewn_multigrid: Option<Multigrid<T>>,
    /// By slot of the finest level: rest length [m], and which material.
    rest: Vec<T>,
    material: Vec<u32>,
    /// Stiffness [N/m] and damping [kg/s]; the first is nothing.
    materials: Vec<[f64; 2]>,
    ice: Ice,
    /// Whether surfaces hold nodes while springs are solved for.
    surfaces: bool,
    scratch: PerWorker<Scratch<T>>,
    work: Work<T>,
    places: Places,
    /// Contacts of surfaces on coarser levels.
    coarse_contacts: Vec<CoarseContacts<T>>,
    /// Nodes that seams make one point of, once they are closed.
    sewn: Option<SewnPoints>,
}

/// Levels.
struct Multigrid<T> {
    /// The finest first.
    tables: Vec<Table<T>>,
    /// Other elements that are solved for.
    elements: Option<ElementBlocks<T>>,
    /// Whether seams join bodies on coarser levels.
    is_sewn: bool,
}

/// A level's vectors and matrix.
struct LevelWork<T> {
    blocks: Shared<T>,
    /// On the diagonal beside edges, and the inverse of the whole diagonal block.
    own: Columns<T>,
    inverse: Columns<T>,
    /// Right side, and two approximations of the solution by turns.
    r: Columns<T>,
    z: Columns<T>,
    t: Columns<T>,
}

/// What changes; of it `change` is kept from one sub-step to the next.
struct Work<T> {
    levels: Vec<LevelWork<T>>,
    /// What springs change of each node's velocity [m/s].
    change: Columns<T>,
    /// What is changed of the velocity without springs so far, and in this Newton step; direction and its product.
    total: Columns<T>,
    x: Columns<T>,
    p: Columns<T>,
    s: Columns<T>,
    /// Springs' impulse where a Newton step starts, and with what it changes on nodes that something holds [N s].
    right: Columns<T>,
    impulse: Columns<T>,
    /// Of second order.
    history: Option<History<T>>,
    /// Positions and velocities that a Newton step starts from.
    moved: Columns<T>,
    /// By place: how a surface holds it, and which. Empty where there are none.
    predicted: Shared<PredictedContact<T>>,
    collider: Shared<u32>,
    /// By chunk: Σ m |v* − v|², Σ m |v|², Σ m v and Σ m; r·z and z·A z.
    outer: Numbers<6>,
    products: Numbers<2>,
    /// By chunk: what is left of momentum, mass, and how many nodes are held.
    residual: Numbers<5>,
    /// By node of points that seams make: the weight of the nodes before it.
    weights: Shared<Matrix<T>>,
}

/// What steps of second order have beside; of it `rate` is kept from one sub-step to the next.
struct History<T> {
    /// Acceleration of each place [m/s²].
    rate: Columns<T>,
    /// Where a place without velocity after the sub-step would be [m], and the velocity without springs [m/s].
    base: Columns<T>,
    /// Masses of the system [kg].
    mass: Shared<T>,
}

/// What a worker keeps.
#[derive(Default)]
struct Scratch<T> {
    /// Materials over this sub-step.
    stiff: Vec<Stiff<T>>,
    /// How far each body's system is.
    bodies: Vec<conjugate::CgState>,
    joined: Joined,
    /// Of each: Σ m |v* − v|², Σ m |v|², Σ m v and Σ m.
    outer: Vec<[f64; 6]>,
    /// What the frame's report is to say.
    report: SolverReport,
}

impl<T: Real> Implicit<T> {
    /// Of a scene whose springs are solved for by nodes.
    pub fn new(context: &mut Context<'_, T>) -> Option<Self> {
        let (workers, assembly) = (context.workers(), &mut *context.assembly);
        if !assembly.solver.is_primal()
            || !(0..assembly.bodies.len()).any(|body| assembly.is_solved_for(body))
        {
            return None;
        }
        let sewn = assembly.sewn_points();
        let multigrid = Multigrid::new(assembly, assembly.levels(), false);
        let sewn_multigrid = sewn.as_ref().and_then(|sewn| assembly.sewn_levels(sewn));
        let sewn_multigrid = sewn_multigrid.map(|levels| Multigrid::new(assembly, &levels, true));
        assembly.forget_levels();
        let tables = &multigrid.tables;
        let list = assembly.take_constraints();
        let edges = &tables[0].slots.edge;
        let of = |&edge: &u32| (edge != NO_EDGE).then_some(edge as usize);
        let surfaces = !assembly.colliders().is_empty();
        let sewn_nodes = sewn.as_ref().map_or(0, |all| all.nodes.items.len());
        let coarser = if assembly.surfaces().is_some() { &tables[1..] } else { &[] };
        Some(Self {
            rest: edges
                .iter()
                .map(|edge| of(edge).map_or(T::ZERO, |one| T::from_f64(list.rest[one])))
                .collect(),
            material: edges.iter().map(|edge| of(edge).map_or(0, |one| list.material[one] + 1)).collect(),
            materials: [[0.0; 2]].into_iter().chain(list.materials).collect(),
            ice: assembly.solver.ice.clone(),
            surfaces,
            scratch: PerWorker::new(workers, |_| Scratch::default()),
            work: Work::new(tables, (surfaces, assembly.solver.is_second_order()), sewn_nodes),
            places: Places::new(&tables[0], workers),
            coarse_contacts: coarser.iter().map(|table| CoarseContacts::new(table, workers)).collect(),
            multigrid,
            sewn_multigrid,
            sewn,
        })
    }

    /// Colliders that hold nodes while springs are solved for.
    fn colliders<'s>(&self, substep: &'s Substep<T>) -> MetColliders<'s, T> {
        if self.surfaces { substep.met_colliders() } else { MetColliders::NONE }
    }
}

impl<T: Real> Multigrid<T> {
    fn new(assembly: &Assembly, levels: &[Level], is_sewn: bool) -> Self {
        let tables = Table::all(assembly, levels);
        Self { elements: ElementBlocks::new(assembly, levels, &tables), tables, is_sewn }
    }

    /// Other elements, where a body has some.
    fn elements_of(&self, body: usize) -> Option<&ElementBlocks<T>> {
        self.elements.as_ref().filter(|elements| elements.has(body))
    }

    fn bytes(&self) -> usize {
        let tables: usize = self.tables.iter().map(Table::bytes).sum();
        tables + self.elements.as_ref().map_or(0, ElementBlocks::bytes)
    }
}

impl<T: Real> LevelWork<T> {
    fn new(table: &Table<T>, numbers: usize) -> Self {
        let columns = |axes| Columns::new(axes, table.places);
        Self {
            blocks: Column::zeros(table.count() * numbers).into(),
            own: columns(6),
            inverse: columns(6),
            r: columns(3),
            z: columns(3),
            t: columns(3),
        }
    }

    fn bytes(&self) -> usize {
        let columns = [&self.own, &self.inverse, &self.r, &self.z, &self.t];
        self.blocks.bytes() + columns.into_iter().map(Columns::bytes).sum::<usize>()
    }
}

impl<T: Real> Work<T> {
    /// Room for the system on all levels.
    fn new(tables: &[Table<T>], (surfaces, second_order): (bool, bool), sewn: usize) -> Self {
        let (places, chunks) = (tables[0].places, tables[0].chunks.len());
        let held = if surfaces { places } else { 0 };
        let columns = |axes| Columns::new(axes, places);
        let numbers = |level| if level == 0 { FINE } else { COARSE };
        Self {
            levels: (0..).zip(tables).map(|(level, table)| LevelWork::new(table, numbers(level))).collect(),
            change: columns(3),
            total: columns(3),
            x: columns(3),
            p: columns(3),
            s: columns(3),
            right: columns(3),
            impulse: columns(3),
            history: second_order.then(|| History {
                rate: columns(3),
                base: columns(6),
                mass: Column::zeros(places + LANES).into(),
            }),
            moved: columns(6),
            predicted: vec![PredictedContact::FREE; held].into(),
            collider: vec![0; held].into(),
            outer: Numbers::new(chunks),
            products: Numbers::new(chunks),
            residual: Numbers::new(chunks),
            weights: vec![Matrix::default(); sewn].into(),
        }
    }

    fn bytes(&self) -> usize {
        let columns =
            [&self.change, &self.total, &self.x, &self.p, &self.s, &self.right, &self.impulse, &self.moved];
        let history = |all: &History<T>| all.rate.bytes() + all.base.bytes() + all.mass.bytes();
        self.levels.iter().map(LevelWork::bytes).sum::<usize>()
            + columns.into_iter().map(Columns::bytes).sum::<usize>()
            + self.history.as_ref().map_or(0, history)
            + self.predicted.len() * (size_of::<PredictedContact<T>>() + 4)
            + self.weights.bytes()
    }
}

impl<T: Real> Feature<T> for Implicit<T> {
    fn ops(&self) -> &'static [Op] {
        &[Op::Predict, Op::Solve, Op::ConstraintForces, Op::Integrate]
    }

    fn marks(&self, plan: &TilePlan) -> Marks {
        let acts = !self.multigrid.tables[0].bodies[plan.body].is_empty();
        if acts { Marks::IMPLICIT.and(Marks::SOLVED) } else { Marks::NONE }
    }

    fn run(&self, _: Op, worker: &mut Worker<'_, T>) -> Flow {
        let is_sewn = worker.substep.is_sewn();
        ImplicitWorker {
            primal: self,
            multigrid: self.sewn_multigrid.as_ref().filter(|_| is_sewn).unwrap_or(&self.multigrid),
            shared: &self.work,
            scratch: &mut self.scratch.of(worker.index),
            alone: worker.workers == 1,
            worker,
            h: worker.substep.scheme().map_or(worker.substep.h, |scheme| scheme.h),
            second: self.work.history.as_ref().zip(worker.substep.scheme()),
            colliders: self.colliders(worker.substep),
            contacts: worker.features.get(),
            sewn: self.sewn.as_ref().filter(|_| is_sewn),
            mesh_cache: worker.features.get::<Colliders<T>>().map(|colliders| &colliders.cache),
        }
        .solve();
        Flow::Go
    }

    fn tile(&self, op: Op, tile: &mut Tile<'_, T>) {
        match op {
            Op::Predict => waiting::suspend(tile),
            Op::Integrate => self.place_nodes(tile),
            _ => {
                waiting::resume(tile);
                self.add_changes(tile);
            }
        }
    }

    fn measure(&mut self, _: [&[T]; 6], _: usize, sums: &mut FrameSums) {
        // All workers know it.
        for (index, scratch) in self.scratch.iter_mut().enumerate() {
            let report = std::mem::take(&mut scratch.report);
            if index == 0 {
                sums.solver = report;
            }
        }
    }

    /// What springs changed of each place's velocity [m/s], if the solver starts from it or surfaces ask for it; then the
    /// accelerations of second order [m/s²].
    fn save(&self, state: &mut SolverState) {
        let asked = self.ice.warm_start || self.surfaces;
        let kept = asked.then_some(&self.work.change).into_iter();
        for columns in kept.chain(self.work.history.as_ref().map(|history| &history.rate)) {
            // SAFETY: no worker works between frames.
            let numbers = unsafe { columns.read() };
            let of = |place| numbers.at::<3>(place).map(T::to_f64);
            state.warm_start.extend((0..self.multigrid.tables[0].places).flat_map(of));
        }
    }

    fn load(&mut self, state: &SolverState) {
        // A frame that was stopped has left its own.
        self.scratch.iter_mut().for_each(|scratch| scratch.report = SolverReport::default());
        let asked = self.ice.warm_start || self.surfaces;
        let kept = asked.then_some(&mut self.work.change).into_iter();
        let all = kept.chain(self.work.history.as_mut().map(|history| &mut history.rate));
        let places = self.multigrid.tables[0].places.max(1);
        for (columns, saved) in all.zip(state.warm_start.as_chunks::<3>().0.chunks(places)) {
            for (place, numbers) in saved.iter().enumerate() {
                for (axis, &number) in numbers.iter().enumerate() {
                    columns.set(axis, place, T::from_f64(number));
                }
            }
        }
    }

    fn redistribute(&mut self, _: &Assembly, _: &[TilePlan], chunks: &[Range<usize>]) {
        let workers = chunks.len();
        if workers != self.places.workers() {
            self.places = Places::new(&self.multigrid.tables[0], workers);
            self.coarse_contacts.iter_mut().for_each(|coarse| coarse.share(workers));
        }
    }

    /// Velocity changes are by the length of the step.
    fn rescale(&mut self, by: f64) {
        self.work.change.scale(T::from_f64(by));
    }

    /// A node that is set, pinned or freed has no acceleration yet.
    fn forget(&mut self, node: usize) {
        if let Some(history) = &mut self.work.history {
            (0..3).for_each(|axis| history.rate.set(axis, node, T::ZERO));
        }
    }

    fn bytes(&self) -> usize {
        let contacts: usize = self.coarse_contacts.iter().map(CoarseContacts::bytes).sum();
        self.multigrid.bytes()
            + self.sewn_multigrid.as_ref().map_or(0, Multigrid::bytes)
            + self.rest.len() * (size_of::<T>() + 4)
            + self.work.bytes()
            + self.places.bytes()
            + contacts
    }
}

/// A worker's part in the solution.
struct ImplicitWorker<'w, 'a, T> {
    primal: &'w Implicit<T>,
    multigrid: &'w Multigrid<T>,
    shared: &'w Work<T>,
    scratch: &'w mut Scratch<T>,
    /// Whether it goes on without the others.
    alone: bool,
    worker: &'w Worker<'a, T>,
    /// Step of the system [s].
    h: T,
    /// Of a step of second order.
    second: Option<(&'w History<T>, &'w Scheme<T>)>,
    colliders: MetColliders<'w, T>,
    mesh_cache: Option<&'w MeshCache<T>>,
    /// Contacts of surfaces.
    contacts: Option<&'w TriangleContact<T>>,
    /// Nodes that are sewn to each other in this sub-step.
    sewn: Option<&'w SewnPoints>,
}
