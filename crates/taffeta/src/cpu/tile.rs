//! The particle stages on one tile: gather, call the formula, store.

use crate::attachments::cpu::SharedAttach;
use crate::contact::collider_mesh::cache::Near;
use crate::contact::colliders::cpu::Contact;
use crate::cpu::backend::Setup;
use crate::cpu::shared::Shared;
use crate::cpu::simd::Kernel;
use crate::cpu::tiles::{TilePlan, TiledSprings};
use crate::cpu::worker::Scratch;
use crate::elements::load::build::LoadKind;
use crate::elements::load::load as external;
use crate::motion::pins::on_the_way;
use crate::plan::Substep;
use crate::real::{Real, scale};
use crate::solvers::dual::cpu::{SharedSolve, SolveSetup};
use crate::solvers::explicit::euler;
use crate::solvers::implicit::cpu::SharedPrimal;
use crate::step::Tile;
use crate::topology::LANES;
use crate::volume::cpu::SharedCorrections;
use std::ops::Range;

/// A tile and what its stages read and write.
pub struct CpuTile<'a, T> {
    /// What does not change.
    pub setup: &'a Setup<T>,
    /// Which nodes.
    pub plan: &'a TilePlan,
    /// Which of all tiles, and which of the worker's, it is.
    pub index: usize,
    pub number: usize,
    /// What the sub-step is told.
    pub substep: &'a Substep<T>,
    /// State of all nodes before.
    pub old: [&'a [T]; 6],
    /// State after; the tile's own nodes are written, nothing is read by others before the next barrier.
    pub next: &'a [Shared<'a, T>; 6],
    /// Forces on hinges' corners [N].
    pub hinge_forces: &'a [[[T; 3]; 4]],
    /// Force of the air on each corner of each panel [N].
    pub panel_forces: [&'a [T]; 3],
    /// What volumes need between stages.
    pub corrections: &'a SharedCorrections<'a, T>,
    /// What constraints need between stages.
    pub solve: &'a SharedSolve<'a, T>,
    /// What springs that are solved for by nodes have given.
    pub primal: &'a SharedPrimal<'a, T>,
    /// Which joints are broken.
    pub attach: &'a SharedAttach<'a>,
    /// Which volume it is a part of.
    pub volume: Option<usize>,
    /// The worker's room.
    pub scratch: &'a mut Scratch<T>,
    /// Nodes that touched a collider.
    pub contacts: u64,
    /// What is known of the triangles of colliders.
    pub near: Near<'a, T>,
    /// Nodes that others have moved, on which alone colliders act then, and where from.
    pub parted: Vec<(usize, [T; 3])>,
    /// Whether its nodes have been moved since colliders acted, from where the worker's room says.
    pub restored: bool,
}

