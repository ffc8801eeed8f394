//! Drivers that take the CPU's formulas of Newton steps through the GPU's arrays.

use crate::gpu::layout::{Four, GROUP};
use crate::real::{add, dot};
use crate::solvers::dual::twin::{by_halves, three};
use crate::solvers::implicit::gpu_layout::{NodeSolve, PcgState, Vector, When};
use crate::solvers::implicit::implicit::{MOST_STEPS, motion};
use crate::solvers::implicit::twin::Twin;

impl Twin<'_> {
    pub fn next_newton_step(&mut self) {
        for (node, _) in self.finest() {
            let total = add(self.get(Vector::Total, node), self.get(Vector::Change, node));
            self.put(Vector::Change, node, [0.0; 3]);
            self.put(Vector::Cycled, node, [0.0; 3]);
            self.set_trial_state(node, total);
        }
        for at in 0..self.work.solves.len() {
            let solve = self.work.solves[at];
            let is_over = self.solving.is_automatic != 0 && !self.may_go_on(&solve);
            let PcgState { whole, error, iterations, .. } = solve.next;
            let is_met = if is_over { 1 } else { solve.is_met };
            let again = PcgState { is_done: is_met, whole, error, ..PcgState::default() };
            let (steps, before) = (solve.steps + 1, solve.before + iterations);
            self.work.solves[at] = NodeSolve { steps, before, is_met, kept: again, next: again, ..solve };
        }
    }

    fn may_go_on(&self, solve: &NodeSolve) -> bool {
        let has_iterations = solve.next.iterations < self.solving.most_iterations;
        solve.is_met == 0 && has_iterations && solve.steps + 1 < MOST_STEPS
    }

    /// What a term of each node adds up to in each group, of one sort.
    fn add_up_groups(&mut self, sort: usize, term: impl Fn(&Self, usize) -> Four) {
        let groups = self.fixture.tables.multigrid.groups[0].clone();
        for (index, group) in groups.iter().enumerate() {
            let mut lanes = vec![[0.0; 4]; GROUP];
            for (lane, own) in lanes.iter_mut().enumerate().take(group.count as usize) {
                *own = term(self, group.first as usize + lane);
            }
            self.work.sums[sort * groups.len() + index] = by_halves(lanes);
        }
    }

    pub fn sum_motion(&mut self) {
        let v = |twin: &Self, node: usize| {
            let is_free = twin.fixture.old.position[node][3] > 0.0;
            if is_free { three(twin.fixture.old.velocity[node]) } else { twin.get(Vector::Free, node) }
        };
        self.add_up_groups(1, |twin, node| {
            let (mass, [x, y, z]) = (twin.mass(node), v(twin, node));
            [mass * x, mass * y, mass * z, mass]
        });
        self.add_up_groups(2, |twin, node| {
            let (mass, off) = (twin.mass(node), twin.work.vectors[twin.at(Vector::Total, node)][3]);
            [mass * dot(v(twin, node), v(twin, node)), off, 0.0, 0.0]
        });
    }

    pub fn weigh_motion(&mut self) {
        let groups = self.fixture.tables.multigrid.groups[0].len();
        for number in 0..self.work.solves.len() {
            let [momentum, squares] = [1, 2].map(|sort| self.sums_of(number, sort * groups));
            self.work.solves[number].motion = motion([squares[1], squares[0]], three(momentum), momentum[3]);
        }
    }

    /// Counts open systems at one place more.
    pub fn count_open(&mut self) {
        let any = self.work.solves.iter().any(|solve| solve.kept.is_done == 0);
        let [place, open_at, ..] = &mut self.work.steps;
        *place += 1;
        *open_at = if any { *place } else { *open_at };
    }

    /// Notes how far a solve came.
    pub fn count_left(&mut self) {
        let is_automatic = self.solving.is_automatic != 0;
        let is_left = |solve: &NodeSolve| is_automatic && self.may_go_on(solve) || solve.next.is_done == 0;
        let [_, open_at, most, left] = self.work.steps;
        self.work.steps = [0, 0, most.max(open_at), left | u32::from(self.work.solves.iter().any(is_left))];
    }

    /// Workgroups that a kernel counts; those of other times stay as they are.
    pub fn counts(&self, entry: &str, other: u32) -> Vec<u32> {
        let solves = &self.work.solves;
        let is_open = |solve: &NodeSolve| solve.kept.is_done == 0;
        let any_open = solves.iter().any(is_open);
        let (when, any) = match entry {
            "count_next_step" => (When::Begun, !any_open && solves.iter().any(|solve| self.may_go_on(solve))),
            _ => (When::Iterated, any_open),
        };
        let all = self.fixture.tables.multigrid.counted();
        all.into_iter()
            .flat_map(|[groups, at]| {
                if at == when as u32 { [if any { groups } else { 0 }, groups.min(1), 1] } else { [other; 3] }
            })
            .collect()
    }
}
