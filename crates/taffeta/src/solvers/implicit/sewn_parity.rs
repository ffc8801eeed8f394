//! Rows of points of nodes that are sewn to each other.

use crate::contact::triangles::parity::{COPIED, MOVED, row};
use crate::gpu::kernels::Name;
use crate::gpu::layout::GROUP;
use crate::parity::bench::{Bench, Given};
use crate::parity::fixture::{Chance, Fixture, SUBSTEP, words};
use crate::parity::row::{Row, Tolerance};
use crate::real::{Symmetric, add, scale, sub};
use crate::scene::{ConstraintForm, Method, Solver};
use crate::solvers::explicit::parity::kernel_of;
use crate::solvers::implicit::contacts_twin::first_of;
use crate::solvers::implicit::gpu_layout::{Vector, Weight};
use crate::solvers::implicit::parity_work::{POISON, arrays, compare, work};
use crate::solvers::implicit::sewn::{Matrix, matrix_times, parallel, transposed_times};
use crate::solvers::implicit::twin::{Twin, record, six};

const REORDERED: &str = "differences of differences, which drivers may take in another order";

/// One row for each kernel.
pub const ROWS: &[Row] = &[
    Row {
        name: "begin_points",
        entry: "begin_points",
        tolerance: Tolerance::new(8.0, 512.0, REORDERED),
        check: |bench| each(bench, "begin_points", |twin| twin.begin()),
    },
    row("weigh_points", 4096.0, MOVED, |bench| each(bench, "weigh_points", |twin| twin.weigh())),
    row("distribute_residuals", 64.0, MOVED, |bench| {
        each(bench, "distribute_residuals", |twin| twin.distribute())
    }),
    row("average_points", 64.0, MOVED, |bench| each(bench, "average_points", |twin| twin.join())),
    row("pool_impulses", 512.0, MOVED, |bench| each(bench, "pool_impulses", |twin| twin.pool())),
    row("join_sewn_systems", 0.0, COPIED, join_systems),
];

/// The arrays of the systems, and points of their nodes.
struct SewnTwin<'a> {
    solve: Twin<'a>,
    starts: Vec<u32>,
    nodes: Vec<u32>,
    weights: Vec<Matrix<f32>>,
}

