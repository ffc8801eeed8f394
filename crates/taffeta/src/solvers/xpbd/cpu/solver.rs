//! A worker that solves a body, alone or as one of all, and the levels that it works on.

use crate::cpu::shared::Shared;
use crate::cpu::worker::Worker;
use crate::real::Real;
use crate::solvers::xpbd::cpu::grid::{Acting, GridBody, Pass, Prolongate, Restrict, Sweep, holder};
use crate::solvers::xpbd::cpu::kernels::Nodes;
use crate::solvers::xpbd::cpu::level::{FREE, LevelNodes};
use crate::solvers::xpbd::cpu::lists::{ActLists, ListBody};
use crate::solvers::xpbd::cpu::{ALONE, PositionConstraints};
use crate::solvers::xpbd::levels::sweeps;
use crate::solvers::xpbd::project::Stiffness;
use std::ops::Range;

/// A part of an array that this worker alone has until the next barrier.
#[expect(clippy::mut_from_ref, reason = "as of `Shared::write`")]
pub fn own<T>(shared: &Shared<T>, part: Range<usize>) -> &mut [T] {
    // SAFETY: workers have disjoint parts of bodies and levels: whole ones, or even parts of what one pass moves. Nobody reads a part
    // before a barrier that another worker has written, and callers keep none of it.
    unsafe { shared.write(part) }
}

/// What others have written before a barrier, and write again only after another.
fn read<T>(shared: &Shared<T>) -> &[T] {
    // SAFETY: as above.
    unsafe { shared.read() }
}

