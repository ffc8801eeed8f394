//! The primal form on the CPU: an implicit step of all springs, solved for by nodes with conjugate gradients and multigrid.
//!
//! A level is a graph; its nodes are cut into chunks of one body each, which the workers share evenly. Sums are taken by
//! chunk in sixteen lanes, then chunk by chunk.

mod columns;
mod conjugate;
mod cycle;
mod kernels;
mod setup;
mod tables;
mod tile;

use crate::backend::SolverState;
use crate::build::Assembly;
use crate::contact::collider_mesh::cache::Near;
use crate::contact::colliders::moving::ColliderNow;
use crate::contact::colliders::press::Press;
use crate::cpu::backend::Setup;
use crate::cpu::column::Column;
use crate::cpu::shared::Shared;
use crate::cpu::team::Barrier;
use crate::diagnostics::SolverReport;
use crate::plan::Substep;
use crate::real::Real;
use crate::scene::Ice;
use crate::solvers::implicit::implicit::Stiff;
use crate::solvers::implicit::slots::NO_EDGE;
use columns::{Columns, SharedColumns};
use kernels::{COARSE, FINE};
use tables::Table;

/// What does not change.
pub struct PrimalSetup<T> {
    tables: Vec<Table<T>>,
    /// By slot of the finest level: rest length [m], and which material.
    rest: Vec<T>,
    material: Vec<u32>,
    /// Stiffness [N/m] and damping [kg/s]; the first is nothing.
    materials: Vec<[f64; 2]>,
    ice: Ice,
    /// Whether surfaces hold nodes while springs are solved for.
    surfaces: bool,
}

/// A level's vectors and matrix.
struct LevelWork<T> {
    blocks: Column<T>,
    /// On the diagonal beside edges, and the inverse of the whole diagonal block.
    own: Columns<T>,
    inverse: Columns<T>,
    /// Right side, and two approximations of the solution by turns.
    r: Columns<T>,
    z: Columns<T>,
    t: Columns<T>,
}

struct SharedLevel<'a, T> {
    blocks: Shared<'a, T>,
    own: SharedColumns<'a, T>,
    inverse: SharedColumns<'a, T>,
    r: SharedColumns<'a, T>,
    z: SharedColumns<'a, T>,
    t: SharedColumns<'a, T>,
}

/// What changes; of it `change` is remembered from one sub-step to the next.
pub struct PrimalWork<T> {
    levels: Vec<LevelWork<T>>,
    /// What springs change of each node's velocity [m/s].
    change: Columns<T>,
    /// What is changed of the velocity without springs so far, and in this Newton step; direction and its product.
    total: Columns<T>,
    x: Columns<T>,
    p: Columns<T>,
    s: Columns<T>,
    /// Springs' impulse where a Newton step starts [N s].
    right: Columns<T>,
    /// Places and velocities that a Newton step starts from.
    moved: Columns<T>,
    /// By place: how a surface holds it, and which. Empty where there are none.
    press: Vec<Press<T>>,
    surface: Vec<u32>,
    /// By chunk: Σ m |v* − v|²; r·z and z·A z.
    outer: Vec<f64>,
    products: Vec<[f64; 2]>,
    /// By chunk: what is left of momentum, mass, and how many nodes are held.
    left: Vec<[f64; 5]>,
}

/// The same, lent to all workers.
pub struct SharedPrimal<'a, T> {
    levels: Vec<SharedLevel<'a, T>>,
    change: SharedColumns<'a, T>,
    total: SharedColumns<'a, T>,
    x: SharedColumns<'a, T>,
    p: SharedColumns<'a, T>,
    s: SharedColumns<'a, T>,
    right: SharedColumns<'a, T>,
    moved: SharedColumns<'a, T>,
    press: Shared<'a, Press<T>>,
    surface: Shared<'a, u32>,
    outer: Shared<'a, f64>,
    products: Shared<'a, [f64; 2]>,
    left: Shared<'a, [f64; 5]>,
}

/// What a worker keeps.
#[derive(Default)]
pub struct PrimalScratch<T> {
    /// Materials over this sub-step.
    stiff: Vec<Stiff<T>>,
    /// How far each body's system is.
    bodies: Vec<conjugate::Progress>,
    /// What the frame's report is to say.
    pub report: SolverReport,
}

impl<T: Real> PrimalSetup<T> {
    /// Of a scene whose springs are solved for by nodes.
    pub fn new(assembly: &mut Assembly) -> Option<Self> {
        if !assembly.solver.is_primal() || assembly.constraints.is_empty() {
            return None;
        }
        let tables = Table::all(assembly);
        assembly.levels = Vec::new();
        let list = std::mem::take(&mut assembly.constraints);
        let edges = &tables[0].slots.edge;
        let of = |&edge: &u32| (edge != NO_EDGE).then_some(edge as usize);
        Some(Self {
            rest: edges
                .iter()
                .map(|edge| of(edge).map_or(T::ZERO, |one| T::from_f64(list.rest[one])))
                .collect(),
            material: edges.iter().map(|edge| of(edge).map_or(0, |one| list.material[one] + 1)).collect(),
            materials: [[0.0; 2]].into_iter().chain(list.materials).collect(),
            ice: assembly.solver.ice.clone(),
            surfaces: !assembly.colliders.is_empty(),
            tables,
        })
    }

