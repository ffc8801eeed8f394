//! Position constraints on the CPU.
//!
//! A small body is solved by one worker alone, and so are small levels of larger ones; of larger ones all workers have a part of each
//! colour. No bit depends on that, as constraints of a colour share no node.

mod grid;
mod kernels;
mod level;
mod lists;
mod solver;

use crate::cpu::backend::Context;
use crate::cpu::cells::PerWorker;
use crate::cpu::feature::{Feature, Flow};
use crate::cpu::shared::Shared;
use crate::cpu::tile::{Moved, Tile};
use crate::cpu::tiles::TilePlan;
use crate::cpu::worker::Worker;
use crate::real::Real;
use crate::solvers::xpbd::levels::BodyConstraints;
use crate::step::{Marks, Op};
use grid::GridBody;
use lists::ListBody;
use solver::{BodySolver, own};
use std::ops::Range;

/// Nodes up to which a body or level is solved by one worker: others would wait longer for it than it takes.
const ALONE: usize = 4096;

/// Springs that are constraints on positions.
pub struct PositionConstraints<T> {
    /// By body of the scene; none of one without springs.
    bodies: Vec<Option<Body<T>>>,
    /// Positions of nodes before constraints act [m], by place.
    before: [Shared<T>; 3],
    /// Times that springs act in a sub-step.
    sweeps: usize,
    /// A row of a grid, of each worker.
    rows: PerWorker<Vec<T>>,
}

/// A body.
struct Body<T> {
    /// Its places.
    places: Range<usize>,
    form: Form<T>,
}

enum Form<T> {
    Grid(GridBody<T>),
    Lists(ListBody<T>),
}

impl<T: Real> PositionConstraints<T> {
    /// Those of a scene, if it has some.
    pub fn new(context: &mut Context<'_, T>) -> Option<Self> {
        let all = context.assembly.take_position_constraints();
        let assembly = &*context.assembly;
        let body = |(index, constraints): (usize, Option<BodyConstraints>)| {
            let body = &assembly.bodies[index];
            let form = match constraints? {
                BodyConstraints::Grid { springs, levels } => {
                    Form::Grid(GridBody::new(&springs, &levels, &body.mass))
                }
                BodyConstraints::Mesh(lists) => Form::Lists(ListBody::new(&lists, &body.mass)),
            };
            Some(Body { places: body.solver_range(), form })
        };
        let bodies: Vec<_> = all.into_iter().enumerate().map(body).collect();
        let columns = || Shared::from(vec![T::ZERO; assembly.places]);
        bodies.iter().any(Option::is_some).then(|| Self {
            bodies,
            before: [(); 3].map(|()| columns()),
            sweeps: assembly.solver.xpbd.sweeps as usize,
            rows: PerWorker::new(context.chunks.len(), |_| Vec::new()),
        })
    }
}

impl<T: Real> BodySolver<'_, '_, T> {
    fn solve(&self, body: &Body<T>) {
        self.keep(&body.places);
        match &body.form {
            Form::Grid(grid) => self.solve_grid(grid, &body.places),
            Form::Lists(lists) => self.solve_lists(lists, &body.places),
        }
    }
}