impl SewnTwin<'_> {
    fn points(&self) -> Vec<Vec<(usize, usize)>> {
        let range = |ends: &[u32]| ends[0] as usize..ends[1] as usize;
        let of = |ends| range(ends).map(|at| (at, self.nodes[at] as usize)).collect();
        self.starts.windows(2).map(of).collect()
    }

    fn is_pinned(&self, node: usize) -> bool {
        self.solve.fixture.old.position[node][3] <= 0.0
    }

    fn begin(&mut self) {
        for point in self.points() {
            let nodes: Vec<usize> = point.into_iter().map(|one| one.1).collect();
            let is_pinned = nodes.iter().any(|&node| self.is_pinned(node));
            let holder = nodes.iter().find(|&&node| self.solve.predicted(node).in_contact());
            if let Some(&holder) = holder.filter(|_| !is_pinned) {
                let found = self.solve.work.predicted_contacts[holder];
                for &node in &nodes {
                    self.solve.work.predicted_contacts[node] = found;
                    self.solve.begin_node(node);
                }
            }
            let (mut sum, mut weights) = ([0.0; 3], 0.0);
            for &node in &nodes {
                let pin = if self.is_pinned(node) { 1.0 } else { 0.0 };
                let weight = if is_pinned { pin } else { self.solve.mass(node) };
                sum = add(sum, scale(self.solve.get(Vector::Direction, node), weight));
                weights += weight;
            }
            let middle = scale(sum, 1.0 / weights);
            let free: Vec<usize> = nodes.into_iter().filter(|&node| !self.is_pinned(node)).collect();
            free.into_iter().for_each(|node| self.begin_at(node, middle));
        }
    }

    fn begin_at(&mut self, node: usize, place: [f32; 3]) {
        let twin = &mut self.solve;
        let velocity = scale(sub(place, twin.get(Vector::Start, node)), 1.0 / twin.solving.inner);
        let total = sub(velocity, twin.get(Vector::Free, node));
        let before = add(twin.get(Vector::Cycled, node), twin.get(Vector::Total, node));
        let warm = sub(add(before, twin.get(Vector::Free, node)), velocity);
        let warm = twin.predicted(node).filtered(warm);
        twin.put(Vector::Cycled, node, if twin.solving.is_warm != 0 { warm } else { [0.0; 3] });
        let ([x, y, z], at) = (total, twin.at(Vector::Total, node));
        twin.work.vectors[at] = [x, y, z, twin.work.vectors[at][3]];
        twin.put(Vector::Direction, node, place);
        twin.put(Vector::DirectionProduct, node, velocity);
    }

    fn inverse(&self, node: usize) -> Symmetric<f32> {
        six(&self.solve.work.diagonals[node].inverse)
    }

    fn weigh(&mut self) {
        for point in self.points() {
            let mut those_before = self.inverse(point[0].1);
            for &(at, node) in &point[1..] {
                (self.weights[at], those_before) = parallel(&those_before, &self.inverse(node));
            }
        }
    }

    fn distribute(&mut self) {
        for point in self.points() {
            let residual =
                |sum, &(_, node): &(usize, usize)| add(sum, self.solve.get(Vector::Residual, node));
            let mut left = point.iter().fold([0.0; 3], residual);
            for &(at, node) in point.iter().rev() {
                let is_first = at == point[0].0;
                let others = if is_first { [0.0; 3] } else { transposed_times(&self.weights[at], left) };
                let own = sub(left, others);
                let (mass, to) = (self.solve.mass(node), self.solve.at(Vector::Residual, node));
                self.solve.work.vectors[to] = [own[0], own[1], own[2], mass];
                let first = self.solve.jacobi(node, own);
                self.solve.put(Vector::Cycle, node, first);
                left = others;
            }
        }
    }

    fn join(&mut self) {
        for point in self.points() {
            let of = |node| self.solve.get(Vector::Cycled, node);
            let after = |all, &(at, node): &(usize, usize)| {
                add(of(node), matrix_times(&self.weights[at], sub(all, of(node))))
            };
            let all = point[1..].iter().fold(of(point[0].1), after);
            point.iter().for_each(|&(_, node)| self.solve.put(Vector::Cycled, node, all));
        }
    }
}

impl SewnTwin<'_> {
    fn pool(&mut self) {
        for point in self.points() {
            let nodes: Vec<usize> = point.into_iter().map(|one| one.1).collect();
            let twin = &self.solve;
            let given = |node: usize| twin.get(Vector::Given, node);
            let mass = |node: usize| twin.fixture.old.velocity[node][3].abs();
            let mut after: Vec<(usize, [f32; 3])> = Vec::new();
            if let Some(&pin) = nodes.iter().find(|&&node| self.is_pinned(node)) {
                let lacks = |node: usize| {
                    let total = add(twin.get(Vector::Total, node), twin.get(Vector::Change, node));
                    sub(given(node), scale(total, twin.mass(node)))
                };
                let free = nodes.iter().filter(|&&node| !self.is_pinned(node));
                after.push((pin, free.fold(given(pin), |sum, &node| add(sum, lacks(node)))));
            } else if twin.predicted(nodes[0]).in_contact() {
                let sum = nodes.iter().fold([0.0; 3], |sum, &node| add(sum, given(node)));
                let all = nodes.iter().fold(0.0, |sum, &node| sum + mass(node));
                after.extend(nodes.iter().map(|&node| (node, scale(sum, mass(node) / all))));
            }
            after.into_iter().for_each(|(node, impulse)| self.solve.put(Vector::Given, node, impulse));
        }
    }
}

fn solver(case: usize) -> Solver {
    let mut solver = Solver { method: Method::Ice, ..Solver::default() };
    solver.ice.form = ConstraintForm::Primal;
    (solver.ice.order, solver.ice.warm_start) = (1 + (case % 2) as u32, case != 2);
    solver
}

