//! Contacts of surfaces in the systems of bodies on the device's arrays, one number after the other: what rows compare kernels with.

use crate::contact::triangles::gpu_layout::{self as layout, SolvedContact, SurfaceContact};
use crate::contact::triangles::solved::SolvedContact as Formula;
use crate::contact::triangles::twin::Twin as Surfaces;
use crate::gpu::layout::NONE;
use crate::real::{Symmetric, add, dot, scale, sub};
use crate::solvers::implicit::gpu_layout::{Diagonal, Vector};
use crate::solvers::implicit::implicit::is_held;
use crate::solvers::implicit::twin::{Twin, record, six};

/// The arrays of the systems and of contact.
pub struct ContactTwin<'a> {
    pub solve: Twin<'a>,
    pub surfaces: Surfaces,
    pub systems: Vec<u32>,
    pub joins: Vec<u32>,
}

fn formula(one: &SolvedContact) -> Formula<f32> {
    Formula {
        nodes: one.nodes,
        weights: one.weights,
        normal: one.normal,
        gap: one.gap,
        lead: one.lead,
        friction: one.friction,
        first: one.first,
        body: one.system,
        stiffness: one.stiffness,
        impulse: one.impulse,
        along: one.along,
        across: one.across,
        applied: one.applied,
        is_held: one.is_held != 0,
    }
}

/// The first of the systems that one is joined with.
pub fn first_of(joins: &[u32], system: u32) -> u32 {
    let next = joins[system as usize];
    if next == system { system } else { first_of(joins, next) }
}