impl<T: Real> Tile for CpuTile<'_, T> {
    fn loads(&mut self) {
        let world = &self.setup.assembly.world;
        for axis in 0..3 {
            for (at, run) in self.plan.runs() {
                self.setup.level.run(WindAndDrag {
                    force: &mut self.scratch.force[axis][at..at + run.len()],
                    velocity: &self.old[3 + axis][run],
                    wind: T::from_f64(world.wind_force[axis]),
                    drag: T::from_f64(world.drag),
                });
            }
        }
        for (at, run) in self.plan.runs() {
            self.add_point_loads(at, &run);
            self.add_elements(at, &run);
        }
    }

    fn springs(&mut self) {
        if self.is_implicit() {
            return;
        }
        let TilePlan { body, units, cols, .. } = self.plan;
        let first = self.setup.assembly.bodies[*body].first;
        let old = self.old.map(|column| &column[first..]);
        let watch = self.setup.solve.as_ref().and_then(SolveSetup::watched);
        let (level, Scratch { force, gradient, sweep, .. }) = (self.setup.level, &mut *self.scratch);
        let mut beyond = false;
        match &self.setup.springs[*body] {
            TiledSprings::Grid(grid) => {
                beyond |= sweep.springs(level, (*body, grid), (units.clone(), cols.clone()), old, force);
            }
            TiledSprings::Mesh(sets) => {
                let (rings, others) = sets.split_at(usize::from(self.volume.is_some()));
                for set in rings {
                    set.springs_and_gradients(level, units.clone(), old, force, gradient);
                    // Rings are not watched.
                    beyond = true;
                }
                for set in others {
                    beyond |= set.springs(level, units.clone(), old, force, watch);
                }
            }
        }
        self.note_waiting(beyond);
    }

    fn is_constrained(&self) -> bool {
        self.waits()
    }

    fn wait_for_constraints(&mut self) {
        self.integrate();
        self.pins();
        for (at, run) in self.plan.runs() {
            // The velocity without constraints where places will be, and the force where velocities will be.
            let [x, y, z, u, v, w] = self.after(&run);
            for (axis, (velocity, force)) in [(x, u), (y, v), (z, w)].into_iter().enumerate() {
                velocity.copy_from_slice(force);
                force.copy_from_slice(&self.scratch.force[axis][at..at + run.len()]);
            }
        }
    }

    fn constrain(&mut self) {
        self.add_constraints();
        self.find_gradients();
    }

    fn keeps_volume(&self) -> bool {
        self.volume.is_some()
    }

    fn gradients(&mut self) {
        if let Some(volume) = self.volume {
            self.sum_up(volume);
        }
    }

    fn keep_volume(&mut self) {
        if let Some((volume, push)) = self.pushed() {
            self.push_forces(volume, &push);
        }
    }

    fn integrate(&mut self) {
        for (at, run) in self.plan.runs() {
            let [x, y, z, u, v, w] = self.after(&run);
            for (axis, (position, velocity)) in [(x, u), (y, v), (z, w)].into_iter().enumerate() {
                self.setup.level.run(Integrate {
                    force: &self.scratch.force[axis][at..at + run.len()],
                    inverse_mass: &self.setup.inverse_mass[run.clone()],
                    old_position: &self.old[axis][run.clone()],
                    old_velocity: &self.old[3 + axis][run.clone()],
                    position,
                    velocity,
                    gravity: T::from_f64(self.setup.assembly.world.gravity[axis]),
                    h: self.substep.h,
                });
            }
        }
    }

    fn pins(&mut self) {
        let (moving, moves) = (&self.setup.assembly.moving_pins, &self.setup.input.moves);
        if moving.is_empty() && moves.is_empty() {
            return;
        }
        for (_, run) in self.plan.runs() {
            for pin in within(moving, &run, |pin| pin.node) {
                let motion = &self.substep.motions[pin.track as usize];
                self.put(pin.node, motion.apply(pin.start.map(T::from_f64)));
            }
            for &(node, from, to) in within(moves, &run, |&(node, ..)| node) {
                let ((share, rate), [from, to]) =
                    (self.substep.frame_fraction, [from, to].map(|x| x.map(T::from_f64)));
                self.put(node, on_the_way(from, to, share, rate));
            }
        }
    }

    fn contact(&mut self) {
        if self.substep.colliders.is_empty() {
            return;
        }
        if self.parted.is_empty() {
            self.plan.runs().for_each(|(at, run)| self.collide(at, run, None));
        }
        for (node, from) in std::mem::take(&mut self.parted) {
            self.collide(0, node..node + 1, Some(from));
        }
    }

    fn attach(&mut self) {
        for &(node, answer) in self.scratch.attach.answers(self.number) {
            let node = node as usize;
            let state = self.after(&(node..node + 1));
            self.parted.push((node, [0, 1, 2].map(|axis| state[axis][0])));
            for (column, number) in state.into_iter().zip(answer) {
                column[0] = number;
            }
        }
    }

    fn part(&mut self) {
        let Some(pairs) = &self.scratch.pairs else { return };
        for (node, answer) in pairs.answers(self.number) {
            let state = self.after(&(node..node + 1));
            self.parted.push((node, [0, 1, 2].map(|axis| state[axis][0])));
            for (column, &number) in state.into_iter().zip(answer) {
                column[0] = number;
            }
        }
    }

    fn restore_volume(&mut self) {
        if let Some((volume, push)) = self.pushed() {
            self.note_places();
            self.push_places(volume, &push);
        }
    }
}

