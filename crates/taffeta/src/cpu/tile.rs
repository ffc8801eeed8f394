//! The particle stages on one tile: gather, call the formula, store.

use super::backend::Setup;
use super::plan::Substep;
use super::simd::Kernel;
use super::tiles::{TilePlan, TiledSprings};
use super::worker::Scratch;
use crate::assembly::LoadKind;
use crate::collision::contact::respond;
use crate::collision::shape::ColliderNow;
use crate::forces::external;
use crate::integrate::euler;
use crate::real::{Real, add, scale};
use crate::step::Tile;

/// A tile and what its stages read and write.
pub struct CpuTile<'a, T> {
    /// What does not change.
    pub setup: &'a Setup<T>,
    /// Which nodes.
    pub plan: &'a TilePlan,
    /// What the sub-step is told.
    pub substep: &'a Substep<T>,
    /// State of all nodes before.
    pub old: [&'a [T]; 6],
    /// State of the tile's nodes after.
    pub new: [&'a mut [T]; 6],
    /// Forces on hinges' corners [N].
    pub hinge_forces: &'a [[[T; 3]; 4]],
    /// The worker's room.
    pub scratch: &'a mut Scratch<T>,
    /// Nodes that touched a collider.
    pub contacts: u64,
}

impl<T: Real> Tile for CpuTile<'_, T> {
    fn loads(&mut self) {
        let world = &self.setup.assembly.world;
        for axis in 0..3 {
            self.setup.level.run(WindAndDrag {
                force: &mut self.scratch.force[axis][..self.plan.nodes.len()],
                velocity: &self.old[3 + axis][self.plan.nodes.clone()],
                wind: T::from_f64(world.wind_force[axis]),
                drag: T::from_f64(world.drag),
            });
        }
        self.add_point_loads();
        self.add_hinges();
    }

    fn springs(&mut self) {
        let TilePlan { body, units, .. } = self.plan;
        let first = self.setup.assembly.bodies[*body].first;
        let old = self.old.map(|column| &column[first..]);
        let (level, Scratch { force, sweep, .. }) = (self.setup.level, &mut *self.scratch);
        match &self.setup.springs[*body] {
            TiledSprings::Grid(grid) => sweep.springs(level, (*body, grid), units.clone(), old, force),
            TiledSprings::Mesh(sets) => {
                for set in sets {
                    set.springs(level, units.clone(), old, force);
                }
            }
        }
    }

    fn integrate(&mut self) {
        let nodes = self.plan.nodes.clone();
        let [x, y, z, u, v, w] = &mut self.new;
        for (axis, (position, velocity)) in [(x, u), (y, v), (z, w)].into_iter().enumerate() {
            self.setup.level.run(Integrate {
                force: &self.scratch.force[axis],
                inverse_mass: &self.setup.inverse_mass[nodes.clone()],
                old_position: &self.old[axis][nodes.clone()],
                old_velocity: &self.old[3 + axis][nodes.clone()],
                position,
                velocity,
                gravity: T::from_f64(self.setup.assembly.world.gravity[axis]),
                h: self.substep.h,
            });
        }
    }

    fn pins(&mut self) {
        let nodes = &self.plan.nodes;
        let moving = &self.setup.assembly.moving_pins;
        let from = moving.partition_point(|pin| (pin.node as usize) < nodes.start);
        for pin in moving[from..].iter().take_while(|pin| (pin.node as usize) < nodes.end) {
            let (before, after) = &self.substep.poses[pin.track as usize];
            put(&mut self.new, pin.node as usize - nodes.start, before.apply(pin.start), after.apply(pin.start), self.substep);
        }
        let moves = &self.setup.hand.moves;
        let from = moves.partition_point(|(node, ..)| (*node as usize) < nodes.start);
        for &(node, start, goal) in moves[from..].iter().take_while(|(node, ..)| (*node as usize) < nodes.end) {
            let on_the_way = |s: f64| std::array::from_fn(|i| start[i] + s * (goal[i] - start[i]));
            let (before, after) = self.substep.hand;
            put(&mut self.new, node as usize - nodes.start, on_the_way(before), on_the_way(after), self.substep);
        }
    }

    fn contact(&mut self) {
        let [x, y, z, ..] = &self.new;
        let places: [&[T]; 3] = [x, y, z];
        let touched = self
            .substep
            .colliders
            .iter()
            .any(|collider| self.setup.level.run(CountInside { collider, places }) > 0);
        if !touched {
            return;
        }
        for i in 0..self.plan.nodes.len() {
            if self.setup.inverse_mass[self.plan.nodes.start + i] > T::ZERO {
                self.contacts += u64::from(self.contact_of(i));
            }
        }
    }
}