impl ContactTwin<'_> {
    fn contacts(&self) -> usize {
        self.surfaces.work[layout::CONTACTS] as usize
    }

    /// Notes what a formula has found of a contact.
    fn note(&mut self, number: usize, one: &Formula<f32>) {
        let Formula { stiffness, impulse, along, across, applied, .. } = *one;
        let is_held = one.is_held.into();
        let record = &mut self.surfaces.solved[number];
        *record = SolvedContact { stiffness, impulse, along, across, applied, is_held, ..*record };
    }

    pub fn part_systems(&mut self) {
        for (number, join) in (0..).zip(&mut self.joins) {
            *join = number;
        }
    }

    pub fn take_contacts(&mut self) {
        for number in 0..self.contacts() {
            let one = self.surfaces.contacts[number];
            let places = one.nodes.into_iter().zip(one.weights).filter(|(_, weight)| *weight != 0.0);
            let moving =
                places.map(|(place, _)| place as usize).filter(|&place| place < self.surfaces.nodes());
            let systems: Vec<u32> = moving.map(|place| self.systems[place]).collect();
            let is_part = !systems.contains(&NONE);
            let system = systems.iter().copied().min().filter(|_| is_part).unwrap_or(NONE);
            for other in systems.into_iter().filter(|_| is_part) {
                let [a, b] = [system, other].map(|one| first_of(&self.joins, one));
                self.joins[a.max(b) as usize] = a.min(b);
            }
            let SurfaceContact { nodes, weights, normal, gap, friction, .. } = one;
            let lead = if one.leads != 0 { self.surfaces.formula(&one).lead(self.surfaces.h) } else { 0.0 };
            let first = scale(one.force, self.solve.solving.inner);
            self.surfaces.solved[number] = SolvedContact {
                nodes,
                weights,
                normal,
                gap,
                first,
                lead,
                friction,
                system,
                ..SolvedContact::default()
            };
        }
    }

    pub fn name_systems(&mut self) {
        for (number, solve) in (0..).zip(&mut self.solve.work.solves) {
            solve.first = first_of(&self.joins, number);
        }
    }

    /// How a place moves in the step [m], and its velocity [m/s].
    fn motion(&self, place: usize) -> [[f32; 3]; 2] {
        let surfaces = &self.surfaces;
        if place < surfaces.nodes() {
            let [x, v] =
                [Vector::Direction, Vector::DirectionProduct].map(|which| self.solve.get(which, place));
            return [sub(x, surfaces.place(layout::AT_START, place)), v];
        }
        let way = sub(surfaces.place(layout::TARGET, place), surfaces.place(layout::BEFORE, place));
        [way, way.map(|way| way / surfaces.h)]
    }

    pub fn linearise(&mut self) {
        for number in 0..self.contacts() {
            let mut one = formula(&self.surfaces.solved[number]);
            let Some(&solve) = self.solve.work.solves.get(one.body as usize) else { continue };
            if solve.is_met != 0 || solve.kept.passes != 0 {
                continue;
            }
            if solve.steps == 0 {
                one.stiffen(|node| self.inverses(node as usize));
            }
            let of = |which: usize| one.relative(|node| self.motion(node as usize)[which]);
            let (gap, velocity) = (one.gap + dot(of(0), one.normal), of(1));
            one.linearise(gap, velocity, self.solve.solving.inner);
            self.note(number, &one);
        }
    }

    /// The inverse mass of a place [1/kg], the inverse of its diagonal block, and whether a collider holds it.
    fn inverses(&self, place: usize) -> (f32, Symmetric<f32>, bool) {
        if place >= self.surfaces.nodes() {
            return (0.0, [0.0; 6], false);
        }
        let Diagonal { own, inverse } = &self.solve.work.diagonals[place];
        (self.solve.fixture.old.position[place][3], six(inverse), is_held(&six(own)))
    }

    /// The contacts of a node in their order, and which of their nodes it is.
    fn parts(&self, node: usize) -> Vec<(Formula<f32>, usize)> {
        let surfaces = &self.surfaces;
        let count = surfaces.work[surfaces.list(0) + node] as usize;
        if count == 0 {
            return Vec::new();
        }
        let first = surfaces.lists_of_contacts()[1] + surfaces.work[surfaces.list(1) + node] as usize;
        let part = |&part: &u32| (formula(&surfaces.solved[part as usize / 4]), part as usize % 4);
        surfaces.work[first..first + count].iter().map(part).collect()
    }

    pub fn add(&mut self) {
        for (node, _) in self.solve.finest() {
            let mut impulse = [0.0; 3];
            let [mut own, mut inverse] = {
                let all = &self.solve.work.diagonals[node];
                [six(&all.own), six(&all.inverse)]
            };
            for (one, corner) in self.parts(node).into_iter().filter(|(one, _)| one.body != NONE) {
                impulse = add(impulse, scale(one.impulse, one.weights[corner]));
                inverse = one.soften(corner, &inverse);
                if one.is_held {
                    own = one.stiffened_block(corner, &own);
                }
            }
            let diagonal = &mut self.solve.work.diagonals[node];
            (diagonal.own, diagonal.inverse) = (record(own), record(inverse));
            if !self.parts(node).is_empty() {
                let sum = add(self.solve.get(Vector::Impulse, node), impulse);
                self.solve.put(Vector::Impulse, node, sum);
                let (mass, at) = (self.solve.mass(node), self.solve.at(Vector::Residual, node));
                let [x, y, z] = add(self.solve.get(Vector::Residual, node), impulse);
                self.solve.work.vectors[at] = [x, y, z, mass];
            }
        }
    }

    /// What a contact takes back of a vector.
    fn taken(&self, one: &Formula<f32>, which: Vector) -> [f32; 3] {
        let nodes = self.surfaces.nodes();
        let at =
            |node: u32| if (node as usize) < nodes { self.solve.get(which, node as usize) } else { [0.0; 3] };
        one.times(one.relative(at))
    }

    /// Products with a vector, at nodes of all systems or of those that are not done.
    pub fn multiply(&mut self, which: Vector, of_all: bool) {
        for (node, solve) in self.solve.finest() {
            if !of_all && self.solve.work.solves[solve].next.is_done != 0 {
                continue;
            }
            let acting = self.parts(node).into_iter().filter(|(one, _)| one.along > 0.0);
            let sum = acting.fold([0.0; 3], |sum, (one, corner)| {
                add(sum, scale(self.taken(&one, which), one.weights[corner]))
            });
            self.solve.put(Vector::Taken, node, sum);
        }
    }

    pub fn apply(&mut self) {
        for number in 0..self.contacts() {
            let one = formula(&self.surfaces.solved[number]);
            let is_open = |solve: u32| self.solve.work.solves[solve as usize].is_met == 0;
            if one.body != NONE && is_open(one.body) {
                let taken = self.taken(&one, Vector::Change);
                self.surfaces.solved[number].applied = sub(one.impulse, taken);
            }
        }
    }
}
