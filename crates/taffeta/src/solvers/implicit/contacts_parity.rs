//! Rows of contacts of surfaces that are part of the systems of bodies.

use crate::contact::triangles::gpu_layout::AT_START;
use crate::contact::triangles::parity::{COPIED, MOVED, compare as compare_surfaces, row};
use crate::contact::triangles::parity_scene::fixture_with;
use crate::contact::triangles::parity_stages::Solving;
use crate::contact::triangles::twin::Twin as Surfaces;
use crate::gpu::kernels::Name;
use crate::gpu::layout::NONE;
use crate::parity::bench::{Bench, Given};
use crate::parity::fixture::{Chance, Fixture, SUBSTEP};
use crate::parity::row::Row;
use crate::real::add;
use crate::scene::{ConstraintForm, Method, Solver};
use crate::solvers::explicit::parity::kernel_of;
use crate::solvers::implicit::contacts_twin::{ContactTwin, first_of};
use crate::solvers::implicit::gpu_layout::{Diagonal, NodeSolve, PcgState, Vector};
use crate::solvers::implicit::parity_work::{POISON, arrays, compare, work};
use crate::solvers::implicit::twin::{Twin, record};

/// One row for each kernel.
pub const ROWS: &[Row] = &[
    row("part_systems", 0.0, COPIED, |bench| each(bench, "part_systems", |twin| twin.part_systems())),
    row("take_contacts", 64.0, MOVED, |bench| each(bench, "take_contacts", |twin| twin.take_contacts())),
    row("name_systems", 0.0, COPIED, |bench| each(bench, "name_systems", |twin| twin.name_systems())),
    row("linearise_contacts", 1024.0, MOVED, |bench| {
        each(bench, "linearise_contacts", |twin| twin.linearise())
    }),
    row("add_contacts", 1024.0, MOVED, |bench| each(bench, "add_contacts", |twin| twin.add())),
    row("multiply_cycle", 512.0, MOVED, |bench| {
        each(bench, "multiply_cycle", |twin| twin.multiply(Vector::Cycle, false))
    }),
    row("multiply_cycled", 512.0, MOVED, |bench| {
        each(bench, "multiply_cycled", |twin| twin.multiply(Vector::Cycled, true))
    }),
    row("multiply_change", 512.0, MOVED, |bench| {
        each(bench, "multiply_change", |twin| twin.multiply(Vector::Change, true))
    }),
    row("apply_contacts", 512.0, MOVED, |bench| each(bench, "apply_contacts", |twin| twin.apply())),
];

/// Cases of what systems are about.
const CASES: usize = 4;

/// The arrays before a kernel.
fn twin<'a>(fixture: &'a Fixture, entry: &str, case: usize) -> ContactTwin<'a> {
    let solving = fixture.records()[SUBSTEP].solving;
    let mut surfaces = Surfaces::while_solving(Solving::Keep, fixture);
    surfaces.place_parts();
    surfaces.fill_parts();
    surfaces.sort_parts();
    let solve = Twin { fixture, solving, in_contact: true, work: work(fixture, &solving, case, true) };
    let systems = fixture.tables.multigrid.systems(fixture.tables.len());
    let joins = (0..solve.work.solves.len() as u32).collect();
    let mut twin = ContactTwin { solve, surfaces, systems, joins };
    twin.set_up(case);
    match entry {
        "part_systems" => twin.joins.fill(0),
        "take_contacts" => {}
        "name_systems" => twin.joins = vec![0, 1, 2, 3, 3, 4, 6],
        _ => twin.take_contacts(),
    }
    if entry != "take_contacts" {
        let (progress, start) = (twin.solve.work.solves.clone(), NodeSolve::default());
        twin.solve.work.solves.fill(start);
        twin.linearise();
        twin.solve.work.solves = progress;
    }
    match entry {
        // It is another step.
        "linearise_contacts" => twin.set_up(case + CASES),
        "apply_contacts" => twin.surfaces.solved.iter_mut().for_each(|one| one.applied = [7.0; 3]),
        _ => {}
    }
    twin
}

