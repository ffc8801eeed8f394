//! Volumes on the CPU: the multiplier of each body, its force, and rounds that move nodes where contact has changed a volume.

use crate::contact::colliders::cpu::Colliders;
use crate::cpu::backend::Context;
use crate::cpu::cells::PerWorker;
use crate::cpu::column::Column;
use crate::cpu::feature::{Feature, Flow};
use crate::cpu::shared::Shared;
use crate::cpu::simd::Kernel;
use crate::cpu::tile::{Moved, Tile};
use crate::cpu::tiles::{TILE_NODES, TilePlan};
use crate::cpu::worker::Worker;
use crate::elements::spring::cpu::Springs;
use crate::real::{Real, scale, sub};
use crate::solvers::explicit::euler;
use crate::step::{Marks, Op};
use crate::topology::LANES;
use crate::volume::cpu_sums::{GROUP, Summed, VolumeBody, group_sums, groups, weighted_group_sums};
use crate::volume::volume::{self, Node, VolumeCorrection, WEIGHTED_SUMS};
use std::ops::Range;

/// Bodies that keep their volume, or are under a pressure.
pub struct Volumes<T> {
    bodies: Vec<VolumeBody<T>>,
    /// Which of them each body of the scene is.
    of_body: Vec<Option<usize>>,
    /// Gradient of the volume [m²] in the state after; nothing where no volume is restored.
    gradient: [Shared<T>; 3],
    /// Sums of each group.
    sums: Shared<[T; WEIGHTED_SUMS]>,
    scratch: PerWorker<VolumeScratch<T>>,
}

/// The scratch memory of a worker.
struct VolumeScratch<T> {
    /// Gradients of the volume by the positions of one tile's nodes [m²].
    gradient: [Column<T>; 3],
    /// The correction of each volume in this sub-step.
    corrections: Vec<Option<VolumeCorrection<T>>>,
    /// Reference position of each volume [m].
    origins: Vec<[T; 3]>,
}

impl<T: Real> Volumes<T> {
    /// Those of a scene, if it has any.
    pub fn new(context: &Context<'_, T>) -> Option<Self> {
        let (bodies, of_body) = VolumeBody::all(context.assembly);
        let last = bodies.last()?;
        let (places, groups) = (last.places.end, last.groups.end);
        let moved = if bodies.iter().any(|body| body.projects) { places } else { 0 };
        let scratch = |_| VolumeScratch {
            gradient: std::array::from_fn(|_| Column::zeros(context.largest_tile())),
            corrections: vec![None; bodies.len()],
            origins: vec![[T::ZERO; 3]; bodies.len()],
        };
        Some(Self {
            gradient: std::array::from_fn(|_| Column::zeros(moved).into()),
            sums: vec![[T::ZERO; WEIGHTED_SUMS]; groups].into(),
            scratch: PerWorker::new(context.workers(), scratch),
            bodies,
            of_body,
        })
    }

    /// Places of all bodies: among those of such bodies, and among all.
    #[cfg(feature = "gpu")]
    pub fn places(&self) -> impl Iterator<Item = (usize, usize)> {
        self.bodies.iter().flat_map(|body| (body.places.clone()).zip(body.first..))
    }

    /// Gradient of the volume in the state after, at a place among those of such bodies, between frames.
    #[cfg(feature = "gpu")]
    pub fn gradient_of(&self, among: usize) -> [T; 3] {
        // SAFETY: no worker works between frames.
        self.gradient.each_ref().map(|column| unsafe { column.read() }[among])
    }

    /// Sums of each group, between frames.
    #[cfg(feature = "gpu")]
    pub fn all_sums(&self) -> &[[T; WEIGHTED_SUMS]] {
        // SAFETY: no worker works between frames.
        unsafe { self.sums.read() }
    }

    /// The volume of a tile, and its correction.
    fn correction_of(&self, tile: &Tile<'_, T>) -> Option<(usize, VolumeCorrection<T>)> {
        let volume = self.of_body[tile.plan.body]?;
        Some((volume, self.scratch.read(tile.worker).corrections[volume]?))
    }

    /// Sets the reference positions from a state.
    fn note_origins(&self, worker: usize, state: [&[T]; 3]) {
        for (origin, volume) in self.scratch.of(worker).origins.iter_mut().zip(&self.bodies) {
            *origin = state.map(|column| column[volume.first]);
        }
    }

