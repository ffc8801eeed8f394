//! Drivers that take the CPU's formulas and kernels of constraints through the GPU's arrays, in the order in which the GPU takes
//! sums.

use crate::backend::Backend;
use crate::contact::collider_mesh::parity_scene::nearest_of;
use crate::contact::colliders::moving::ColliderNow;
use crate::contact::colliders::predicted_contact::{Approach, Depth, PredictedContact, deepest, reach};
use crate::contact::colliders::shape::ShapeNow;
use crate::cpu::simd::Kernel;
use crate::elements::spring::spring;
use crate::gpu::layout::{Four, GROUP, Solving};
use crate::parity::fixture::{Fixture, SUBSTEP};
use crate::real::{Real, add, scale, sub};
use crate::solvers::dual::cpu::Quad;
use crate::solvers::dual::cpu::kernels::{
    Advance, Along, Apply, Combine, GatherConstraintForces, Multiply, gather,
};
use crate::solvers::dual::distance::{
    Conjugate, Row as SetUp, Softness, becomes_active, is_left, limit, noise, residual_fraction,
    warm_start_factor,
};
use crate::solvers::dual::gpu_layout::{CgState, Constraint, ContactRecord, Row, Solve, SolveStatistics};
use crate::solvers::explicit::euler;
use std::slice::{from_mut, from_ref};

/// The arrays that kernels of constraints work on.
#[derive(Clone)]
pub struct Work {
    pub constraints: Vec<Constraint>,
    pub rows: Vec<Row>,
    pub scales: Vec<[f32; 2]>,
    pub predicted_contacts: Vec<ContactRecord>,
    pub active_constraints: Vec<u32>,
    pub active_counts: Vec<u32>,
    pub solves: Vec<Solve>,
    pub sums: Vec<[f32; 4]>,
    pub response: Vec<Four>,
    pub force: Vec<Four>,
    pub new_velocity: Vec<Four>,
    pub statistics: SolveStatistics,
}

pub fn three([x, y, z, _]: Four) -> [f32; 3] {
    [x, y, z]
}

/// The sum of 256 lanes: the upper half is added to the lower, again and again.
pub fn by_halves(mut lanes: Vec<[f32; 4]>) -> [f32; 4] {
    let mut half = GROUP / 2;
    while half > 0 {
        for lane in 0..half {
            lanes[lane] = [0, 1, 2, 3].map(|i| lanes[lane][i] + lanes[lane + half][i]);
        }
        half /= 2;
    }
    lanes[0]
}

/// The sum of what groups have: each lane takes every 256th.
pub fn by_lanes(sums: &[[f32; 4]]) -> [f32; 4] {
    let mut lanes = vec![[0.0; 4]; GROUP];
    for (i, sum) in sums.iter().enumerate() {
        lanes[i % GROUP] = [0, 1, 2, 3].map(|k| lanes[i % GROUP][k] + sum[k]);
    }
    by_halves(lanes)
}

/// Whether a spring is a constraint.
pub fn is_active(constraint: &Constraint, position: &[Four], solving: &Solving) -> bool {
    let [a, b] = [constraint.a, constraint.b].map(|end| position[end as usize]);
    let limits = [solving.activation, solving.release];
    let is_free = a[3] > 0.0 || b[3] > 0.0;
    becomes_active(
        sub(three(b), three(a)),
        constraint.rest_length,
        limits,
        is_free,
        constraint.is_active != 0,
    )
}

/// How a surface holds a node, as kernels keep it.
pub fn contact_record(
    predicted: PredictedContact<f32>,
    collider: u32,
    is_constrained: bool,
) -> ContactRecord {
    let PredictedContact { normal, slides, velocity, surface_speed } = predicted;
    ContactRecord {
        normal,
        slides,
        velocity,
        collider,
        is_constrained: is_constrained.into(),
        surface_speed,
        ..ContactRecord::default()
    }
}

/// The surface that will hold a node, where `before` is what meshes have found.
pub fn deepest_contact(
    colliders: &[ColliderNow<f32>],
    approach: &Approach<f32>,
    before: &ContactRecord,
) -> ContactRecord {
    let mut indices = 0..;
    let found = deepest(colliders, |collider| {
        let index = indices.next()?;
        let own = PredictedContact::of(collider, approach)
            .map(|(inside, predicted)| (inside, contact_record(predicted, index, true)));
        let known = (before.inside > 0.0 && before.collider == index).then_some((before.inside, *before));
        match (own, known) {
            (Some(own), Some(known)) => Some(if own.0 > known.0 { own } else { known }),
            (own, known) => own.or(known),
        }
    });
    found.map_or(contact_record(PredictedContact::FREE, 0, true), |(record, _)| record)
}