impl ContactTwin<'_> {
    /// Has nodes go some way, some bodies without a system, some nodes that hardly give way or that colliders hold, and systems
    /// at all cases.
    fn set_up(&mut self, case: usize) {
        let mut chance = Chance::new(97 + case as u64);
        let bodies = self.solve.work.solves.len();
        // In one case all hardly give way, held or not.
        let is_stiff = case % CASES == 2;
        for place in 0..self.systems.len() {
            if case % CASES == 3 && self.systems[place] as usize == bodies - 2 {
                self.systems[place] = NONE;
            }
            let start = self.surfaces.place(AT_START, place);
            self.solve.put(Vector::Direction, place, add(start, chance.three(0.004)));
            self.solve.put(Vector::DirectionProduct, place, chance.three(0.8));
            let [x, y, z] = chance.three(9.0).map(|x| 40.0 + x);
            let [u, v, w] = chance.three(7.0);
            let share = if is_stiff || place / 8 % 3 == 0 { 1e-3 } else { 1.0 };
            let [own, inverse] = [0.02, share].map(|share| [x, y, z, u, v, w].map(|x| share * x));
            let own = match place / 8 % 12 {
                0..3 => own,
                6..9 => [own[0], own[1], own[2], 0.0, 0.0, 0.0],
                _ => [0.8, 0.8, 0.8, 0.0, 0.0, 0.0],
            };
            let [own, inverse] = [own, inverse].map(record);
            self.solve.work.diagonals[place] = Diagonal { own, inverse };
        }
        for (number, solve) in self.solve.work.solves.iter_mut().enumerate() {
            let passes = if (number + case) % 4 == 1 { 3 } else { 0 };
            let is_done = u32::from((number + case) % 3 == 1);
            let kept = PcgState { passes, ..solve.kept };
            let next = PcgState { is_done, ..solve.next };
            let (steps, is_met) = ((case % 2) as u32, u32::from((number + case) % 4 == 2));
            *solve = NodeSolve { steps, is_met, kept, next, ..*solve };
        }
    }
}

/// Runs a kernel, at all cases, and compares what it and its twin have made of the arrays.
fn each(bench: &mut Bench<'_>, entry: &'static str, run: fn(&mut ContactTwin<'_>)) -> Result<(), String> {
    let mut solver = Solver { method: Method::Ice, ..Solver::default() };
    solver.ice.form = ConstraintForm::Primal;
    for case in 0..CASES {
        let fixture = fixture_with(113 + case as u64, solver.clone(), 0.02)?;
        let start = twin(&fixture, entry, case);
        let kernel = kernel_of(bench, Name::new(entry), &fixture)?;
        let groups = &fixture.tables.multigrid.groups[0];
        let mut given = arrays(&fixture, &start.solve.work, groups, &[]);
        start.surfaces.put_arrays(&mut given);
        given.insert("systems", start.systems.clone());
        given.insert("joins", start.joins.clone());
        let mut wanted = twin(&fixture, entry, case);
        run(&mut wanted);
        let (records, groups) = (fixture.records(), start.surfaces.work.len() / 256);
        bench.run(&kernel, &Given { arrays: &given, records: &records, groups }, |written| {
            let counts = vec![POISON; 3 * fixture.tables.multigrid.counted().len()];
            compare(written, &kernel, &wanted.solve.work, &counts);
            let joins: Vec<u32> = written.take("joins");
            // A kernel that does not write them leaves them as they were.
            let joins = if joins.is_empty() { &start.joins } else { &joins };
            let firsts = |joins: &[u32]| -> Vec<f32> {
                (0..joins.len() as u32).map(|one| first_of(joins, one) as f32).collect()
            };
            written.outcome().copied("joins", &firsts(&wanted.joins), &firsts(joins));
            compare_surfaces(written, start.surfaces, wanted.surfaces);
        })?;
    }
    Ok(())
}