/// The nodes of a body, or of one of its coarser levels.
struct Level<'s, T> {
    position: [&'s Shared<T>; 3],
    /// The first of them in these columns, and their number.
    first: usize,
    count: usize,
    /// By node.
    inverse_mass: &'s [T],
    mass: &'s [T],
    /// Positions at rest [m], of a grid with coarser levels.
    rest: [&'s [T]; 3],
}

impl<'s, T: Real> Level<'s, T> {
    fn of_body(worker: &'s Worker<'_, T>, places: &Range<usize>, rest: [&'s [T]; 3]) -> Self {
        let [x, y, z, ..] = worker.next();
        Self {
            position: [x, y, z],
            first: places.start,
            count: places.len(),
            inverse_mass: &worker.nodes.inverse_mass[places.clone()],
            mass: &worker.nodes.mass[places.clone()],
            rest,
        }
    }

    fn of(nodes: &'s LevelNodes<T>) -> Self {
        Self {
            position: nodes.position.each_ref(),
            first: 0,
            count: nodes.len(),
            inverse_mass: read(&nodes.inverse_mass),
            mass: &nodes.mass,
            rest: nodes.rest.each_ref().map(read),
        }
    }

    /// Where they are, written before a barrier.
    fn positions(&self) -> [&'s [T]; 3] {
        // SAFETY: as of `own`; of the column only this body or level is read.
        self.position.map(|column| unsafe { column.read_part(self.first..self.first + self.count) })
    }

    /// Where some of them are, to move them.
    fn own(&self, part: Range<usize>) -> [&'s mut [T]; 3] {
        self.position.map(|column| own(column, self.first + part.start..self.first + part.end))
    }
}

/// A worker that solves a body, alone or as one of all.
pub struct BodySolver<'w, 'a, T> {
    pub all: &'w PositionConstraints<T>,
    pub worker: &'w Worker<'a, T>,
    pub is_alone: bool,
}

impl<T: Real> BodySolver<'_, '_, T> {
    /// Its part of so many things.
    fn part(&self, count: usize) -> Range<usize> {
        if self.is_alone { 0..count } else { self.worker.part(count) }
    }

    /// Waits for those that it shares the body with.
    fn wait(&self) {
        if !self.is_alone {
            self.worker.synchronise();
        }
    }

    /// Does what is small alone, while the others wait.
    fn together(&self, nodes: usize, work: impl FnOnce(&Self)) {
        if self.is_alone || nodes > ALONE {
            work(self);
        } else {
            if self.worker.index == 0 {
                work(&Self { is_alone: true, ..*self });
            }
            self.worker.synchronise();
        }
    }

    /// Whether this is the first sub-step of its frame, in which is found what holds nodes of levels.
    fn is_first(&self) -> bool {
        self.worker.done == 0
    }

    /// Keeps where nodes are before constraints act.
    pub fn keep(&self, places: &Range<usize>) {
        let part = self.part(places.len());
        let part = places.start + part.start..places.start + part.end;
        for (before, now) in self.all.before.iter().zip(self.worker.next()) {
            own(before, part.clone()).copy_from_slice(own(now, part.clone()));
        }
        self.wait();
    }

    /// The body itself, or one of its levels from 1 on.
    fn grid_level<'s>(&'s self, grid: &'s GridBody<T>, level: usize, places: &Range<usize>) -> Level<'s, T> {
        match level.checked_sub(1) {
            Some(level) => Level::of(&grid.nodes[level]),
            None => Level::of_body(self.worker, places, grid.rest.each_ref().map(|column| &column[..])),
        }
    }

    pub fn solve_grid(&self, grid: &GridBody<T>, places: &Range<usize>) {
        let count = grid.nodes.len();
        for level in 1..=count {
            self.together(grid.nodes[level - 1].len(), |solver| solver.restrict(grid, level, places));
        }
        for level in (1..=count).rev() {
            self.together(grid.nodes[level - 1].len(), |solver| {
                solver.prolongate(grid, level, places);
                for _ in 0..sweeps(level) {
                    solver.sweep(Pass::LIMITS, (grid, level), places, Acting::Limits(grid.limits));
                }
                solver.store_displacements(&grid.nodes[level - 1]);
            });
        }
        self.prolongate(grid, 0, places);
        let springs = grid.springs(self.worker.substep.h.to_f64(), self.all.sweeps);
        for _ in 0..self.all.sweeps {
            self.sweep(Pass::ALL, (grid, 0), places, Acting::Springs(&springs));
        }
    }

    /// Finds where the nodes of a level are from those of the finer one, and once a frame where they are at rest and what holds them.
    fn restrict(&self, grid: &GridBody<T>, level: usize, places: &Range<usize>) {
        let (shape, nodes) = (grid.shapes[level], &grid.nodes[level - 1]);
        let (finer, above) = (grid.shapes[level - 1].layout, self.grid_level(grid, level - 1, places));
        let [rows, cols] = shape.layout;
        let rows = self.part(rows);
        let part = rows.start * cols..rows.end * cols;
        let held_by = own(&nodes.held_by, part.clone());
        if self.is_first() {
            for (at, by) in part.clone().zip(&mut *held_by) {
                *by = holder(shape, finer, above.inverse_mass, [at / cols, at % cols]);
            }
            hold(nodes, part.clone(), held_by);
        }
        let mut row = self.all.rows.of(self.worker.index);
        let mut average = |position: [&[T]; 3], means: &[Shared<T>; 3]| {
            self.worker.nodes.level.run(Restrict {
                shape,
                finer,
                position,
                mass: above.mass,
                rows: rows.clone(),
                means: means.each_ref().map(|column| own(column, part.clone())),
                held_by,
                when_free: &nodes.when_free,
                row: &mut row,
            });
        };
        if self.is_first() {
            average(above.rest, &nodes.rest);
        }
        average(above.positions(), &nodes.position);
        keep_starts(nodes, part);
        self.wait();
    }

    /// Puts how far a level's nodes have gone where their starts were.
    fn store_displacements(&self, nodes: &LevelNodes<T>) {
        let part = self.part(nodes.len());
        for (position, start) in nodes.position.iter().zip(&nodes.start) {
            let (start, position) = (own(start, part.clone()), &read(position)[part.clone()]);
            start.iter_mut().zip(position).for_each(|(start, &position)| *start = position - *start);
        }
        self.wait();
    }

    /// Has the nodes of a level follow those of the coarser one, if there is one.
    fn prolongate(&self, grid: &GridBody<T>, level: usize, places: &Range<usize>) {
        let Some(coarser) = grid.nodes.get(level) else { return };
        let (layout @ [rows, cols], all) = (grid.shapes[level].layout, self.grid_level(grid, level, places));
        let rows = self.part(rows);
        let part = rows.start * cols..rows.end * cols;
        self.worker.nodes.level.run(Prolongate {
            position: all.own(part.clone()),
            inverse_mass: &all.inverse_mass[part],
            rows,
            layout,
            moved: coarser.start.each_ref().map(read),
            shape: grid.shapes[level + 1],
        });
        self.wait();
    }

    /// A sweep over a level.
    fn sweep(
        &self,
        passes: &[Pass],
        (grid, level): (&GridBody<T>, usize),
        places: &Range<usize>,
        acting: Acting<'_, T>,
    ) {
        let ([rows, cols], all) = (grid.shapes[level].layout, self.grid_level(grid, level, places));
        let before = if level == 0 { self.old(places) } else { all.rest };
        for &pass in passes {
            let rows = pass.rows(self.part(pass.count(rows)), rows);
            let part = rows.start * cols..rows.end * cols;
            self.worker.nodes.level.run(Sweep {
                pass,
                nodes: Nodes {
                    position: all.own(part.clone()),
                    inverse_mass: &all.inverse_mass[part.clone()],
                    before: before.map(|column| &column[part.clone()]),
                },
                cols,
                acting,
            });
            self.wait();
        }
    }

    /// Where nodes of a body were at the start of the sub-step.
    fn old(&self, places: &Range<usize>) -> [&[T]; 3] {
        let [x, y, z, ..] = self.worker.old();
        [x, y, z].map(|column| &column[places.clone()])
    }

    /// As [`Self::grid_level`].
    fn listed_level<'s>(
        &'s self,
        body: &'s ListBody<T>,
        level: usize,
        places: &Range<usize>,
    ) -> Level<'s, T> {
        match level.checked_sub(1) {
            Some(level) => Level::of(&body.nodes[level]),
            None => Level::of_body(self.worker, places, [&[]; 3]),
        }
    }

    pub fn solve_lists(&self, body: &ListBody<T>, places: &Range<usize>) {
        let count = body.levels.len();
        for level in 1..=count {
            self.together(body.nodes[level - 1].len(), |solver| solver.restrict_listed(body, level, places));
        }
        for level in (1..=count).rev() {
            self.together(body.nodes[level - 1].len(), |solver| {
                solver.prolongate_listed(body, level, places);
                for _ in 0..sweeps(level) {
                    solver.act((body, level), places, None);
                }
                solver.store_displacements(&body.nodes[level - 1]);
            });
        }
        self.prolongate_listed(body, 0, places);
        let (h, sweeps) = (self.worker.substep.h.to_f64(), self.all.sweeps);
        let springs: Vec<_> =
            body.materials.iter().map(|&of| Stiffness::new(of, h, sweeps, body.lightest)).collect();
        for _ in 0..sweeps {
            self.act((body, 0), places, Some(&springs));
        }
    }

    /// As [`Self::restrict`].
    fn restrict_listed(&self, body: &ListBody<T>, level: usize, places: &Range<usize>) {
        let (list, nodes) = (&body.levels[level - 1], &body.nodes[level - 1]);
        let above = self.listed_level(body, level - 1, places);
        let part = self.part(nodes.len());
        if self.is_first() {
            if self.is_alone || self.worker.index == 0 {
                let held_by = own(&nodes.held_by, 0..nodes.len());
                list.hold(above.inverse_mass, held_by);
                hold(nodes, 0..nodes.len(), held_by);
            }
            self.wait();
        }
        let held_by = read(&nodes.held_by);
        let average = |position: [&[T]; 3], means: &[Shared<T>; 3]| {
            for (means, position) in means.iter().zip(position) {
                for (mean, node) in own(means, part.clone()).iter_mut().zip(part.clone()) {
                    *mean = match held_by[node] {
                        FREE => list.mean(node, position),
                        by => position[by as usize],
                    };
                }
            }
        };
        average(above.positions(), &nodes.position);
        keep_starts(nodes, part.clone());
        self.wait();
    }

    /// As [`Self::prolongate`].
    fn prolongate_listed(&self, body: &ListBody<T>, level: usize, places: &Range<usize>) {
        let (Some(coarser), Some(list)) = (body.nodes.get(level), body.levels.get(level)) else { return };
        let all = self.listed_level(body, level, places);
        let part = self.part(all.count);
        for (finer, moved) in all.own(part.clone()).into_iter().zip(&coarser.start) {
            let moved = read(moved);
            for (x, row) in finer.iter_mut().zip(part.clone()) {
                if all.inverse_mass[row] > T::ZERO {
                    *x += list.displacement(row, moved);
                }
            }
        }
        self.wait();
    }

    /// Lets the springs of a body act, or the limits of a level.
    fn act(
        &self,
        (body, level): (&ListBody<T>, usize),
        places: &Range<usize>,
        springs: Option<&[Stiffness<T>]>,
    ) {
        let all = self.listed_level(body, level, places);
        let (lists, before) = match level.checked_sub(1) {
            Some(level) => (&body.levels[level].limits, [&[][..]; 3]),
            None => (&body.springs, self.old(places)),
        };
        for colour in &lists.colours {
            let part = self.part(colour.len());
            self.worker.nodes.level.run(ActLists {
                lists,
                sixteens: colour.start + part.start..colour.start + part.end,
                position: all.position,
                first: all.first,
                inverse_mass: all.inverse_mass,
                before,
                springs,
            });
            self.wait();
        }
    }
}

/// Inverse masses of some nodes of a level, from what holds them.
fn hold<T: Real>(nodes: &LevelNodes<T>, part: Range<usize>, held_by: &[u32]) {
    let inverse_mass = own(&nodes.inverse_mass, part.clone());
    for ((inverse_mass, &when_free), &by) in inverse_mass.iter_mut().zip(&nodes.when_free[part]).zip(held_by)
    {
        *inverse_mass = if by == FREE { when_free } else { T::ZERO };
    }
}

/// Keeps where some nodes of a level are before limits act.
fn keep_starts<T: Real>(nodes: &LevelNodes<T>, part: Range<usize>) {
    for (position, start) in nodes.position.iter().zip(&nodes.start) {
        own(start, part.clone()).copy_from_slice(own(position, part.clone()));
    }
}