    /// The tile's part of the gradients in the state after.
    #[expect(clippy::mut_from_ref, reason = "tiles do not overlap")]
    fn new_gradients(&self, tile: &Tile<'_, T>, volume: usize) -> [&mut [T]; 3] {
        let among = self.bodies[volume].among(&tile.run());
        // SAFETY: tiles do not overlap, each is in one worker's chunk, and each operation takes its part once.
        self.gradient.each_ref().map(|column| unsafe { column.write(among.clone()) })
    }

    /// Which of the tile's nodes are in contact with a collider.
    fn in_contact<'t>(&self, tile: &Tile<'t, T>) -> &'t [bool] {
        let Some(colliders) = tile.features.get::<Colliders<T>>() else { return &[] };
        // SAFETY: tiles do not overlap, each is in one worker's chunk, and nodes touch in another operation.
        unsafe { colliders.in_contact(&tile.run()) }
    }

    /// The numbers of the tile's nodes, with their weights.
    fn nodes<'t>(&'t self, tile: &Tile<'t, T>, volume: usize) -> Nodes<'t, T> {
        let (body, run) = (&self.bodies[volume], tile.run());
        Nodes {
            origin: self.scratch.read(tile.worker).origins[volume],
            inverse_mass: &tile.nodes.inverse_mass[run.clone()],
            mass: &tile.nodes.mass[run.clone()],
            weights: body
                .weights
                .as_ref()
                .map(|weights| &weights[run.start - body.first..run.end - body.first]),
        }
    }

    /// Adds springs along edges, and finds the gradient of the volume, in one walk.
    fn walk(&self, tile: &mut Tile<'_, T>) {
        let springs = tile.features.get::<Springs<T>>().and_then(|springs| springs.rings(tile.plan.body));
        let Some(springs) = springs else { return };
        let old = tile.old.map(|column| &column[tile.plan.first..]);
        let (units, scratch) = (tile.plan.units.clone(), &mut *self.scratch.of(tile.worker));
        springs.springs_and_gradients(
            tile.nodes.level,
            units,
            old,
            &mut tile.scratch.force,
            &mut scratch.gradient,
        );
    }

    /// Finds the gradient of the volume alone, from positions by axis.
    fn find_gradients(&self, tile: &Tile<'_, T>, positions: [&[T]; 3]) {
        let springs = tile.features.get::<Springs<T>>().and_then(|springs| springs.rings(tile.plan.body));
        let Some(springs) = springs else { return };
        let positions = positions.map(|column| &column[tile.plan.first..]);
        let (units, scratch) = (tile.plan.units.clone(), &mut *self.scratch.of(tile.worker));
        springs.gradients(tile.nodes.level, units, positions, &mut scratch.gradient);
    }

    /// Stores forces and gradients, and adds up the sums of the multiplier.
    fn sum_up(&self, tile: &Tile<'_, T>) {
        let Some(volume) = self.of_body[tile.plan.body] else { return };
        let (nodes, run) = (self.nodes(tile, volume), tile.run());
        let scratch = self.scratch.read(tile.worker);
        let (n, force, gradient) = (run.len(), &tile.scratch.force, &scratch.gradient);
        // There is no state after until the multiplier is known, so its buffer stores them.
        for (axis, kept) in tile.after(&run).into_iter().enumerate() {
            kept.copy_from_slice(if axis < 3 { &gradient[axis][..n] } else { &force[axis - 3][..n] });
        }
        let moving = Moving {
            origin: nodes.origin,
            place: [0, 1, 2].map(|axis| &tile.old[axis][run.clone()]),
            velocity: [3, 4, 5].map(|axis| &tile.old[axis][run.clone()]),
            force: force.each_ref().map(|column| &column[..n]),
            gradient: gradient.each_ref().map(|column| &column[..n]),
            inverse_mass: nodes.inverse_mass,
            gravity: tile.substep.gravity.map(T::from_f64),
            h: tile.substep.h,
        };
        self.put_sums(tile, volume, &nodes, &moving);
    }

    fn put_sums(&self, tile: &Tile<'_, T>, volume: usize, nodes: &Nodes<'_, T>, summed: &impl Summed<T>) {
        let first = self.bodies[volume].groups.start;
        for (group, part) in groups(tile.plan) {
            let group = first + group;
            // SAFETY: groups do not straddle tiles; all read them after a barrier.
            let sums = unsafe { self.sums.item(group) };
            *sums = tile.nodes.level.run(PartSums { nodes, summed, part });
        }
    }

    /// Finds the corrections of the volumes that are `chosen`, after all workers have written their sums.
    fn solve(
        &self,
        worker: &Worker<'_, T>,
        chosen: impl Fn(usize) -> bool,
        solve: impl Fn(&VolumeBody<T>, &[[T; WEIGHTED_SUMS]], T) -> Option<VolumeCorrection<T>>,
    ) {
        // SAFETY: sums are written before a barrier and read after it.
        let sums = unsafe { self.sums.read() };
        let corrections = &mut self.scratch.of(worker.index).corrections;
        for volume in (0..self.bodies.len()).filter(|volume| chosen(*volume)) {
            corrections[volume] = solve(&self.bodies[volume], sums, worker.substep.goals()[volume]);
        }
    }

    /// Finds the multipliers of the volumes of the worker's tiles.
    fn find_multipliers(&self, worker: &Worker<'_, T>) {
        // Bodies and their tiles have the same order.
        let mut of_tiles =
            worker.nodes.tiles[worker.tiles.clone()].iter().filter_map(|tile| self.of_body[tile.body]);
        let (first, last) = (of_tiles.next(), of_tiles.next_back());
        let mine = first.map_or(0..0, |first| first..last.unwrap_or(first) + 1);
        let h = worker.substep.h;
        self.solve(
            worker,
            |volume| mine.contains(&volume),
            |body, sums, goal| Some(body.correction(sums, goal, h)),
        );
    }

    /// Adds the force of the constraint to the tile's nodes.
    fn add_forces(&self, tile: &mut Tile<'_, T>) {
        let Some((volume, correction)) = self.correction_of(tile) else { return };
        let (nodes, run) = (self.nodes(tile, volume), tile.run());
        let place = [0, 1, 2].map(|axis| &tile.old[axis][run.clone()]);
        let [gx, gy, gz, force @ ..] = tile.after(&run);
        let gradient = [&*gx, &*gy, &*gz];
        let [fx, fy, fz] = &mut tile.scratch.force;
        let [x, y, z] = [&mut fx[..gx.len()], &mut fy[..gx.len()], &mut fz[..gx.len()]];
        for (to, from) in [&mut *x, &mut *y, &mut *z].into_iter().zip(force) {
            to.copy_from_slice(from);
        }
        tile.nodes.level.run(AddForces { correction: &correction, nodes, place, gradient, to: [x, y, z] });
    }

    /// Measures the volumes that are restored, and finds which are off.
    fn measure_volumes(&self, worker: &Worker<'_, T>) -> Flow {
        let projects = |volume: usize| self.bodies[volume].projects;
        if !(0..self.bodies.len()).any(projects) {
            return Flow::Done;
        }
        // SAFETY: all have moved their nodes before the barrier, and move them again after the next.
        let next = worker.next().each_ref().map(|column| unsafe { column.read() });
        let [x, y, z, ..] = next;
        self.note_origins(worker.index, [x, y, z]);
        worker.each_tile(|tile| {
            if self.of_body[tile.plan.body].is_some_and(projects) {
                self.measure_tile(tile, [x, y, z]);
            }
        });
        worker.synchronise();
        self.solve(worker, projects, |body, sums, goal| body.projection(sums, goal));
        let corrections = &self.scratch.read(worker.index).corrections;
        let off = |volume: usize| projects(volume) && corrections[volume].is_some();
        worker.mark_moved(|tile| self.of_body[worker.nodes.tiles[tile].body].is_some_and(off));
        if (0..self.bodies.len()).any(off) { Flow::Go } else { Flow::Done }
    }

    /// Gradients at the new positions, and sums over nodes that may still be moved.
    fn measure_tile(&self, tile: &Tile<'_, T>, next: [&[T]; 3]) {
        let Some(volume) = self.of_body[tile.plan.body] else { return };
        self.find_gradients(tile, next);
        let (nodes, run) = (self.nodes(tile, volume), tile.run());
        let gradient = &self.scratch.read(tile.worker).gradient;
        for (kept, new) in self.new_gradients(tile, volume).into_iter().zip(gradient) {
            kept.copy_from_slice(&new[..run.len()]);
        }
        let still = Still {
            origin: nodes.origin,
            place: next.map(|column| &column[run.clone()]),
            gradient: gradient.each_ref().map(|column| &column[..run.len()]),
            inverse_mass: nodes.inverse_mass,
            weights: nodes.weights,
            in_contact: self.in_contact(tile),
        };
        self.put_sums(tile, volume, &nodes, &still);
    }

    /// Moves the nodes that are not in contact.
    fn restore(&self, tile: &mut Tile<'_, T>) {
        let Some((volume, correction)) = self.correction_of(tile) else { return };
        tile.moved = Moved::Any;
        let (nodes, run) = (self.nodes(tile, volume), tile.run());
        let [x, y, z, ..] = tile.after(&run);
        if !tile.substep.colliders().is_empty() {
            for (before, now) in tile.scratch.before.iter_mut().zip([&*x, &*y, &*z]) {
                before[..run.len()].copy_from_slice(now);
            }
        }
        let gradient = self.new_gradients(tile, volume).map(|column| &*column);
        let in_contact = self.in_contact(tile);
        tile.nodes.level.run(MoveNodes {
            correction: &correction,
            nodes,
            gradient,
            in_contact,
            to: [x, y, z],
        });
    }
}