/// The items of a list that ascends by node, whose nodes are in `run`.
fn within<'a, I>(items: &'a [I], run: &Range<usize>, node: impl Fn(&I) -> u32) -> &'a [I] {
    let start = items.partition_point(|item| (node(item) as usize) < run.start);
    let end = items.partition_point(|item| (node(item) as usize) < run.end);
    &items[start..end]
}

impl<'a, T: Real> CpuTile<'a, T> {
    /// The state after, of some of the tile's nodes. Stages run one after the other and keep nothing of it.
    pub(crate) fn after(&self, run: &Range<usize>) -> [&'a mut [T]; 6] {
        debug_assert!(self.plan.runs().any(|(_, own)| own.start <= run.start && run.end <= own.end));
        // SAFETY: tiles do not overlap, each is in one worker's share, and nobody reads this buffer before the barrier
        // after the particle stages. Within a stage the parts asked for do not overlap.
        self.next.each_ref().map(|column| unsafe { column.write(run.clone()) })
    }

    /// Keeps a run of nodes out of colliders; `at` is room in the worker's notes. One that was moved comes `from` there.
    fn collide(&mut self, at: usize, run: Range<usize>, from: Option<[T; 3]>) {
        let mut state = self.after(&run);
        let (all, Scratch { last_touch, before, alone, .. }) = (at..at + run.len(), &mut *self.scratch);
        let start = match &from {
            Some(from) => from.each_ref().map(std::slice::from_ref),
            None if self.restored => before.each_ref().map(|column| &column[all.clone()]),
            None => [0, 1, 2].map(|axis| &self.old[axis][run.clone()]),
        };
        let mut inverse_mass = &self.setup.inverse_mass[run.clone()];
        let carried = self.setup.attach.as_ref().map_or(&[][..], |attach| attach.carried(&run));
        if !carried.is_empty() {
            alone.clear();
            alone.extend_from_slice(inverse_mass);
            for &[node, joint] in carried {
                // SAFETY: tiles are in one worker's share, and the node is the only end of its joint.
                if !unsafe { self.attach.is_broken(joint) } {
                    alone[node as usize - run.start] = T::ZERO;
                }
            }
            inverse_mass = alone;
        }
        let contacts = Contact {
            level: self.setup.level,
            colliders: &self.substep.colliders,
            near: self.near,
            run: run.clone(),
            inverse_mass,
            start,
            carried: from.is_none() && !self.restored,
            state: &mut state,
            last: &mut last_touch[all],
            h: self.substep.h,
        }
        .act();
        self.contacts += self.volume.map_or(contacts, |volume| self.note_touches(volume, at, &run));
    }

    /// Keeps where its nodes are before they are moved to restore a volume.
    fn note_places(&mut self) {
        self.restored = true;
        if self.substep.colliders.is_empty() {
            return;
        }
        for (at, run) in self.plan.runs() {
            let state = self.after(&run);
            for (before, place) in self.scratch.before.iter_mut().zip(state) {
                before[at..at + run.len()].copy_from_slice(place);
            }
        }
    }

    /// Moves a pinned node, with the velocity of its way.
    fn put(&self, node: u32, (place, velocity): ([T; 3], [T; 3])) {
        let node = node as usize;
        let state = self.after(&(node..node + 1));
        for axis in 0..3 {
            state[axis][0] = place[axis];
            state[3 + axis][0] = velocity[axis];
        }
    }