/// The arrays before a kernel: points of two to five nodes, some of them pinned, some held in all directions.
fn twin<'a>(fixture: &'a Fixture, case: usize) -> SewnTwin<'a> {
    let mut chance = Chance::new(211 + case as u64);
    let solving = fixture.records()[SUBSTEP].solving;
    let solve = Twin { fixture, solving, in_contact: false, work: work(fixture, &solving, case, false) };
    let finest: Vec<u32> = solve.finest().into_iter().map(|(node, _)| node as u32).collect();
    let mut all = SewnTwin { solve, starts: vec![0], nodes: Vec::new(), weights: Vec::new() };
    for (number, &node) in finest.iter().enumerate() {
        let [x, y, z] = chance.three(9.0).map(|x| 40.0 + x);
        let [u, v, w] = chance.three(7.0);
        let size = [1.0, 1e-3, 1.0, 0.0][number % 4];
        all.solve.work.diagonals[node as usize].inverse = record([x, y, z, u, v, w].map(|x| size * x));
    }
    // Nodes from far apart, each in one point.
    let half = finest.len() / 2;
    let mut turn = finest[..half].iter().zip(&finest[half..]).flat_map(|(&a, &b)| [a, b]);
    for size in (2..=5).cycle() {
        let mut nodes: Vec<u32> = turn.by_ref().take(size).collect();
        if nodes.len() < size {
            break;
        }
        nodes.sort_unstable();
        all.nodes.extend(nodes);
        all.starts.push(all.nodes.len() as u32);
    }
    all.weights = (0..all.nodes.len()).map(|_| [0; 3].map(|_| chance.three(0.5))).collect();
    all
}

/// Runs a kernel, at all cases, and compares what it and its twin have made of the arrays.
fn each(bench: &mut Bench<'_>, entry: &'static str, run: fn(&mut SewnTwin<'_>)) -> Result<(), String> {
    for case in 0..3 {
        let fixture = Fixture::with_levels(131 + case as u64, solver(case), bench.exact)?;
        let kernel = kernel_of(bench, Name::new(entry), &fixture)?;
        let start = twin(&fixture, case);
        let records_of = |weights: &[Matrix<f32>]| -> Vec<Weight> {
            weights.iter().map(|&[x, y, z]| Weight { x, y, z, ..Weight::default() }).collect()
        };
        let groups = &fixture.tables.multigrid.groups[0];
        let mut given = arrays(&fixture, &start.solve.work, groups, &[]);
        given.insert("sewn_starts", start.starts.clone());
        given.insert("sewn_nodes", start.nodes.clone());
        given.insert("sewn_weights", words(&records_of(&start.weights)));
        let mut wanted = twin(&fixture, case);
        run(&mut wanted);
        let (records, groups) = (fixture.records(), start.starts.len().div_ceil(GROUP));
        bench.run(&kernel, &Given { arrays: &given, records: &records, groups }, |written| {
            let counts = vec![POISON; 3 * fixture.tables.multigrid.counted().len()];
            compare(written, &kernel, &wanted.solve.work, &counts);
            if kernel.bindings().iter().any(|one| one.name == "sewn_weights") {
                let found: Vec<Weight> = written.take("sewn_weights");
                for (wanted, found) in records_of(&wanted.weights).iter().zip(&found) {
                    let numbers = |weight: &Weight| [weight.x, weight.y, weight.z].concat();
                    written.outcome().compare("sewn_weights", &numbers(wanted), &numbers(found));
                }
            }
        })?;
    }
    Ok(())
}

fn join_systems(bench: &mut Bench<'_>) -> Result<(), String> {
    let fixture = Fixture::with_levels(137, solver(0), bench.exact)?;
    let kernel = kernel_of(bench, Name::new("join_sewn_systems"), &fixture)?;
    let start = twin(&fixture, 0);
    // A chain, a pair that is joined already by way of others, and systems by themselves.
    let links: [[u32; 2]; 4] = [[4, 2], [1, 4], [5, 7], [2, 1]];
    let mut given = arrays(&fixture, &start.solve.work, &fixture.tables.multigrid.groups[0], &[]);
    given.insert("sewn_links", words(&links));
    given.insert("joins", (0..9).collect());
    let records = fixture.records();
    bench.run(&kernel, &Given { arrays: &given, records: &records, groups: 1 }, |written| {
        let joins: Vec<u32> = written.take("joins");
        let firsts: Vec<f32> = (0..9).map(|system| first_of(&joins, system) as f32).collect();
        written.outcome().copied("joins", &[0.0, 1.0, 1.0, 3.0, 1.0, 5.0, 6.0, 5.0, 8.0], &firsts);
    })
}