/// The mesh that will hold a node, as kernels keep it.
pub fn deepest_mesh_contact(fixture: &Fixture, node: usize, approach: &Approach<f32>) -> ContactRecord {
    let found = deepest(fixture.substep().met_colliders().at(node), |collider| {
        predict_mesh_contact(fixture, collider, approach).map(|found| (found.0, found))
    });
    found.map_or(contact_record(PredictedContact::FREE, 0, true), |((inside, predicted), index)| {
        ContactRecord { inside, ..contact_record(predicted, index, true) }
    })
}

fn predict_mesh_contact(
    fixture: &Fixture,
    collider: &ColliderNow<f32>,
    approach: &Approach<f32>,
) -> Option<(f32, PredictedContact<f32>)> {
    let ShapeNow::Mesh(now) = &collider.shape else { return None };
    let surface = &fixture.surfaces[now.index as usize];
    let place = now.local(approach.position);
    let around = surface.tree(now).around(place, f32::FAR);
    let contact = surface.resting(now, place, &nearest_of(surface, now, place)?, &around);
    let [normal, velocity] = [contact.normal, contact.velocity].map(|way| now.place.turn(way));
    PredictedContact::of_mesh(&collider.surface, approach, Depth { depth: contact.depth, normal, velocity })
}

pub fn predicted_in(record: &ContactRecord) -> PredictedContact<f32> {
    PredictedContact {
        normal: record.normal,
        slides: record.slides,
        velocity: record.velocity,
        surface_speed: record.surface_speed,
    }
}

/// A row, as the CPU's kernels have it.
fn quad(row: &Row, compliance: f32) -> Quad<f32> {
    let [x, y, z] = row.direction;
    Quad([x, y, z, compliance])
}

/// The pull of a row along its direction.
fn force_along(row: &Row, length: f32) -> Quad<f32> {
    let mut row_forces = Quad::default();
    Along { rows: &[quad(row, 0.0)], vector: &[length], row_forces: from_mut(&mut row_forces) }.run();
    row_forces
}

/// A row's vectors after a step; the first one is from the right side to what the pulls to start from leave of it.
fn stepped(before: &Row, step: &CgState) -> Row {
    let Row { mut r, w, mut s, mut p, mut x, .. } = *before;
    if step.passes == 1 {
        (r, s, p) = (p, 0.0, 0.0);
        Combine { to: from_mut(&mut r), factor: -step.alpha, other: &[w] }.run();
        Multiply { vector: from_mut(&mut x), factor: step.alpha }.run();
    } else if step.passes > 1 {
        let [x, r, p, s] = [&mut x, &mut r, &mut p, &mut s].map(from_mut);
        Advance { alpha: step.alpha, beta: step.beta, x, r, p, s, w: &[w] }.run();
    }
    Row { r, s, p, x, ..*before }
}

/// A fixture's work, as its kernels find it.
pub struct Twin<'a> {
    pub fixture: &'a Fixture,
    pub solving: Solving,
    pub work: Work,
}