    fn add_point_loads(&mut self, at: usize, run: &Range<usize>) {
        for (index, load) in self.setup.assembly.loads.iter().enumerate() {
            for &node in within(&load.nodes, run, |&node| node) {
                let force = match load.kind {
                    LoadKind::Force(f) => scale(f.map(T::from_f64), self.substep.scales[index]),
                    LoadKind::Torque { axis, about, .. } => {
                        let x = [0, 1, 2].map(|c| self.old[c][node as usize]);
                        let lever = external::lever(x, axis.map(T::from_f64), about.map(T::from_f64));
                        external::torque_force(self.scratch.torques[index], lever)
                    }
                };
                add_force(self.scratch, at + node as usize - run.start, force);
            }
        }
        for &(node, force) in within(&self.setup.input.forces, run, |&(node, _)| node) {
            add_force(self.scratch, at + node as usize - run.start, force.map(T::from_f64));
        }
    }

    /// Adds up hinges, then panels, by node; slices of nodes at a time.
    fn add_elements(&mut self, at: usize, run: &Range<usize>) {
        let Setup { hinges, panels, level, .. } = self.setup;
        if hinges.corners.is_empty() && panels.blocks() == 0 {
            return;
        }
        let mut start = run.start;
        while start < run.end {
            let nodes = start..run.end.min((start / LANES + 1) * LANES);
            let mut sum = [[T::ZERO; LANES]; 3];
            if !hinges.corners.is_empty() {
                self.sum_hinges(nodes.clone(), &mut sum);
            }
            panels.gather(*level, self.panel_forces, nodes.clone(), &mut sum);
            let here = at + start - run.start;
            for (column, sum) in self.scratch.force.iter_mut().zip(&sum) {
                for (force, &sum) in column[here..here + nodes.len()].iter_mut().zip(sum) {
                    *force += sum;
                }
            }
            start = nodes.end;
        }
    }

    fn sum_hinges(&self, nodes: Range<usize>, sum: &mut [[T; LANES]; 3]) {
        for (lane, node) in nodes.enumerate() {
            for &corner in self.setup.hinges.by_node.row(node) {
                let force = self.hinge_forces[corner as usize / 4][corner as usize % 4];
                for axis in 0..3 {
                    sum[axis][lane] += force[axis];
                }
            }
        }
    }
}

#[inline]
fn add_force<T: Real>(scratch: &mut Scratch<T>, at: usize, force: [T; 3]) {
    for (column, force) in scratch.force.iter_mut().zip(force) {
        column[at] += force;
    }
}

/// Kernel: wind and drag along one axis.
struct WindAndDrag<'a, T> {
    force: &'a mut [T],
    velocity: &'a [T],
    wind: T,
    drag: T,
}

impl<T: Real> Kernel for WindAndDrag<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        if self.drag == T::ZERO {
            self.force.fill(self.wind);
            return;
        }
        for (force, &velocity) in self.force.iter_mut().zip(self.velocity) {
            *force = external::wind_and_drag(self.wind, self.drag, velocity);
        }
    }
}

/// Kernel: symplectic Euler along one axis.
struct Integrate<'a, T> {
    force: &'a [T],
    inverse_mass: &'a [T],
    old_position: &'a [T],
    old_velocity: &'a [T],
    position: &'a mut [T],
    velocity: &'a mut [T],
    gravity: T,
    h: T,
}

impl<T: Real> Kernel for Integrate<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { force, inverse_mass, old_position, old_velocity, position, velocity, gravity, h } = self;
        integrate(force, inverse_mass, old_position, old_velocity, position, velocity, gravity, h);
    }
}

#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "slices apart tell the compiler that they do not overlap")]
fn integrate<T: Real>(
    force: &[T],
    inverse_mass: &[T],
    old_position: &[T],
    old_velocity: &[T],
    position: &mut [T],
    velocity: &mut [T],
    gravity: T,
    h: T,
) {
    let n = position.len();
    let (force, inverse_mass) = (&force[..n], &inverse_mass[..n]);
    let (old_position, old_velocity, velocity) = (&old_position[..n], &old_velocity[..n], &mut velocity[..n]);
    for i in 0..n {
        let v = euler::velocity(old_velocity[i], force[i], inverse_mass[i], gravity, h);
        velocity[i] = v;
        position[i] = euler::position(old_position[i], v, h);
    }
}
