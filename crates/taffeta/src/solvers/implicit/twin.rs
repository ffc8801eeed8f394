//! Drivers that take the CPU's formulas and kernels of springs by nodes through the GPU's arrays, in the order in which the GPU
//! takes sums.

use crate::contact::colliders::predicted_contact::{Approach, PredictedContact, reach};
use crate::cpu::simd::Kernel;
use crate::gpu::layout::{Four, GROUP, Solving};
use crate::parity::fixture::{Fixture, SUBSTEP};
use crate::real::{add, dot, scale, sub, times};
use crate::solvers::dual::distance::{Conjugate, warm_start_factor};
use crate::solvers::dual::gpu_layout::{ContactRecord, SolveStatistics};
use crate::solvers::dual::twin::{
    by_halves, by_lanes, contact_record, deepest_contact, deepest_mesh_contact, predicted_in, three,
};
use crate::solvers::explicit::euler;
use crate::solvers::implicit::couplings_twin::OfElements;
use crate::solvers::implicit::cpu::kernels::Advance;
use crate::solvers::implicit::gpu_layout::{
    Diagonal, LevelGroup, NodeSolve, PcgState, SlotSpring, Symmetric, Vector,
};
use crate::solvers::implicit::implicit::{
    Stiff, add_weighted, block, diagonal, edge_times, inverse, is_solved, jacobi, leaves_much,
    residual_fraction, right_side, velocity_change,
};
use crate::topology::LANES;
use std::slice::from_mut;

/// The arrays that kernels of springs by nodes work on.
#[derive(Clone)]
pub struct Work {
    pub blocks: Vec<Four>,
    pub coarse: Vec<Symmetric>,
    pub diagonals: Vec<Diagonal>,
    /// By sort, then by node.
    pub vectors: Vec<Four>,
    pub predicted_contacts: Vec<ContactRecord>,
    pub solves: Vec<NodeSolve>,
    pub sums: Vec<Four>,
    pub force: Vec<Four>,
    pub new_velocity: Vec<Four>,
    pub new_position: Vec<Four>,
    pub statistics: SolveStatistics,
    /// Steps that are written down, as `written_steps`.
    pub steps: [u32; 4],
    pub elements: OfElements,
}

/// A fixture's work, as its kernels find it.
pub struct Twin<'a> {
    pub fixture: &'a Fixture,
    pub solving: Solving,
    /// Whether contacts of surfaces are part of the systems, and join them.
    pub in_contact: bool,
    pub work: Work,
}

pub fn six(m: &Symmetric) -> [f32; 6] {
    let ([xx, yy, zz], [xy, xz, yz]) = (m.diagonal, m.mixed);
    [xx, yy, zz, xy, xz, yz]
}

pub fn record([xx, yy, zz, xy, xz, yz]: [f32; 6]) -> Symmetric {
    Symmetric { diagonal: [xx, yy, zz], mixed: [xy, xz, yz], ..Symmetric::default() }
}

fn sum_of(a: [f32; 6], b: [f32; 6]) -> [f32; 6] {
    std::array::from_fn(|i| a[i] + b[i])
}

/// A sum, and a spring's block times a vector: the part along it first.
fn add_block_times(sum: [f32; 3], [x, y, z, across]: Four, u: [f32; 3]) -> [f32; 3] {
    add(add(sum, edge_times([x, y, z], 0.0, u)), edge_times([0.0; 3], across, u))
}

/// A sum, and a spring's block: the part along it first.
fn add_block(sum: [f32; 6], q: [f32; 3], across: f32) -> [f32; 6] {
    sum_of(sum_of(sum, block(q, 0.0)), block([0.0; 3], across))
}

