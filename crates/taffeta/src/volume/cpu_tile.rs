//! The stages of volumes on one tile.

use crate::cpu::simd::Kernel;
use crate::cpu::tile::CpuTile;
use crate::cpu::tiles::TiledSprings;
use crate::cpu::worker::Scratch;
use crate::real::{Real, scale, sub};
use crate::solvers::explicit::euler;
use crate::topology::LANES;
use crate::volume::cpu::{GROUP, Summed, group_sums, groups, weighted_group_sums};
use crate::volume::volume::{self, Node, Push, WEIGHTED_SUMS};
use std::ops::Range;

impl<'a, T: Real> CpuTile<'a, T> {
    /// The places of the tile; those of a mesh are one run.
    fn run(&self) -> Range<usize> {
        self.plan.runs().next().map_or(0..0, |(_, run)| run)
    }

    /// The tile's part of what says which places have touched a collider.
    fn touched(&self, volume: usize, run: &Range<usize>) -> &'a mut [bool] {
        let among = self.setup.volumes[volume].among(run);
        // SAFETY: tiles do not overlap, each is in one worker's share, and each stage takes its part once.
        unsafe { self.corrections.touched.write(among) }
    }

    /// The tile's part of the gradients in the state after.
    fn new_gradients(&self, volume: usize) -> [&'a mut [T]; 3] {
        let among = self.setup.volumes[volume].among(&self.run());
        // SAFETY: as in `touched`.
        self.corrections.gradient.each_ref().map(|column| unsafe { column.write(among.clone()) })
    }

    /// The numbers of the tile's nodes, with their weights.
    fn nodes(&self, volume: usize) -> Nodes<'a, T> {
        let (setup, run) = (self.setup, self.run());
        let body = &setup.volumes[volume];
        Nodes {
            origin: self.scratch.origins[volume],
            inverse_mass: &setup.inverse_mass[run.clone()],
            mass: &setup.mass[run.clone()],
            weights: body
                .weights
                .as_ref()
                .map(|weights| &weights[run.start - body.first..run.end - body.first]),
        }
    }

    /// Keeps forces and gradients for later, and sums up what the multiplier needs.
    pub(crate) fn sum_up(&mut self, volume: usize) {
        let (nodes, run) = (self.nodes(volume), self.run());
        let n = run.len();
        // Until the multiplier is known there is no state after, and its buffer is the nearest room.
        for (axis, kept) in self.after(&run).into_iter().enumerate() {
            let Scratch { force, gradient, .. } = &*self.scratch;
            kept.copy_from_slice(if axis < 3 { &gradient[axis][..n] } else { &force[axis - 3][..n] });
        }
        self.touched(volume, &run).fill(false);
        let moving = Moving {
            origin: nodes.origin,
            place: [0, 1, 2].map(|axis| &self.old[axis][run.clone()]),
            velocity: [3, 4, 5].map(|axis| &self.old[axis][run.clone()]),
            force: self.scratch.force.each_ref().map(|column| &column[..n]),
            gradient: self.scratch.gradient.each_ref().map(|column| &column[..n]),
            inverse_mass: nodes.inverse_mass,
            gravity: self.setup.assembly.world.gravity.map(T::from_f64),
            h: self.substep.h,
        };
        self.put_sums(volume, &nodes, &moving);
    }

    fn put_sums(&self, volume: usize, nodes: &Nodes<'_, T>, summed: &impl Summed<T>) {
        let first = self.setup.volumes[volume].groups.start;
        for (group, part) in groups(self.plan) {
            let group = first + group;
            // SAFETY: groups do not straddle tiles; all read them after a barrier.
            let sums = unsafe { self.corrections.sums.write(group..group + 1) };
            sums[0] = self.setup.level.run(PartSums { nodes, summed, part });
        }
    }

    /// Force of the tile's nodes with that of the constraint.
    pub(crate) fn push_forces(&mut self, volume: usize, push: &Push<T>) {
        let nodes = self.nodes(volume);
        let place = [0, 1, 2].map(|axis| &self.old[axis][self.run()]);
        let [gx, gy, gz, force @ ..] = self.after(&self.run());
        let gradient = [&*gx, &*gy, &*gz];
        let [fx, fy, fz] = &mut self.scratch.force;
        let [x, y, z] = [&mut fx[..gx.len()], &mut fy[..gx.len()], &mut fz[..gx.len()]];
        for (to, from) in [&mut *x, &mut *y, &mut *z].into_iter().zip(force) {
            to.copy_from_slice(from);
        }
        self.setup.level.run(PushForces { push, nodes, place, gradient, to: [x, y, z] });
    }

    /// Notes which nodes have touched a collider; returns how many had not before.
    pub(crate) fn note_touches(&self, volume: usize, at: usize, run: &Range<usize>) -> u64 {
        let touched = self.touched(volume, run);
        let last = &self.scratch.last_touch[at..at + run.len()];
        let mut new = 0;
        for (touched, &last) in touched.iter_mut().zip(last) {
            new += u64::from(last > 0 && !*touched);
            *touched |= last > 0;
        }
        new
    }

    /// Gradients at the new places, and sums over nodes that may still be moved.
    pub(crate) fn measure_volume(&mut self) {
        let Some(volume) = self.volume else { return };
        let body = self.setup.volumes[volume].first;
        // SAFETY: all have moved their nodes before a barrier, and move them again after the next.
        let next = [0, 1, 2].map(|axis| unsafe { self.next[axis].read() });
        let TiledSprings::Mesh(sets) = &self.setup.springs[self.plan.body] else { return };
        let (places, gradient) = (next.map(|column| &column[body..]), &mut self.scratch.gradient);
        if let Some(rings) = sets.first() {
            rings.gradients(self.setup.level, self.plan.units.clone(), places, gradient);
        }
        let (nodes, run) = (self.nodes(volume), self.run());
        for (kept, new) in self.new_gradients(volume).into_iter().zip(&self.scratch.gradient) {
            kept.copy_from_slice(&new[..run.len()]);
        }
        let place = next.map(|column| &column[run.clone()]);
        let gradient = self.scratch.gradient.each_ref().map(|column| &column[..run.len()]);
        let still = Still {
            origin: nodes.origin,
            place,
            gradient,
            inverse_mass: nodes.inverse_mass,
            weights: nodes.weights,
            touched: self.touched(volume, &run),
        };
        self.put_sums(volume, &nodes, &still);
    }

    /// Moves nodes that have touched nothing.
    pub(crate) fn push_places(&mut self, volume: usize, push: &Push<T>) {
        let (nodes, run) = (self.nodes(volume), self.run());
        let [x, y, z, ..] = self.after(&run);
        let [gx, gy, gz] = self.new_gradients(volume);
        let (gradient, touched) = ([&*gx, &*gy, &*gz], &*self.touched(volume, &run));
        self.setup.level.run(PushPlaces { push, nodes, gradient, touched, to: [x, y, z] });
    }

    /// The push of the tile's volume.
    pub(crate) fn pushed(&self) -> Option<(usize, Push<T>)> {
        let volume = self.volume?;
        Some((volume, self.scratch.pushes[volume]?))
    }
}