    /// Whether springs of a body are solved for.
    pub fn acts_on(&self, body: usize) -> bool {
        !self.tables[0].bodies[body].is_empty()
    }

    /// Colliders that hold nodes while springs are solved for.
    pub fn colliders<'s>(&self, substep: &'s Substep<T>) -> &'s [ColliderNow<T>] {
        if self.surfaces { &substep.colliders } else { &[] }
    }

    /// Bytes that its tables take.
    pub fn bytes(&self) -> usize {
        let tables: usize = self.tables.iter().map(Table::bytes).sum();
        tables + self.rest.len() * (size_of::<T>() + 4)
    }
}

impl<T: Real> LevelWork<T> {
    fn new(table: &Table<T>, numbers: usize) -> Self {
        let columns = |axes| Columns::new(axes, table.places, table.margin);
        Self {
            blocks: Column::zeros(table.count() * numbers),
            own: columns(6),
            inverse: columns(6),
            r: columns(3),
            z: columns(3),
            t: columns(3),
        }
    }

    fn share(&mut self) -> SharedLevel<'_, T> {
        SharedLevel {
            blocks: Shared::new(&mut self.blocks),
            own: self.own.share(),
            inverse: self.inverse.share(),
            r: self.r.share(),
            z: self.z.share(),
            t: self.t.share(),
        }
    }

    fn bytes(&self) -> usize {
        let columns = [&self.own, &self.inverse, &self.r, &self.z, &self.t];
        self.blocks.len() * size_of::<T>() + columns.into_iter().map(Columns::bytes).sum::<usize>()
    }
}

impl<T: Real> PrimalWork<T> {
    /// Room for a scene.
    pub fn new(setup: Option<&PrimalSetup<T>>) -> Self {
        let finest = setup.map(|setup| &setup.tables[0]);
        let (places, margin) = finest.map_or((0, 0), |table| (table.places, table.margin));
        let chunks = finest.map_or(0, |table| table.chunks.len());
        let surfaces = setup.is_some_and(|setup| setup.surfaces);
        let columns = |axes| Columns::new(axes, places, margin);
        Self {
            levels: setup
                .iter()
                .flat_map(|setup| setup.tables.iter().enumerate())
                .map(|(level, table)| LevelWork::new(table, if level == 0 { FINE } else { COARSE }))
                .collect(),
            change: columns(3),
            total: columns(3),
            x: columns(3),
            p: columns(3),
            s: columns(3),
            right: columns(3),
            moved: Columns::new(6, places, 0),
            press: vec![Press::FREE; if surfaces { places } else { 0 }],
            surface: vec![0; if surfaces { places } else { 0 }],
            outer: vec![0.0; chunks],
            products: vec![[0.0; 2]; chunks],
            left: vec![[0.0; 5]; chunks],
        }
    }

    /// Lends it to all workers.
    pub fn share(&mut self) -> SharedPrimal<'_, T> {
        SharedPrimal {
            levels: self.levels.iter_mut().map(LevelWork::share).collect(),
            change: self.change.share(),
            total: self.total.share(),
            x: self.x.share(),
            p: self.p.share(),
            s: self.s.share(),
            right: self.right.share(),
            moved: self.moved.share(),
            press: Shared::new(&mut self.press),
            surface: Shared::new(&mut self.surface),
            outer: Shared::new(&mut self.outer),
            products: Shared::new(&mut self.products),
            left: Shared::new(&mut self.left),
        }
    }

    /// What springs changed of each place's velocity [m/s], if the solver starts from it or surfaces ask for it.
    pub fn solver_state(&self, setup: &PrimalSetup<T>) -> SolverState {
        let asked = setup.ice.warm_start || setup.surfaces;
        let places = if asked { setup.tables[0].places } else { 0 };
        let mut pulls = Vec::with_capacity(3 * places);
        for place in 0..places {
            pulls.extend((0..3).map(|axis| self.change.get(axis, place).to_f64()));
        }
        SolverState { pulls, ..SolverState::default() }
    }

    /// Takes back what [`Self::remembered`] gave.
    pub fn set_solver_state(&mut self, from: &SolverState) {
        for (place, change) in from.pulls.as_chunks::<3>().0.iter().enumerate() {
            for (axis, &number) in change.iter().enumerate() {
                self.change.set(axis, place, T::from_f64(number));
            }
        }
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        let columns = [&self.change, &self.total, &self.x, &self.p, &self.s, &self.right, &self.moved];
        self.levels.iter().map(LevelWork::bytes).sum::<usize>()
            + columns.into_iter().map(Columns::bytes).sum::<usize>()
            + self.press.len() * (size_of::<Press<T>>() + 4)
    }
}

/// A worker's part in the solution.
pub struct PrimalWorker<'w, 'a, T> {
    /// What does not change.
    pub setup: &'w Setup<T>,
    pub primal: &'w PrimalSetup<T>,
    pub shared: &'w SharedPrimal<'a, T>,
    pub scratch: &'w mut PrimalScratch<T>,
    /// Which worker of how many; whether it goes on without the others.
    pub index: usize,
    pub workers: usize,
    pub alone: bool,
    pub barrier: &'w Barrier,
    /// State before, and what waits where the state after will be.
    pub old: [&'w [T]; 6],
    pub next: &'w [Shared<'a, T>; 6],
    /// Step [s].
    pub h: T,
    pub colliders: &'w [ColliderNow<T>],
    pub near: Near<'w, T>,
}