impl Twin<'_> {
    pub fn h(&self) -> f32 {
        self.fixture.substep().h
    }

    pub(super) fn at(&self, which: Vector, node: usize) -> usize {
        which as usize * self.fixture.tables.multigrid.nodes + node
    }

    pub fn get(&self, which: Vector, node: usize) -> [f32; 3] {
        three(self.work.vectors[self.at(which, node)])
    }

    pub fn put(&mut self, which: Vector, node: usize, [x, y, z]: [f32; 3]) {
        let at = self.at(which, node);
        self.work.vectors[at] = [x, y, z, 0.0];
    }

    pub(super) fn mass(&self, node: usize) -> f32 {
        self.work.vectors[self.at(Vector::Residual, node)][3]
    }

    pub(super) fn predicted(&self, node: usize) -> PredictedContact<f32> {
        predicted_in(&self.work.predicted_contacts[node])
    }

    /// Slots of a node among those of its sort, and the nodes that they lead to.
    pub fn slots(&self, node: usize) -> Vec<(usize, usize)> {
        let slots = &self.fixture.tables.multigrid.slots;
        let slice = node / LANES;
        let first = if node < self.fixture.tables.len() { slots[1] } else { slots[0] } as usize;
        let range = slots[1 + slice] as usize + node % LANES..slots[2 + slice] as usize;
        range.step_by(LANES).map(|at| (at - first, slots[at] as usize)).collect()
    }

    /// Nodes of some groups, with the number of their system.
    pub fn nodes(groups: &[LevelGroup]) -> Vec<(usize, usize)> {
        let nodes = |g: &LevelGroup| g.first as usize..(g.first + g.count) as usize;
        groups.iter().flat_map(|g| nodes(g).map(|node| (node, g.solve as usize))).collect()
    }

    /// Nodes of the finest level.
    pub fn finest(&self) -> Vec<(usize, usize)> {
        Self::nodes(&self.fixture.tables.multigrid.groups[0])
    }

    /// Those of some groups whose system is not done.
    pub(super) fn open(&self, groups: &[LevelGroup]) -> Vec<usize> {
        let is_open = |&(_, solve): &(usize, usize)| self.work.solves[solve].next.is_done == 0;
        Self::nodes(groups).into_iter().filter(is_open).map(|(node, _)| node).collect()
    }

    pub fn free(&mut self) {
        let (old, gravity) = (&self.fixture.old, self.fixture.records()[SUBSTEP].gravity);
        for (node, _) in self.finest() {
            let (w, v, force) = (old.position[node][3], old.velocity[node], self.work.force[node]);
            let u = [0, 1, 2].map(|i| euler::velocity(v[i], force[i], w, gravity[i], self.h()));
            self.work.new_velocity[node] = [u[0], u[1], u[2], v[3].abs()];
        }
    }

    /// A node as it comes to surfaces.
    fn approach(&self, node: usize) -> Approach<f32> {
        let (x, free) = (self.fixture.old.position[node], three(self.work.new_velocity[node]));
        let (gravity, h) = (self.fixture.records()[SUBSTEP].gravity, self.h());
        Approach {
            position: three(x),
            free,
            solver_change: self.get(Vector::SpringChange, node),
            reach: reach(gravity, h),
            h,
        }
    }

    pub fn predict_mesh_contacts(&mut self) {
        for (node, _) in self.finest() {
            if self.fixture.old.position[node][3] > 0.0 {
                self.work.predicted_contacts[node] =
                    deepest_mesh_contact(self.fixture, node, &self.approach(node));
            }
        }
    }

    pub fn predict_contacts(&mut self) {
        for (node, _) in self.finest() {
            let (x, approach) = (self.fixture.old.position[node], self.approach(node));
            self.work.predicted_contacts[node] = if x[3] > 0.0 {
                deepest_contact(
                    self.fixture.substep().met_colliders().at(node),
                    &approach,
                    &self.work.predicted_contacts[node],
                )
            } else {
                contact_record(PredictedContact { slides: 0.0, ..PredictedContact::FREE }, 0, true)
            };
            self.begin_node(node);
        }
        for (number, solve) in (0..).zip(&mut self.work.solves) {
            *solve = NodeSolve { first: number, ..NodeSolve::default() };
        }
    }

    /// Where the first Newton step starts at a node that is held as was found.
    pub(super) fn begin_node(&mut self, node: usize) {
        let is_free = self.fixture.old.position[node][3] > 0.0;
        let (predicted, v) = (self.predicted(node), three(self.fixture.old.velocity[node]));
        let outside = three(self.work.new_velocity[node]);
        let free = self.begin(node, outside);
        let total = if is_free { sub(predicted.carried_velocity(v), free) } else { [0.0; 3] };
        let spring_change = add(self.get(Vector::SpringChange, node), sub(outside, free));
        let start = predicted.filtered(sub(spring_change, sub(total, predicted.friction_change())));
        self.put(Vector::Change, node, [0.0; 3]);
        self.put(Vector::Cycled, node, if self.solving.is_warm != 0 { start } else { [0.0; 3] });
        self.set_trial_state(node, total);
        let mass = self.solving.mass * self.fixture.old.velocity[node][3].abs();
        let [residual, at] = [Vector::Residual, Vector::Total].map(|which| self.at(which, node));
        self.work.vectors[residual] = [0.0, 0.0, 0.0, mass];
        let off = if is_free { sub(v, free) } else { [0.0; 3] };
        self.work.vectors[at][3] = mass * dot(off, off);
    }

    /// From where a node's system starts; returns its velocity without springs, that of outer forces in Euler's step given.
    fn begin(&mut self, node: usize, outside: [f32; 3]) -> [f32; 3] {
        let (x, v) = (self.fixture.old.position[node], three(self.fixture.old.velocity[node]));
        let (h, whole) = (self.solving.inner, self.h());
        let [mut start, mut free] = [add(three(x), scale(outside, whole - h)), outside];
        if x[3] > 0.0 {
            start = three(x);
            if let Some(scheme) = self.fixture.substep().scheme() {
                let [b, a] = self.motion(node);
                start = scheme.base_place(start, b, a);
                free = scheme.free_velocity(b, a, sub(outside, v));
            }
        } else {
            self.put(Vector::Rate, node, [0.0; 3]);
        }
        self.put(Vector::Start, node, start);
        self.put(Vector::Free, node, free);
        free
    }

    /// Velocity and acceleration with which a node goes on.
    fn motion(&self, node: usize) -> [[f32; 3]; 2] {
        let (v, a) = (three(self.fixture.old.velocity[node]), self.get(Vector::Rate, node));
        let predicted = self.predicted(node);
        if predicted.in_contact() { [predicted.carried_velocity(v), predicted.filtered(a)] } else { [v, a] }
    }

    /// Keeps the acceleration of a node whose velocity has changed by `found`; returns the change by outer forces and all.
    fn keep_rate(&mut self, node: usize, found: [f32; 3]) -> [f32; 3] {
        let Some(&scheme) = self.fixture.substep().scheme() else { return found };
        let (u, predicted) = (add(self.get(Vector::Free, node), found), self.predicted(node));
        let [b, a] = self.motion(node);
        let rate = if predicted.in_contact() {
            predicted.filtered(scheme.next_rate(sub(u, predicted.friction_change()), b, a))
        } else {
            scheme.next_rate(u, b, a)
        };
        self.put(Vector::Rate, node, rate);
        sub(u, three(self.work.new_velocity[node]))
    }

    pub fn place(&mut self) {
        for (node, _) in self.finest() {
            let x = self.work.new_position[node];
            if self.fixture.old.position[node][3] > 0.0 && self.solving.is_second != 0 {
                let (start, v) = (self.get(Vector::Start, node), self.work.new_velocity[node]);
                let at = [0, 1, 2].map(|i| start[i] + self.solving.inner * v[i]);
                self.work.new_position[node] = [at[0], at[1], at[2], x[3]];
            }
        }
    }

    /// Place and velocity with a change of the velocity without springs.
    pub(super) fn set_trial_state(&mut self, node: usize, total: [f32; 3]) {
        let velocity = add(self.get(Vector::Free, node), total);
        let (x, h) = (self.get(Vector::Start, node), self.solving.inner);
        self.put(Vector::Total, node, total);
        self.put(Vector::Direction, node, [0, 1, 2].map(|i| euler::position(x[i], velocity[i], h)));
        self.put(Vector::DirectionProduct, node, velocity);
    }

    pub fn set_up(&mut self) {
        for (node, _) in self.finest() {
            let (mut impulse, mut springs) = self.add_up(node);
            if self.is_coupled() {
                impulse = add(impulse, self.get(Vector::Impulse, node));
                springs = sum_of(springs, six(&self.work.diagonals[node].own));
                self.keep_sum(node, springs);
            }
            let (mass, predicted) = (self.mass(node), self.predicted(node));
            let all = sum_of(springs, [mass, mass, mass, 0.0, 0.0, 0.0]);
            let is_free = self.fixture.old.position[node][3] > 0.0;
            let (own, inverse) = diagonal(&all, mass, is_free, &predicted);
            self.work.diagonals[node] = Diagonal { own: record(own), inverse: record(inverse) };
            self.put(Vector::Impulse, node, impulse);
            let off = sub(self.get(Vector::Total, node), predicted.friction_change());
            let right = right_side(impulse, mass, off);
            let [x, y, z] = right;
            let at = self.at(Vector::Residual, node);
            self.work.vectors[at] = [x, y, z, mass];
        }
    }

    /// Blocks of a node's springs; their impulse and their sum.
    fn add_up(&mut self, node: usize) -> ([f32; 3], [f32; 6]) {
        let h = self.solving.inner;
        let (x, v) = (self.get(Vector::Direction, node), self.get(Vector::DirectionProduct, node));
        let (mut impulse, mut diagonal) = ([0.0; 3], [0.0; 6]);
        for (slot, other) in self.slots(node) {
            let SlotSpring { k, damping, rest_length } = self.fixture.tables.multigrid.slot_springs[slot];
            let d = sub(self.get(Vector::Direction, other), x);
            let dv = sub(self.get(Vector::DirectionProduct, other), v);
            let stiff = Stiff::new(k, damping, h);
            let spring = stiff.spring(d, rest_length);
            let [qx, qy, qz] = spring.q;
            self.work.blocks[slot] = [qx, qy, qz, spring.across];
            // Drivers may take h out of the sum: the kernel has it so from the first.
            let pull = Stiff { h: 1.0, ..stiff };
            let given = h * pull.impulse(&pull.spring(d, rest_length), dv);
            impulse = add_weighted(impulse, given, spring.along);
            diagonal = add_block(diagonal, spring.q, spring.across);
        }
        (impulse, diagonal)
    }

    /// Blocks of the edges of a coarser level.
    pub fn coarsen_edges(&mut self, level: usize) {
        let multigrid = &self.fixture.tables.multigrid;
        for edge in &multigrid.edges[level - 1] {
            let mut sum = [0.0; 6];
            for share in &multigrid.edge_weights[edge.first as usize..(edge.first + edge.count) as usize] {
                let at = share.at as usize;
                let source = if level == 1 {
                    let [x, y, z, across] = self.work.blocks[at];
                    block([x, y, z], across)
                } else {
                    six(&self.work.coarse[at])
                };
                sum = add_weighted(sum, share.weight, source);
            }
            edge.slots.iter().for_each(|&slot| self.work.coarse[slot as usize] = record(sum));
        }
    }

    /// Children of a node, and how much they follow it.
    pub fn children(&self, node: usize) -> Vec<(usize, f32)> {
        let children = &self.fixture.tables.multigrid.children;
        let range = children[node].at as usize..children[node + 1].at as usize;
        children[range].iter().map(|share| (share.at as usize, share.weight)).collect()
    }

    pub fn coarsen_nodes(&mut self, level: usize) {
        for (node, _) in Self::nodes(&self.fixture.tables.multigrid.groups[level]) {
            let mut own = [0.0; 6];
            for (child, weight) in self.children(node) {
                own = add_weighted(own, weight, six(&self.work.diagonals[child].own));
            }
            let add_slot = |all, (slot, _): (usize, usize)| sum_of(all, six(&self.work.coarse[slot]));
            let all = self.slots(node).into_iter().fold(own, add_slot);
            self.work.diagonals[node] = Diagonal { own: record(own), inverse: record(inverse(&all)) };
        }
    }

    /// Whether other elements are solved for beside springs.
    fn is_coupled(&self) -> bool {
        !self.work.elements.words.is_empty()
    }

    /// The finest level's system times a vector.
    pub(super) fn system_times(&self, mass: f32, which: Vector, node: usize) -> [f32; 3] {
        let springs = self.springs_times(mass, which, node);
        let all = if self.is_coupled() { self.add_coupled(springs, which, node) } else { springs };
        if self.in_contact { add(all, self.get(Vector::Taken, node)) } else { all }
    }

    /// Masses and springs of the finest level times a vector.
    fn springs_times(&self, mass: f32, which: Vector, node: usize) -> [f32; 3] {
        let own = self.get(which, node);
        let add_slot = |sum, (slot, other): (usize, usize)| {
            add_block_times(sum, self.work.blocks[slot], sub(own, self.get(which, other)))
        };
        self.slots(node).into_iter().fold(scale(own, mass), add_slot)
    }

    /// A coarser level's system times a vector.
    pub(super) fn level_times(&self, which: Vector, node: usize) -> [f32; 3] {
        let own = self.get(which, node);
        let add_slot = |sum, (slot, other): (usize, usize)| {
            add(sum, times(&six(&self.work.coarse[slot]), sub(own, self.get(which, other))))
        };
        let start = times(&six(&self.work.diagonals[node].own), own);
        if self.is_coupled() {
            return self.add_coupled(start, which, node);
        }
        self.slots(node).into_iter().fold(start, add_slot)
    }

    pub(super) fn jacobi(&self, node: usize, residual: [f32; 3]) -> [f32; 3] {
        jacobi(&six(&self.work.diagonals[node].inverse), residual)
    }

    fn is_solved(&self, done: &PcgState) -> bool {
        is_solved(done.error, done.whole, self.solving.tolerance_squared)
    }

    fn next_pcg_state(&self, solve: &NodeSolve, [first, second, third, _]: [f32; 4]) -> PcgState {
        let kept = solve.kept;
        let mut next = PcgState { alpha: 0.0, beta: 0.0, ..kept };
        if kept.passes < 2 {
            next.alpha = warm_start_factor(first, second);
            next.whole = if kept.whole > 0.0 { kept.whole } else { third };
            return next;
        }
        if self.is_met_before(solve, first) {
            next.is_done = 1;
            return next;
        }
        let is_first = kept.iterations == 0;
        if is_first && solve.before == 0 {
            next.whole = first.max(kept.whole);
        }
        next.error = first;
        let gamma = if is_first { 0.0 } else { kept.error };
        let step = Conjugate { gamma, alpha: kept.alpha }.next(first, second);
        if !step.is_there {
            next.is_done = 1;
            return next;
        }
        (next.iterations, next.alpha, next.beta) = (kept.iterations + 1, step.alpha, step.beta);
        let is_last = self.is_solved(&next) || next.iterations == self.solving.most_iterations;
        next.is_done = is_last.into();
        next
    }

    fn is_met_before(&self, solve: &NodeSolve, left: f32) -> bool {
        let is_further = self.solving.is_automatic != 0 && solve.steps > 0;
        let is_first_product = solve.kept.passes >= 2 && solve.kept.iterations == 0;
        is_further && is_first_product && !leaves_much(left, solve.motion)
    }

    pub fn body_sums(&self, solve: usize) -> [f32; 4] {
        self.sums_of(solve, 0)
    }

    /// The sums over a system of the sort that begins `from` there.
    pub(super) fn sums_of(&self, solve: usize, from: usize) -> Four {
        let groups = (from..).zip(&self.fixture.tables.multigrid.groups[0]);
        if self.in_contact {
            let first = |solve: usize| self.work.solves[solve].first;
            let joined = |group: &LevelGroup| first(group.solve as usize) == first(solve);
            let of = |(at, group)| if joined(group) { self.work.sums[at] } else { [0.0; 4] };
            return by_lanes(&groups.map(of).collect::<Vec<Four>>());
        }
        let own = groups.filter(|(_, group)| group.solve as usize == solve);
        by_lanes(&own.map(|(at, _)| self.work.sums[at]).collect::<Vec<Four>>())
    }

    pub fn step(&mut self) {
        let open: Vec<usize> =
            (0..self.work.solves.len()).filter(|&solve| self.work.solves[solve].kept.is_done == 0).collect();
        for &solve in &open {
            let (own, sums) = (self.work.solves[solve], self.body_sums(solve));
            self.work.solves[solve].next = self.next_pcg_state(&own, sums);
            self.work.solves[solve].is_met = self.is_met_before(&own, sums[0]).into();
        }
        for (node, solve) in self.finest() {
            let NodeSolve { kept, next, .. } = self.work.solves[solve];
            let is_stuck = next.is_done != 0 && next.iterations == kept.iterations;
            if open.contains(&solve) && !is_stuck {
                self.advance(node, &next);
            }
        }
    }

    fn advance(&mut self, node: usize, step: &PcgState) {
        let get = |which| self.get(which, node);
        let [mut residual, product, mut change] =
            [Vector::Residual, Vector::Product, Vector::Change].map(get);
        let [mut direction, mut direction_product] = [Vector::Direction, Vector::DirectionProduct].map(get);
        let cycled = self.get(Vector::Cycled, node);
        if step.passes < 2 {
            change = add_weighted(change, step.alpha, cycled);
            residual = add_weighted(residual, -step.alpha, product);
            (direction, direction_product) = ([0.0; 3], [0.0; 3]);
        } else {
            let [x, r, p, s] = [&mut change, &mut residual, &mut direction, &mut direction_product]
                .map(|v| v.each_mut().map(from_mut));
            let [z, w] = [&cycled, &product].map(|v| v.each_ref().map(std::slice::from_ref));
            Advance { alpha: step.alpha, beta: step.beta, x, r, p, s, z, w }.run();
        }
        self.put(Vector::Change, node, change);
        self.put(Vector::Direction, node, direction);
        self.put(Vector::DirectionProduct, node, direction_product);
        let (mass, at) = (self.mass(node), self.at(Vector::Residual, node));
        self.work.vectors[at] = [residual[0], residual[1], residual[2], mass];
        self.put(Vector::Cycle, node, self.jacobi(node, residual));
    }

    pub fn apply(&mut self) {
        let groups = self.fixture.tables.multigrid.groups[0].clone();
        for (index, group) in groups.iter().enumerate() {
            let solve = &mut self.work.solves[group.solve as usize];
            let next = solve.next;
            if index == group.first_group as usize {
                solve.kept = PcgState { passes: next.passes + 1, ..next };
            }
            if next.is_done != 0 {
                continue;
            }
            let mut lanes = vec![[0.0; 4]; GROUP];
            for (lane, terms) in lanes.iter_mut().enumerate().take(group.count as usize) {
                *terms = self.apply_to(group.first as usize + lane);
            }
            self.work.sums[index] = by_halves(lanes);
        }
    }

    fn apply_to(&mut self, node: usize) -> [f32; 4] {
        let product = self.system_times(self.mass(node), Vector::Cycled, node);
        let product = self.predicted(node).filtered(product);
        self.put(Vector::Product, node, product);
        let (residual, cycled) = (self.get(Vector::Residual, node), self.get(Vector::Cycled, node));
        [dot(cycled, residual), dot(cycled, product), 0.0, 0.0]
    }

    pub fn start(&mut self) {
        let groups = self.fixture.tables.multigrid.groups[0].clone();
        for (index, group) in groups.iter().enumerate() {
            let solve = &mut self.work.solves[group.solve as usize];
            if index == group.first_group as usize && solve.is_met == 0 {
                solve.kept.passes = 1;
            }
            let mut lanes = vec![[0.0; 4]; GROUP];
            for (lane, terms) in lanes.iter_mut().enumerate().take(group.count as usize) {
                *terms = self.start_at(group.first as usize + lane);
            }
            self.work.sums[index] = by_halves(lanes);
        }
    }

    fn start_at(&mut self, node: usize) -> [f32; 4] {
        let (mass, predicted) = (self.mass(node), self.predicted(node));
        let residual = predicted.filtered(self.get(Vector::Residual, node));
        let at = self.at(Vector::Residual, node);
        self.work.vectors[at] = [residual[0], residual[1], residual[2], mass];
        let product = predicted.filtered(self.system_times(mass, Vector::Cycled, node));
        self.put(Vector::Product, node, product);
        let (start, off) = (self.get(Vector::Cycled, node), self.at(Vector::Total, node));
        [dot(start, residual), dot(start, product), self.work.vectors[off][3], 0.0]
    }

    pub fn impulses(&mut self) {
        let is_open = |&(_, solve): &(usize, usize)| self.work.solves[solve].is_met == 0;
        let nodes: Vec<usize> = self.finest().into_iter().filter(is_open).map(|(node, _)| node).collect();
        self.all(&nodes, Vector::Given, |twin, node| {
            sub(twin.get(Vector::Impulse, node), twin.system_times(0.0, Vector::Change, node))
        });
    }

    pub fn push(&mut self) {
        for (node, _) in self.finest() {
            let (x, record) = (self.fixture.old.position[node], self.work.predicted_contacts[node]);
            if x[3] <= 0.0 {
                let force = scale(self.get(Vector::Given, node), 1.0 / self.solving.inner);
                let [x, y, z] = add(three(self.work.force[node]), force);
                self.work.force[node] = [x, y, z, 0.0];
                continue;
            }
            let predicted = self.predicted(node);
            let found = add(self.get(Vector::Total, node), self.get(Vector::Change, node));
            let found = self.keep_rate(node, found);
            let springs = scale(self.get(Vector::Given, node), self.solving.whole * x[3]);
            let spring_change = velocity_change(&predicted, found, springs);
            let mut change = spring_change;
            if predicted.in_contact() {
                let free = three(self.work.new_velocity[node]);
                let surface =
                    &self.fixture.substep().met_colliders().at(node)[record.collider as usize].surface;
                change = predicted.with_contact(free, spring_change, surface);
            }
            self.put(Vector::SpringChange, node, spring_change);
            let force = scale(change, self.fixture.old.velocity[node][3].abs() / self.h());
            let [x, y, z] = add(three(self.work.force[node]), force);
            self.work.force[node] = [x, y, z, 0.0];
        }
    }

    pub fn note(&mut self) {
        let statistics = &mut self.work.statistics;
        let mut capped = false;
        for solve in &self.work.solves {
            let done = solve.next;
            capped |= !is_solved(done.error, done.whole, self.solving.tolerance_squared);
            statistics.iterations = statistics.iterations.max(solve.before + done.iterations);
            statistics.residual = statistics.residual.max(residual_fraction(done.error, done.whole));
        }
        statistics.capped += u32::from(capped);
        statistics.active_fraction = 1.0;
    }
}