/// Moves a node out of all colliders, a few times round: where two press on it, each may push it into the other.
fn push_out<T: Real>(colliders: &[ColliderNow<T>], mut x: [T; 3]) -> [T; 3] {
    for _ in 0..4 {
        let before = x;
        for collider in colliders {
            if let Some(touch) = collider.touch(x) {
                x = add(x, scale(touch.normal, touch.depth));
            }
        }
        if x == before {
            break;
        }
    }
    x
}

/// Moves a pinned node, with the velocity of its way.
fn put<T: Real>(
    new: &mut [&mut [T]; 6],
    at: usize,
    before: [f64; 3],
    after: [f64; 3],
    substep: &Substep<T>,
) {
    for axis in 0..3 {
        new[axis][at] = T::from_f64(after[axis]);
        new[3 + axis][at] = T::from_f64((after[axis] - before[axis]) / substep.seconds);
    }
}

impl<T: Real> CpuTile<'_, T> {
    fn add_point_loads(&mut self) {
        let (nodes, assembly) = (&self.plan.nodes, &self.setup.assembly);
        for (index, load) in assembly.loads.iter().enumerate() {
            let from = load.nodes.partition_point(|&node| (node as usize) < nodes.start);
            for &node in load.nodes[from..].iter().take_while(|&&node| (node as usize) < nodes.end) {
                let force = match load.kind {
                    LoadKind::Force(f) => scale(f.map(T::from_f64), self.substep.scales[index]),
                    LoadKind::Torque { axis, about, .. } => {
                        let x = [0, 1, 2].map(|c| self.old[c][node as usize]);
                        let lever = external::lever(x, axis.map(T::from_f64), about.map(T::from_f64));
                        external::torque_force(self.scratch.torques[index], lever)
                    }
                };
                add_force(self.scratch, node as usize - nodes.start, force);
            }
        }
        let by_hand = &self.setup.hand.forces;
        let from = by_hand.partition_point(|(node, _)| (*node as usize) < nodes.start);
        for (node, force) in by_hand[from..].iter().take_while(|(node, _)| (*node as usize) < nodes.end) {
            add_force(self.scratch, *node as usize - nodes.start, force.map(T::from_f64));
        }
    }

    fn add_hinges(&mut self) {
        if self.setup.hinges.corners.is_empty() {
            return;
        }
        for node in self.plan.nodes.clone() {
            let mut sum = [T::ZERO; 3];
            for &corner in self.setup.hinges.by_node.row(node) {
                sum = add(sum, self.hinge_forces[corner as usize / 4][corner as usize % 4]);
            }
            add_force(self.scratch, node - self.plan.nodes.start, sum);
        }
    }

    /// Keeps node `i` of the tile out of all colliders; whether it touched one. Colliders act in the scene's order;
    /// a node pressed between several is then only moved, some times over.
    fn contact_of(&mut self, i: usize) -> bool {
        let mut x = [0, 1, 2].map(|c| self.new[c][i]);
        let mut v = [3, 4, 5].map(|c| self.new[c][i]);
        let mut touches = 0;
        for collider in &self.substep.colliders {
            if let Some(touch) = collider.touch(x) {
                (x, v) = respond(x, v, &touch, self.substep.h);
                touches += 1;
            }
        }
        if touches == 0 {
            return false;
        }
        if self.substep.colliders.len() > 1 {
            x = push_out(&self.substep.colliders, x);
        }
        for axis in 0..3 {
            self.new[axis][i] = x[axis];
            self.new[3 + axis][i] = v[axis];
        }
        true
    }
}

#[inline]
fn add_force<T: Real>(scratch: &mut Scratch<T>, at: usize, force: [T; 3]) {
    for axis in 0..3 {
        scratch.force[axis][at] += force[axis];
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

/// Kernel: how many nodes are inside a collider.
struct CountInside<'a, T> {
    collider: &'a ColliderNow<T>,
    places: [&'a [T]; 3],
}

impl<T: Real> Kernel for CountInside<'_, T> {
    type Output = u32;
    #[inline(always)]
    fn run(self) -> u32 {
        self.collider.count_inside(self.places)
    }
}