impl<T: Real> Feature<T> for Volumes<T> {
    fn ops(&self) -> &'static [Op] {
        &[
            Op::Rings,
            Op::Gradients,
            Op::VolumeSums,
            Op::Multipliers,
            Op::VolumeForces,
            Op::MeasureVolumes,
            Op::RestoreVolumes,
        ]
    }

    fn marks(&self, plan: &TilePlan) -> Marks {
        if self.of_body[plan.body].is_some() { Marks::VOLUME } else { Marks::NONE }
    }

    fn begin(&self, worker: &mut Worker<'_, T>) {
        let [x, y, z, ..] = worker.old();
        self.note_origins(worker.index, [x, y, z]);
    }

    fn run(&self, op: Op, worker: &mut Worker<'_, T>) -> Flow {
        if op == Op::MeasureVolumes {
            return self.measure_volumes(worker);
        }
        self.find_multipliers(worker);
        Flow::Go
    }

    fn tile(&self, op: Op, tile: &mut Tile<'_, T>) {
        match op {
            Op::Rings => self.walk(tile),
            Op::Gradients => self.find_gradients(tile, [tile.old[0], tile.old[1], tile.old[2]]),
            Op::VolumeSums => self.sum_up(tile),
            Op::VolumeForces => self.add_forces(tile),
            _ => self.restore(tile),
        }
    }

    fn bytes(&self) -> usize {
        3 * self.gradient[0].bytes() + self.sums.bytes()
    }
}