/// What does not change in a frame.
struct Nodes<'a, T> {
    origin: [T; 3],
    inverse_mass: &'a [T],
    mass: &'a [T],
    weights: Option<&'a [T]>,
}

impl<T: Real> Nodes<'_, T> {
    /// −u of a node: what λ is multiplied by.
    #[inline(always)]
    fn direction(&self, push: &Push<T>, i: usize, x: [T; 3], gradient: [T; 3]) -> [T; 3] {
        match self.weights {
            None => scale(gradient, -T::ONE),
            Some(weights) => {
                volume::direction(push, (&sub(x, self.origin), &gradient), weights[i], self.mass[i])
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

/// Nodes with the velocity that they would have without the constraint.
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

/// Nodes that may be moved where they have touched nothing.
struct Still<'a, T> {
    origin: [T; 3],
    place: [&'a [T]; 3],
    gradient: [&'a [T]; 3],
    inverse_mass: &'a [T],
    weights: Option<&'a [T]>,
    touched: &'a [bool],
}

impl<T: Real> Summed<T> for Still<'_, T> {
    #[inline(always)]
    fn part(&self, part: &Range<usize>) -> Self {
        Self {
            place: cut(&self.place, part),
            gradient: cut(&self.gradient, part),
            inverse_mass: &self.inverse_mass[part.clone()][..part.len()],
            weights: self.weights.map(|weights| &weights[part.clone()][..part.len()]),
            touched: &self.touched[part.clone()][..part.len()],
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
            inverse_mass: if self.touched[i] { T::ZERO } else { all },
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
struct PushForces<'a, 'b, T> {
    push: &'a Push<T>,
    nodes: Nodes<'b, T>,
    place: [&'a [T]; 3],
    gradient: [&'a [T]; 3],
    to: [&'a mut [T]; 3],
}

impl<T: Real> Kernel for PushForces<'_, '_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { push, nodes, place, gradient, to: [fx, fy, fz] } = self;
        for i in 0..fx.len() {
            let way = nodes.direction(push, i, at(&place, i), at(&gradient, i));
            fx[i] += way[0] * push.lambda;
            fy[i] += way[1] * push.lambda;
            fz[i] += way[2] * push.lambda;
        }
    }
}

/// Kernel: nodes on their way to the volume that they should enclose.
struct PushPlaces<'a, 'b, T> {
    push: &'a Push<T>,
    nodes: Nodes<'b, T>,
    gradient: [&'a [T]; 3],
    touched: &'a [bool],
    to: [&'a mut [T]; 3],
}

impl<T: Real> Kernel for PushPlaces<'_, '_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { push, nodes, gradient, touched, to: [x, y, z] } = self;
        for i in 0..x.len() {
            let way = nodes.direction(push, i, [x[i], y[i], z[i]], at(&gradient, i));
            let share = if touched[i] { T::ZERO } else { nodes.inverse_mass[i] } * push.lambda;
            x[i] += way[0] * share;
            y[i] += way[1] * share;
            z[i] += way[2] * share;
        }
    }
}

/// Groups are parts of tiles: a tile of a mesh begins at a multiple of its nodes.
const _: () = assert!(crate::cpu::tiles::TILE_NODES.is_multiple_of(GROUP) && GROUP.is_multiple_of(LANES));