impl<T: Real> Feature<T> for PositionConstraints<T> {
    fn ops(&self) -> &'static [Op] {
        &[Op::PositionConstraints, Op::ApplyPositions]
    }

    fn marks(&self, plan: &TilePlan) -> Marks {
        if self.bodies[plan.body].is_some() { Marks::IMPLICIT } else { Marks::NONE }
    }

    fn run(&self, _: Op, worker: &mut Worker<'_, T>) -> Flow {
        let awake = |body: usize| !worker.resting.has(body);
        let bodies = || {
            let all = self.bodies.iter().enumerate().filter(|(body, _)| awake(*body));
            all.filter_map(|(_, one)| one.as_ref())
        };
        for (number, body) in bodies().filter(|body| body.places.len() <= ALONE).enumerate() {
            if number % worker.workers == worker.index {
                BodySolver { all: self, worker, is_alone: true }.solve(body);
            }
        }
        for body in bodies().filter(|body| body.places.len() > ALONE) {
            BodySolver { all: self, worker, is_alone: worker.workers == 1 }.solve(body);
        }
        worker.mark_moved(|tile| {
            let body = worker.nodes.tiles[tile].body;
            awake(body) && self.bodies[body].is_some()
        });
        Flow::Go
    }

    /// Velocities from how far nodes have gone.
    fn tile(&self, _: Op, tile: &mut Tile<'_, T>) {
        let h = tile.substep.h;
        for (at, run) in tile.plan.runs() {
            let [x, y, z, u, v, w] = tile.after(&run);
            for (axis, (position, velocity)) in [(x, u), (y, v), (z, w)].into_iter().enumerate() {
                let before = &*own(&self.before[axis], run.clone());
                for ((velocity, &after), &before) in velocity.iter_mut().zip(&*position).zip(before) {
                    *velocity += (after - before) / h;
                }
                if tile.has_contact() {
                    tile.scratch.before[axis][at..at + run.len()].copy_from_slice(before);
                }
            }
        }
        tile.moved = Moved::Any;
    }

    fn bytes(&self) -> usize {
        let of_body = |body: &Body<T>| match &body.form {
            Form::Grid(grid) => grid.bytes(),
            Form::Lists(lists) => lists.bytes(),
        };
        let before: usize = self.before.iter().map(Shared::bytes).sum();
        before + self.bodies.iter().flatten().map(of_body).sum::<usize>()
    }
}

#[cfg(test)]
mod tests {
    use crate::assembly::Assembly;
    use crate::backend::{Backend as _, FrameInput};
    use crate::cpu::team::Team;
    use crate::features;
    use crate::scene::{Body, Mass, Mesh, Method, Scene, Select};
    use crate::solvers::xpbd::levels::{BodyConstraints, Constraints};

    /// Positions after some frames, of a grid as it is, or by lists.
    fn after(layout: [u32; 2], by_lists: bool) -> Vec<[f64; 3]> {
        let [rows, cols] = layout;
        let size = [0.1 * f64::from(cols - 1), 0.1 * f64::from(rows - 1)];
        let sheet = Body::cloth("sheet", Mesh::grid(rows, cols, size)).with_mass(Mass::Area(0.2));
        let sheet = sheet.structural(500.0, 0.01).shear(80.0, 0.0).bend(20.0, 0.02);
        let sheet = sheet.pin(Select::nodes([0, cols + 1, 2 * cols - 1]));
        let scene = Scene::new("").time(0.02, 0.005).method(Method::Xpbd).body(sheet);
        let mut assembly = Assembly::new(&scene).unwrap();
        if by_lists {
            let all = std::mem::take(&mut assembly.extensions.get_mut::<Constraints>().0);
            let by_lists = |(one, body): (Option<BodyConstraints>, _)| {
                one.map(|one| BodyConstraints::Mesh(one.into_lists(body)))
            };
            let all = all.into_iter().zip(&assembly.bodies).map(by_lists).collect();
            assembly.extensions.get_mut::<Constraints>().0 = all;
        }
        let mut backend = features::on_cpu::<f64>(assembly, Team::new(1)).unwrap();
        for frame in 0..20 {
            backend.frame(0.02 * f64::from(frame), FrameInput::default()).unwrap();
        }
        (0..(rows * cols) as usize).map(|node| backend.position(node)).collect()
    }

    #[test]
    fn grids_move_by_rows_as_by_lists() {
        for layout in [[7, 9], [12, 40], [5, 37], [4, 2], [21, 18], [2, 2], [4, 4], [3, 5]] {
            let (rows, lists) = (after(layout, false), after(layout, true));
            let moved =
                rows.iter().zip(&lists).flat_map(|(a, b)| [0, 1, 2].map(|axis| (a[axis] - b[axis]).abs()));
            assert!(moved.fold(0.0, f64::max) < 1e-9, "{layout:?}");
        }
    }
}