/// What is constant during a frame.
struct Nodes<'a, T> {
    origin: [T; 3],
    inverse_mass: &'a [T],
    mass: &'a [T],
    weights: Option<&'a [T]>,
}

impl<T: Real> Nodes<'_, T> {
    /// −u of a node: the factor of λ.
    #[inline(always)]
    fn direction(&self, correction: &VolumeCorrection<T>, i: usize, x: [T; 3], gradient: [T; 3]) -> [T; 3] {
        match self.weights {
            None => scale(gradient, -T::ONE),
            Some(weights) => {
                volume::direction(correction, (&sub(x, self.origin), &gradient), weights[i], self.mass[i])
            }
        }
    }
}

/// Kernel: the sums of a part of a tile.
struct PartSums<'a, 'b, T, S> {
    nodes: &'a Nodes<'b, T>,
    summed: &'a S,
    part: Range<usize>,
}

impl<T: Real, S: Summed<T>> Kernel for PartSums<'_, '_, T, S> {
    type Output = [T; WEIGHTED_SUMS];
    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { nodes, summed, part } = self;
        match nodes.weights {
            None => group_sums(&part, summed),
            Some(weights) => weighted_group_sums(&part, summed, weights, nodes.mass),
        }
    }
}

/// Nodes with the velocity without the constraint.
struct Moving<'a, T> {
    origin: [T; 3],
    place: [&'a [T]; 3],
    velocity: [&'a [T]; 3],
    force: [&'a [T]; 3],
    gradient: [&'a [T]; 3],
    inverse_mass: &'a [T],
    gravity: [T; 3],
    h: T,
}

impl<T: Real> Summed<T> for Moving<'_, T> {
    #[inline(always)]
    fn part(&self, part: &Range<usize>) -> Self {
        Self {
            place: cut(&self.place, part),
            velocity: cut(&self.velocity, part),
            force: cut(&self.force, part),
            gradient: cut(&self.gradient, part),
            inverse_mass: &self.inverse_mass[part.clone()][..part.len()],
            ..*self
        }
    }

    #[inline(always)]
    fn node(&self, i: usize) -> Node<T> {
        let inverse_mass = self.inverse_mass[i];
        let [u, v, w] = at(&self.velocity, i);
        let ([fx, fy, fz], [gx, gy, gz]) = (at(&self.force, i), self.gravity);
        let velocity = [
            euler::velocity(u, fx, inverse_mass, gx, self.h),
            euler::velocity(v, fy, inverse_mass, gy, self.h),
            euler::velocity(w, fz, inverse_mass, gz, self.h),
        ];
        let place = sub(at(&self.place, i), self.origin);
        Node { place, gradient: at(&self.gradient, i), velocity, inverse_mass }
    }
}

/// Nodes that may be moved because they are not in contact.
struct Still<'a, T> {
    origin: [T; 3],
    place: [&'a [T]; 3],
    gradient: [&'a [T]; 3],
    inverse_mass: &'a [T],
    weights: Option<&'a [T]>,
    in_contact: &'a [bool],
}

impl<T: Real> Summed<T> for Still<'_, T> {
    #[inline(always)]
    fn part(&self, part: &Range<usize>) -> Self {
        Self {
            place: cut(&self.place, part),
            gradient: cut(&self.gradient, part),
            inverse_mass: &self.inverse_mass[part.clone()][..part.len()],
            weights: self.weights.map(|weights| &weights[part.clone()][..part.len()]),
            in_contact: &self.in_contact[part.clone()][..part.len()],
            ..*self
        }
    }

    #[inline(always)]
    fn node(&self, i: usize) -> Node<T> {
        let (gradient, all) = (at(&self.gradient, i), self.inverse_mass[i]);
        let weight = self.weights.map_or(T::ONE, |weights| weights[i]);
        Node {
            place: sub(at(&self.place, i), self.origin),
            gradient,
            // In place of the flux: the response of all nodes.
            velocity: scale(gradient, all * weight),
            inverse_mass: if self.in_contact[i] { T::ZERO } else { all },
        }
    }
}

/// Slices of one length, so that the compiler sees it.
#[inline(always)]
fn cut<'a, T>([x, y, z]: &[&'a [T]; 3], part: &Range<usize>) -> [&'a [T]; 3] {
    let n = part.len();
    [&x[part.clone()][..n], &y[part.clone()][..n], &z[part.clone()][..n]]
}