impl Twin<'_> {
    fn h(&self) -> f32 {
        self.fixture.substep().h
    }

    /// The nodes of the segment with the number of their system.
    fn nodes(&self) -> Vec<(usize, usize)> {
        let groups = &self.fixture.tables.constraints.node_groups;
        let nodes = |first: u32, count: u32| first as usize..(first + count) as usize;
        groups.iter().flat_map(|g| nodes(g.first, g.count).map(|node| (node, g.solve as usize))).collect()
    }

    /// For each node the constraints at it, with which of their ends.
    fn incident(&self) -> Vec<Vec<(usize, u32)>> {
        let mut all = vec![Vec::new(); self.fixture.tables.len()];
        for (number, constraint) in self.work.constraints.iter().enumerate() {
            all[constraint.a as usize].push((number, 0));
            all[constraint.b as usize].push((number, 1));
        }
        all
    }

    pub fn mark(&mut self) {
        let position = &self.fixture.old.position;
        for constraint in &mut self.work.constraints {
            constraint.is_active = is_active(constraint, position, &self.solving).into();
        }
        let groups = &self.fixture.tables.constraints.constraint_groups;
        self.work.active_counts = groups
            .iter()
            .map(|g| self.work.constraints[g.first as usize..(g.first + g.count) as usize].iter())
            .map(|constraints| constraints.map(|constraint| constraint.is_active).sum())
            .collect();
    }

    pub fn free(&mut self) {
        let (old, gravity) = (&self.fixture.old, self.fixture.records()[SUBSTEP].gravity);
        let incident = self.incident();
        for (node, _) in self.nodes() {
            let (x, v) = (old.position[node], old.velocity[node]);
            let active = incident[node].iter().map(|&(number, _)| self.work.constraints[number]);
            let active: Vec<Constraint> = active.filter(|constraint| constraint.is_active != 0).collect();
            let mut force = three(self.work.force[node]);
            for constraint in active.iter().filter(|_| self.solving.is_adaptive != 0) {
                let other = if constraint.a as usize == node { constraint.b } else { constraint.a } as usize;
                let d = sub(three(old.position[other]), three(x));
                let dv = sub(three(old.velocity[other]), three(v));
                let factor = spring::factor(d, dv, constraint.k, constraint.damping, constraint.rest_length);
                force = sub(force, scale(d, factor));
            }
            let u = [0, 1, 2].map(|i| euler::velocity(v[i], force[i], x[3], gravity[i], self.h()));
            self.work.force[node] = [force[0], force[1], force[2], 0.0];
            self.work.new_velocity[node] = [u[0], u[1], u[2], v[3].abs()];
            self.work.predicted_contacts[node] =
                contact_record(PredictedContact::FREE, 0, !active.is_empty());
        }
    }

    fn softness(&self, constraint: &Constraint) -> Softness<f32> {
        let (solver, h, epsilon) = (&self.fixture.cpu.assembly().solver, self.h(), self.solving.epsilon);
        if self.solving.is_adaptive != 0 {
            return Softness::stiff(epsilon, solver.acad.form, h);
        }
        Softness::spring(constraint.k, constraint.damping, epsilon, solver.ice.form, h)
    }

    pub fn set_up(&mut self) {
        for number in 0..self.work.constraints.len() {
            let constraint = self.work.constraints[number];
            let pull = self.work.rows[number].x * self.work.scales[number][0];
            (self.work.rows[number], self.work.scales[number]) = (Row::default(), [0.0; 2]);
            if constraint.is_active == 0 {
                continue;
            }
            let [a, b] = [constraint.a, constraint.b].map(|end| self.fixture.old.position[end as usize]);
            let softness = self.softness(&constraint);
            let aim = self.solving.aim * constraint.rest_length;
            let row = softness.row(sub(three(b), three(a)), a[3] + b[3], aim);
            let SetUp { direction, compliance, right, scale } = row;
            let start = if scale > 0.0 { pull / scale } else { 0.0 };
            let s = noise(&row, softness.rate, three(a));
            self.work.rows[number] = Row { direction, r: start, w: 0.0, s, p: right, x: start };
            self.work.scales[number] = [scale, compliance];
        }
        for solve in &mut self.work.solves {
            if solve.constraints > 0 {
                (solve.kept, solve.next) = (CgState::default(), CgState::default());
            }
        }
    }

    /// The pulls of constraints at a node, as long as `of` says, and where they stand.
    fn pulls(&self, incident: &[(usize, u32)], of: impl Fn(&Row) -> f32) -> (Vec<Quad<f32>>, Vec<u32>) {
        let rows = incident.iter().map(|&(number, _)| &self.work.rows[number]);
        let row_forces = rows.map(|row| force_along(row, of(row))).collect();
        (row_forces, (0..).zip(incident).map(|(at, &(_, end))| 2 * at + end).collect())
    }

    /// What they do to its velocity, held by a surface or not.
    fn answer(&self, node: usize, (row_forces, entries): (Vec<Quad<f32>>, Vec<u32>), held: bool) -> [f32; 3] {
        let (predicted, mut out) = (predicted_in(&self.work.predicted_contacts[node]), Quad::default());
        let kernel = GatherConstraintForces {
            spans: &[[0, entries.len() as u32]],
            entries: &entries,
            row_forces: &row_forces,
            places: &[0],
            inverse_mass: &[self.fixture.old.position[node][3]],
            predicted: if held { from_ref(&predicted) } else { &[] },
            out: from_mut(&mut out),
        };
        kernel.run();
        three(out.0)
    }

    /// A node as it comes to surfaces.
    fn approach(&self, node: usize, incident: &[(usize, u32)]) -> Approach<f32> {
        let (x, free) = (self.fixture.old.position[node], three(self.work.new_velocity[node]));
        let h = self.h();
        let pulls = scale(self.answer(node, self.pulls(incident, |row| row.x), false), -h);
        Approach {
            position: three(x),
            free,
            solver_change: pulls,
            reach: reach(self.fixture.records()[SUBSTEP].gravity, h),
            h,
        }
    }

    pub fn predict_mesh_contacts(&mut self) {
        let incident = self.incident();
        for (node, _) in self.nodes() {
            let is_free = self.fixture.old.position[node][3] > 0.0;
            if self.work.predicted_contacts[node].is_constrained != 0
                && is_free
                && self.solving.is_adaptive == 0
            {
                self.work.predicted_contacts[node] =
                    deepest_mesh_contact(self.fixture, node, &self.approach(node, &incident[node]));
            }
        }
    }

    pub fn predict_contacts(&mut self) {
        let (incident, h) = (self.incident(), self.h());
        let held = !self.fixture.substep().colliders().is_empty() && self.solving.is_adaptive == 0;
        for (node, _) in self.nodes() {
            if self.work.predicted_contacts[node].is_constrained == 0 {
                continue;
            }
            let (x, free) = (self.fixture.old.position[node], three(self.work.new_velocity[node]));
            let mut rate = free.map(|c| c / h);
            if held && x[3] > 0.0 {
                let approach = self.approach(node, &incident[node]);
                let colliders = self.fixture.substep().met_colliders().at(node);
                self.work.predicted_contacts[node] =
                    deepest_contact(colliders, &approach, &self.work.predicted_contacts[node]);
            }
            if held {
                rate = predicted_in(&self.work.predicted_contacts[node]).rate(rate, h);
            }
            self.work.response[node] = [rate[0], rate[1], rate[2], 0.0];
        }
    }

    pub fn start(&mut self) {
        for number in (0..self.work.rows.len()).filter(|&number| self.work.constraints[number].is_active != 0)
        {
            self.work.rows[number].p += self.apply(number, 0.0)[0];
        }
        if self.solving.is_warm == 0 {
            self.work.rows.iter_mut().for_each(|row| (row.x, row.r) = (0.0, 0.0));
        }
    }

    /// The system applied to a vector of this number at a row, and that number by itself and by the product.
    fn apply(&self, number: usize, vector: f32) -> [f32; 3] {
        let (constraint, compliance) = (self.work.constraints[number], self.work.scales[number][1]);
        let response = [constraint.a, constraint.b].map(|end| Quad(self.work.response[end as usize]));
        let mut product = 0.0;
        let kernel = Apply {
            rows: &[quad(&self.work.rows[number], compliance)],
            ends: &[[0, 1]],
            response: &response,
            vector: &[vector],
            out: from_mut(&mut product),
        };
        let [squared, along] = kernel.run();
        [product, squared as f32, along as f32]
    }

    fn next_state(&self, kept: CgState, sums: [f32; 4]) -> CgState {
        let [first, second, along, curvature] = sums;
        let mut next = CgState { alpha: 0.0, beta: 0.0, ..kept };
        match kept.passes {
            0 => {}
            1 => {
                (next.right, next.limit) = (first, limit(self.solving.tolerance_squared, first, second));
                next.alpha = warm_start_factor(along, curvature);
            }
            passes => {
                next.gamma = first;
                let step = Conjugate { gamma: kept.gamma, alpha: kept.alpha }.next(first, second);
                let is_left = is_left(first, next.limit, passes - 2, self.solving.most_iterations);
                next.is_done = u32::from(!(is_left && step.is_there));
                (next.alpha, next.beta) = (step.alpha, step.beta);
            }
        }
        next
    }

    /// The sums over the rows of a system, of its groups in the order of lanes.
    pub fn body_sums(&self, solve: usize) -> [f32; 4] {
        let groups = &self.fixture.tables.constraints.constraint_groups;
        let Some(first) = groups.iter().position(|g| g.solve as usize == solve) else { return [0.0; 4] };
        let count = self.work.solves[solve].active_constraints.div_ceil(GROUP as u32) as usize;
        by_lanes(&self.work.sums[first..first + count])
    }

    fn is_open(&self, solve: usize) -> bool {
        self.work.solves[solve].active_constraints > 0 && self.work.solves[solve].kept.is_done == 0
    }

    pub fn step_nodes(&mut self) {
        let open: Vec<usize> = (0..self.work.solves.len()).filter(|&solve| self.is_open(solve)).collect();
        for &solve in &open {
            self.work.solves[solve].next =
                self.next_state(self.work.solves[solve].kept, self.body_sums(solve));
        }
        let incident = self.incident();
        for (node, solve) in self.nodes() {
            let next = self.work.solves[solve].next;
            if !open.contains(&solve)
                || next.is_done != 0
                || self.work.predicted_contacts[node].is_constrained == 0
            {
                continue;
            }
            let pulls = self.pulls(&incident[node], |row| stepped(row, &next).r);
            let [x, y, z] = self.answer(node, pulls, true);
            self.work.response[node] = [x, y, z, 0.0];
        }
    }

    pub fn step_rows(&mut self) {
        let groups = self.fixture.tables.constraints.constraint_groups.clone();
        for (index, group) in groups.iter().enumerate() {
            let solve = &mut self.work.solves[group.solve as usize];
            let next = solve.next;
            if index == group.first_group as usize {
                solve.kept = CgState { passes: next.passes + 1, ..next };
            }
            let (active, first) =
                (solve.active_constraints as usize, GROUP * (index - group.first_group as usize));
            if next.is_done != 0 || first >= active {
                continue;
            }
            let base = groups[group.first_group as usize].first as usize;
            let mut lanes = vec![[0.0; 4]; GROUP];
            for (lane, terms) in lanes.iter_mut().enumerate().take(active - first) {
                let number = self.work.active_constraints[base + first + lane] as usize;
                *terms = self.advance(number, &next);
            }
            self.work.sums[index] = by_halves(lanes);
        }
    }

    fn advance(&mut self, number: usize, step: &CgState) -> [f32; 4] {
        let row = stepped(&self.work.rows[number], step);
        let [product, squared, along] = self.apply(number, row.r);
        self.work.rows[number] = Row { w: product, ..row };
        match step.passes {
            // The right side, the noise, and the pulls to start from.
            0 => [row.p * row.p, row.s * row.s, row.x * row.p, row.x * product],
            _ => [squared, along, 0.0, 0.0],
        }
    }

    pub fn pull(&mut self) {
        let incident = self.incident();
        for (node, _) in self.nodes() {
            let record = self.work.predicted_contacts[node];
            if record.is_constrained == 0 {
                continue;
            }
            let (row_forces, entries) = self.pulls(&incident[node], |row| row.x);
            let mut pull = three(gather(&entries, &row_forces).0).map(|c| -c);
            if predicted_in(&record).in_contact() {
                pull = self.with_contact(node, &record, pull);
            }
            let [x, y, z] = add(three(self.work.force[node]), pull);
            self.work.force[node] = [x, y, z, 0.0];
        }
    }

    /// The force of pulls on a node with what a surface does about it.
    fn with_contact(&self, node: usize, record: &ContactRecord, pull: [f32; 3]) -> [f32; 3] {
        let (x, free) = (self.fixture.old.position[node], three(self.work.new_velocity[node]));
        let surface = &self.fixture.substep().met_colliders().at(node)[record.collider as usize].surface;
        predicted_in(record).force_with_contact(free, pull, self.h() * x[3], surface)
    }

    /// Workgroups of the next iterations.
    pub fn counts(&self) -> Vec<u32> {
        let any = (0..self.work.solves.len()).any(|solve| self.is_open(solve));
        let tables = &self.fixture.tables.constraints;
        let of = |groups: usize| if any { [groups as u32, 1, 1] } else { [0, 1, 1] };
        [of(tables.node_groups.len()), of(tables.constraint_groups.len())].concat()
    }

    pub fn note(&mut self) {
        let solves = self.work.solves.clone();
        let statistics = &mut self.work.statistics;
        let (mut constraints, mut active, mut capped) = (0, 0, false);
        for solve in &solves {
            (constraints, active) = (constraints + solve.constraints, active + solve.active_constraints);
            if solve.active_constraints == 0 {
                continue;
            }
            let done = solve.next;
            let left = residual_fraction(done.gamma, done.right, done.limit, self.solving.tolerance_squared);
            capped |= done.gamma > done.limit;
            statistics.iterations = statistics.iterations.max(done.passes.max(2) - 2);
            statistics.residual = statistics.residual.max(left);
        }
        statistics.capped += u32::from(capped);
        statistics.active_fraction =
            statistics.active_fraction.max(active as f32 / constraints.max(1) as f32);
    }
}