#[inline(always)]
fn at<T: Real>(columns: &[&[T]; 3], i: usize) -> [T; 3] {
    [columns[0][i], columns[1][i], columns[2][i]]
}

/// Kernel: the force of the constraint, added to the others.
struct AddForces<'a, 'b, T> {
    correction: &'a VolumeCorrection<T>,
    nodes: Nodes<'b, T>,
    place: [&'a [T]; 3],
    gradient: [&'a [T]; 3],
    to: [&'a mut [T]; 3],
}

impl<T: Real> Kernel for AddForces<'_, '_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { correction, nodes, place, gradient, to: [fx, fy, fz] } = self;
        for i in 0..fx.len() {
            let direction = nodes.direction(correction, i, at(&place, i), at(&gradient, i));
            fx[i] += direction[0] * correction.lambda;
            fy[i] += direction[1] * correction.lambda;
            fz[i] += direction[2] * correction.lambda;
        }
    }
}

/// Kernel: moves nodes so that they enclose the volume to keep.
struct MoveNodes<'a, 'b, T> {
    correction: &'a VolumeCorrection<T>,
    nodes: Nodes<'b, T>,
    gradient: [&'a [T]; 3],
    in_contact: &'a [bool],
    to: [&'a mut [T]; 3],
}

impl<T: Real> Kernel for MoveNodes<'_, '_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { correction, nodes, gradient, in_contact, to: [x, y, z] } = self;
        for i in 0..x.len() {
            let direction = nodes.direction(correction, i, [x[i], y[i], z[i]], at(&gradient, i));
            let factor = if in_contact[i] { T::ZERO } else { nodes.inverse_mass[i] } * correction.lambda;
            x[i] += direction[0] * factor;
            y[i] += direction[1] * factor;
            z[i] += direction[2] * factor;
        }
    }
}

/// Groups are parts of tiles: a tile of a mesh begins at a multiple of its nodes.
const _: () = assert!(TILE_NODES.is_multiple_of(GROUP) && GROUP.is_multiple_of(LANES));
