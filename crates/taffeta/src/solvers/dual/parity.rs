//! Rows of springs that are constraints.

use crate::contact::colliders::gpu::Contact;
use crate::gpu::kernels::Name;
use crate::gpu::layout::{Four, GROUP, NONE, SUBSTEPS_SEEN, Solving, Substep};
use crate::parity::bench::{Bench, Given, Written};
use crate::parity::fixture::{Arrays, Chance, Fixture, Maker, words};
use crate::parity::{Row as ParityRow, Tolerance};
use crate::real::{norm, scale};
use crate::scene::{ConstraintForm, Method, Solver};
use crate::solvers::dual::gpu_layout::{
    CgState, Constraint, ConstraintGroup, ContactRecord, Row, Solve, SolveStatistics,
};
use crate::solvers::dual::gpu_tables::ConstraintTables;
use crate::solvers::dual::twin::{Twin, Work, is_active};
use crate::solvers::explicit::parity::kernel_of;
use taffeta_gpu::bytemuck::{Pod, Zeroable};
use taffeta_gpu::{Access, Kernel};

const COUNTED: &str = "numbers alone, but for a squared length, which hardware may fuse";
const SAME: &str = "the same operations in the same order; hardware may fuse products and sums";
const SUMMED: &str =
    "the same sums by halves; hardware may fuse products and sums, and what is left of them is small";

/// One row for each kernel.
pub const ROWS: &[ParityRow] = &[
    row("mark_active", Tolerance::new(0.0, 0.0, COUNTED), mark),
    row("list_active", Tolerance::new(0.0, 0.0, COUNTED), list),
    row("free_velocities", Tolerance::new(0.0, 64.0, SAME), free),
    row("set_up_rows", Tolerance::new(0.0, 128.0, SAME), set_up),
    row("predict_contacts", Tolerance::new(0.0, 512.0, SAME), predict_contacts),
    row("predict_mesh_contacts", Tolerance::new(0.0, 512.0, SAME), predict_mesh_contacts),
    row("start_rows", Tolerance::new(0.0, 64.0, SAME), start),
    row("count_systems", Tolerance::new(0.0, 0.0, COUNTED), count),
    row("solve_nodes", Tolerance::new(0.0, 64.0, SUMMED), step_nodes),
    row("solve_rows", Tolerance::new(0.0, 64.0, SUMMED), step_rows),
    row("record_statistics", Tolerance::new(0.0, 8.0, SAME), note),
    row("apply_constraint_forces", Tolerance::new(0.0, 128.0, SAME), pull),
];

const fn row(
    name: &'static str,
    tolerance: Tolerance,
    check: fn(&mut Bench<'_>) -> Result<(), String>,
) -> ParityRow {
    ParityRow { name, entry: name, tolerance, check }
}

/// A number that no kernel may take for another.
const POISON: u32 = 0x7fff_fff1;

fn solvers() -> [Solver; 4] {
    let solver = |method, form| {
        let mut solver = Solver { method, ..Solver::default() };
        (solver.ice.form, solver.acad.form) = (form, form);
        (solver.ice.epsilon, solver.ice.max_iterations, solver.ice.tolerance) = (0.07, 9, 0.03);
        (solver.acad.threshold, solver.acad.target) = (0.25, 0.05);
        solver
    };
    #[cfg(feature = "paper-forms")]
    let other = ConstraintForm::Printed;
    #[cfg(not(feature = "paper-forms"))]
    let other = ConstraintForm::Compliant;
    let mut cold = solver(Method::Ice, other);
    cold.ice.warm_start = false;
    [
        solver(Method::Ice, ConstraintForm::Compliant),
        cold,
        solver(Method::Acad, ConstraintForm::Compliant),
        solver(Method::Acad, other),
    ]
}

/// Cases of a system's progress.
const CASES: usize = 11;

/// The progress of a system of that case, whose sums are `sums`.
fn progress(chance: &mut Chance, case: usize, sums: [f32; 4], most: u32) -> CgState {
    let mut number = || chance.number().abs();
    let mut some = CgState {
        passes: 5,
        is_done: 0,
        limit: 1e-9,
        right: number(),
        gamma: number(),
        alpha: number(),
        beta: number(),
    };
    match case {
        0 | 1 => some.passes = case as u32,
        2 => (some.passes, some.gamma, some.alpha) = (2, 0.0, 0.0),
        3 => some.is_done = 1,
        4 => some.limit = 1e9,
        5 => some.limit = sums[0],
        6 => some.limit = sums[0].next_down(),
        7 => some.passes = most + 2,
        8 => some.passes = most + 1,
        9 => some.gamma = f32::NAN,
        _ => {}
    }
    some
}

/// Arrays by chance; systems at every case of progress, one of them without an active constraint.
fn work(fixture: &Fixture, solving: &Solving, shift: usize) -> Work {
    let (tables, mut chance) = (&fixture.tables.constraints, Chance::new(7 + shift as u64));
    let colliders = fixture.substep().colliders().len();
    let (count, places) = (tables.constraints.len(), fixture.tables.len());
    let mut constraints = tables.constraints.clone();
    let solve_of = |number: usize| {
        tables
            .constraint_groups
            .iter()
            .find(|g| (g.first as usize + g.count as usize) > number)
            .map(|g| g.solve)
    };
    let mut listed = 0;
    for (number, constraint) in constraints.iter_mut().enumerate().filter(|_| solving.is_adaptive != 0) {
        // One system has none, and one has as many as two groups have room for.
        let solve = solve_of(number).map_or(0, |solve| solve as usize);
        let whole = solve == (shift + 1) % 2;
        constraint.is_active =
            u32::from(solve != shift % 2 && chance.number() > -0.3 && !(whole && listed == 2 * GROUP));
        listed += if whole { constraint.is_active as usize } else { 0 };
    }
    let mut work = Work {
        rows: (0..count).map(|_| some_row(&mut chance)).collect(),
        scales: (0..count).map(|_| [chance.number().abs(), chance.number().abs()]).collect(),
        active_constraints: vec![POISON; count],
        active_counts: vec![POISON; tables.constraint_groups.len()],
        solves: tables.solves.clone(),
        predicted_contacts: vec![ContactRecord { slides: 1.0, ..ContactRecord::default() }; places],
        sums: tables.constraint_groups.iter().map(|_| some_sums(&mut chance)).collect(),
        response: vec![[0.0; 4]; places],
        force: fixture.force_fours().iter().map(|&[x, y, z, _]| [x, y, z, 0.0]).collect(),
        new_velocity: fixture.new.velocity.clone(),
        statistics: [
            SolveStatistics { iterations: 3, capped: 5, active_fraction: 0.1, residual: 1e-6 },
            SolveStatistics { iterations: 3_000, capped: 0, active_fraction: 3.0, residual: 1e9 },
        ][shift % 2],
        constraints,
    };
    list_twin(&tables.constraint_groups, &mut work);
    for constraint in work.constraints.iter().filter(|constraint| constraint.is_active != 0) {
        for end in [constraint.a, constraint.b].map(|end| end as usize) {
            let [x, y, z] = chance.three(1.3);
            work.response[end] = [x, y, z, 0.0];
            work.predicted_contacts[end] =
                some_contact(&mut chance, fixture.old.position[end][3] > 0.0, colliders);
        }
    }
    let mut twin = Twin { fixture, solving: *solving, work };
    at_all_cases(&mut twin, &mut chance, shift);
    twin.work
}

/// A node that is pressed against a surface, or not.
pub fn some_contact(chance: &mut Chance, is_free: bool, colliders: usize) -> ContactRecord {
    let (direction, is_predicted) = (chance.three(1.0), chance.number() > 0.0 && is_free);
    let normal = if is_predicted { scale(direction, 1.0 / norm(direction)) } else { [0.0; 3] };
    let collider = ((chance.number().abs() * colliders as f32) as u32).min(colliders as u32 - 1);
    let slides = if chance.number() > 0.0 || !is_predicted { 1.0 } else { 0.0 };
    let velocity = if is_predicted { chance.three(2.0) } else { [0.0; 3] };
    // What a mesh has found before, here and there.
    let inside = if normal[0] > 0.2 { 0.07 * normal[1].abs() } else { 0.0 };
    let surface_speed = if is_predicted { chance.number() } else { 0.0 };
    ContactRecord {
        normal,
        slides,
        velocity,
        collider,
        is_constrained: 1,
        inside,
        surface_speed,
        ..ContactRecord::default()
    }
}

/// Of which all but the last are above 0, and that here and there.
fn some_sums(chance: &mut Chance) -> [f32; 4] {
    let [a, b, c] = chance.three(0.9).map(f32::abs);
    [a, b, c, chance.number() + 0.5]
}

fn some_row(chance: &mut Chance) -> Row {
    let direction = chance.three(0.9);
    let [r, w, s] = chance.three(0.8);
    Row { direction, r, w, s, p: chance.number(), x: chance.number() }
}

fn at_all_cases(twin: &mut Twin<'_>, chance: &mut Chance, shift: usize) {
    let solving = twin.solving;
    for number in 0..twin.work.solves.len() {
        let case = (number + shift) % CASES;
        if case == 10 {
            // A system that answers the other way.
            let groups = twin.fixture.tables.constraints.constraint_groups.iter().zip(&mut twin.work.sums);
            groups.filter(|(group, _)| group.solve as usize == number).for_each(|(_, sum)| sum[1] *= -1.0);
        }
        let sums = twin.body_sums(number);
        let solve = &mut twin.work.solves[number];
        solve.kept = progress(chance, case, sums, solving.most_iterations);
        solve.next = progress(chance, (case + 4) % CASES, [0.5; 4], solving.most_iterations);
        if shift + 1 == CASES {
            // All are done, as well as they can be.
            (solve.kept.is_done, solve.next.gamma, solve.next.limit) = (1, 0.125, 0.125);
        }
    }
}

/// The active constraints of each body in ascending order, and how many there are.
fn list_twin(groups: &[ConstraintGroup], work: &mut Work) {
    for solve in 0..work.solves.len() {
        let of_body = || groups.iter().filter(|group| group.solve as usize == solve);
        let Some(first) = of_body().next() else { continue };
        let all = of_body().flat_map(|group| group.first..group.first + group.count);
        let active: Vec<u32> =
            all.filter(|&number| work.constraints[number as usize].is_active != 0).collect();
        let base = first.first as usize;
        work.active_constraints[base..base + active.len()].copy_from_slice(&active);
        work.solves[solve].active_constraints = active.len() as u32;
    }
    for (count, group) in work.active_counts.iter_mut().zip(groups) {
        let range = group.first as usize..(group.first + group.count) as usize;
        *count = work.constraints[range].iter().map(|constraint| constraint.is_active).sum();
    }
}

fn arrays(fixture: &Fixture, work: &Work) -> Arrays {
    let tables = &fixture.tables.constraints;
    let mut all = fixture.arrays();
    all.extend([
        ("constraint_groups", words(&tables.constraint_groups)),
        ("node_groups", words(&tables.node_groups)),
        ("incident", words(&tables.incident)),
        ("constraints", words(&work.constraints)),
        ("rows", words(&work.rows)),
        ("row_scales", words(&work.scales)),
        ("predicted_contacts", words(&work.predicted_contacts)),
        ("active_constraints", work.active_constraints.clone()),
        ("active_counts", work.active_counts.clone()),
        ("solves", words(&work.solves)),
        ("row_sums", words(&work.sums)),
        ("response", words(&work.response)),
        ("force", words(&work.force)),
        ("new_velocity", words(&work.new_velocity)),
        ("solve_counts", vec![POISON; 6]),
        ("statistics", words(&[work.statistics])),
    ]);
    all
}

/// Compares all that a kernel may write.
fn compare(written: &mut Written<'_>, kernel: &Kernel, wanted: &Work, counts: &[u32]) {
    for one in kernel.bindings().iter().filter(|one| one.access == Access::ReadWrite) {
        match one.name.as_str() {
            "constraints" => records(written, "constraints", &wanted.constraints),
            "active_constraints" => records(written, "active_constraints", &wanted.active_constraints),
            "active_counts" => records(written, "active_counts", &wanted.active_counts),
            "solve_counts" => records(written, "solve_counts", counts),
            "rows" => rows(written, &wanted.rows),
            "row_scales" => columns(written, "row_scales", &wanted.scales),
            "predicted_contacts" => compare_contacts(written, &wanted.predicted_contacts),
            "row_sums" => columns(written, "row_sums", &wanted.sums),
            "solves" => solves(written, &wanted.solves),
            "response" => written.fours("response", &wanted.response),
            "force" => written.fours("force", &wanted.force),
            "new_velocity" => written.fours("new_velocity", &wanted.new_velocity),
            "statistics" => statistics(written, &wanted.statistics),
            _ => {}
        }
    }
}

/// Numbers that are copied or counted, word by word.
pub fn records<T: Pod>(written: &mut Written<'_>, name: &str, wanted: &[T]) {
    let numbers = |records: &[T]| words(records).into_iter().map(f32::from_bits).collect::<Vec<_>>();
    let found: Vec<T> = written.take(name);
    let equal = words(wanted) == words(&found);
    written.outcome().copied(name, &numbers(wanted), &numbers(&found));
    written.outcome().copied(&format!("{name} (words)"), &[1.0], &[if equal { 1.0 } else { 0.0 }]);
}

/// Numbers of a record by their name.
type Column<T> = (&'static str, fn(&T) -> f32);

fn columns<const N: usize>(written: &mut Written<'_>, name: &str, wanted: &[[f32; N]])
where
    [f32; N]: Pod,
{
    let found: Vec<[f32; N]> = written.take(name);
    for i in 0..N {
        let column = |all: &[[f32; N]]| all.iter().map(|pair| pair[i]).collect::<Vec<_>>();
        written.outcome().compare(&format!("{name}[{i}]"), &column(wanted), &column(&found));
    }
}

pub fn compare_contacts(written: &mut Written<'_>, wanted: &[ContactRecord]) {
    let found: Vec<ContactRecord> = written.take("predicted_contacts");
    let normals = |all: &[ContactRecord]| all.iter().flat_map(|record| record.normal).collect::<Vec<_>>();
    written.outcome().compare("predicted_contacts.normal", &normals(wanted), &normals(&found));
    let velocities =
        |all: &[ContactRecord]| all.iter().flat_map(|record| record.velocity).collect::<Vec<_>>();
    written.outcome().compare("predicted_contacts.velocity", &velocities(wanted), &velocities(&found));
    let insides = |all: &[ContactRecord]| all.iter().map(|record| record.inside).collect::<Vec<_>>();
    written.outcome().compare("predicted_contacts.inside", &insides(wanted), &insides(&found));
    let speeds = |all: &[ContactRecord]| all.iter().map(|record| record.surface_speed).collect::<Vec<_>>();
    written.outcome().compare("predicted_contacts.surface_speed", &speeds(wanted), &speeds(&found));
    let slides = |all: &[ContactRecord]| all.iter().map(|record| record.slides).collect::<Vec<_>>();
    written.outcome().copied("predicted_contacts.slides", &slides(wanted), &slides(&found));
    let counts = |all: &[ContactRecord]| {
        all.iter()
            .flat_map(|record| [record.collider, record.is_constrained].map(|n| n as f32))
            .collect::<Vec<_>>()
    };
    written.outcome().copied("predicted_contacts", &counts(wanted), &counts(&found));
}

fn rows(written: &mut Written<'_>, wanted: &[Row]) {
    let found: Vec<Row> = written.take("rows");
    let directions = |all: &[Row]| all.iter().flat_map(|row| row.direction).collect::<Vec<_>>();
    written.outcome().compare("rows.direction", &directions(wanted), &directions(&found));
    let columns: [Column<Row>; 5] =
        [("r", |row| row.r), ("w", |row| row.w), ("s", |row| row.s), ("p", |row| row.p), ("x", |row| row.x)];
    for (name, of) in columns {
        let column = |all: &[Row]| all.iter().map(of).collect::<Vec<_>>();
        written.outcome().compare(&format!("rows.{name}"), &column(wanted), &column(&found));
    }
}

fn solves(written: &mut Written<'_>, wanted: &[Solve]) {
    let found: Vec<Solve> = written.take("solves");
    let count = |p: &CgState| [p.passes, p.is_done].map(|number| number as f32);
    let counts = |all: &[Solve]| -> Vec<f32> {
        let of = |s: &Solve| {
            [&[s.constraints as f32, s.active_constraints as f32][..], &count(&s.kept), &count(&s.next)]
                .concat()
        };
        all.iter().flat_map(of).collect()
    };
    written.outcome().copied("solves", &counts(wanted), &counts(&found));
    let columns: [Column<CgState>; 5] = [
        ("limit", |p| p.limit),
        ("right", |p| p.right),
        ("gamma", |p| p.gamma),
        ("alpha", |p| p.alpha),
        ("beta", |p| p.beta),
    ];
    for (name, of) in columns {
        let column = |all: &[Solve]| all.iter().flat_map(|s| [of(&s.kept), of(&s.next)]).collect::<Vec<_>>();
        // Each number by itself: a system's are not those of another.
        for (a, b) in column(wanted).into_iter().zip(column(&found)) {
            written.outcome().compare(&format!("solves.{name}"), &[a], &[b]);
        }
    }
}

pub fn statistics(written: &mut Written<'_>, wanted: &SolveStatistics) {
    let found: Vec<SolveStatistics> = written.take("statistics");
    let found = found.first().copied().unwrap_or_default();
    let counts = |statistics: &SolveStatistics| [statistics.iterations as f32, statistics.capped as f32];
    written.outcome().copied("statistics", &counts(wanted), &counts(&found));
    written.outcome().compare(
        "statistics.active_fraction",
        &[wanted.active_fraction],
        &[found.active_fraction],
    );
    written.outcome().compare("statistics.residual", &[wanted.residual], &[found.residual]);
}

/// Where a kernel's workgroups come from.
enum Groups {
    Constraints,
    Nodes,
    One,
}

/// Runs a kernel for each solver and at all cases, and its twin.
fn twins(
    bench: &mut Bench<'_>,
    entry: &'static str,
    groups: Groups,
    run: impl Fn(&mut Twin<'_>),
) -> Result<(), String> {
    twins_on(bench, (Name::new(entry), Fixture::with_constraints), groups, run)
}

/// The same for a kernel by its whole name, in a scene.
fn twins_on(
    bench: &mut Bench<'_>,
    (name, scene): (Name, Maker),
    groups: Groups,
    run: impl Fn(&mut Twin<'_>),
) -> Result<(), String> {
    for (seed, solver) in (1..).zip(solvers()) {
        let fixture = scene(seed, solver.clone(), bench.exact)?;
        let kernel = kernel_of(bench, name, &fixture)?;
        let solving = Solving::of(&solver);
        for shift in 0..CASES {
            let start = work(&fixture, &solving, shift);
            let mut twin = Twin { fixture: &fixture, solving, work: start.clone() };
            run(&mut twin);
            let counts = twin.counts();
            let (arrays, records) = (arrays(&fixture, &start), fixture.records());
            let groups = match groups {
                Groups::Constraints => fixture.tables.constraints.constraint_groups.len(),
                Groups::Nodes => fixture.tables.constraints.node_groups.len(),
                Groups::One => 1,
            };
            bench.run(&kernel, &Given { arrays: &arrays, records: &records, groups }, |written| {
                compare(written, &kernel, &twin.work, &counts);
            })?;
        }
    }
    Ok(())
}

fn free(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "free_velocities", Groups::Nodes, |twin| twin.free())
}

fn set_up(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "set_up_rows", Groups::Constraints, |twin| twin.set_up())
}

fn predict_contacts(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "predict_contacts", Groups::Nodes, |twin| twin.predict_contacts())
}

fn predict_mesh_contacts(bench: &mut Bench<'_>) -> Result<(), String> {
    let name = Name::new("predict_mesh_contacts").with(Contact::Meshes.choices());
    let scene = Fixture::with_meshes_and_constraints;
    twins_on(bench, (name, scene), Groups::Nodes, |twin| twin.predict_mesh_contacts())
}

fn start(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "start_rows", Groups::Constraints, |twin| twin.start())
}

fn count(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "count_systems", Groups::One, |_| {})
}

fn step_nodes(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "solve_nodes", Groups::Nodes, |twin| twin.step_nodes())
}

fn step_rows(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "solve_rows", Groups::Constraints, |twin| twin.step_rows())
}

fn note(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "record_statistics", Groups::One, |twin| twin.note())
}

fn pull(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "apply_constraint_forces", Groups::Nodes, |twin| twin.pull())
}

/// Springs on, below and above what they become constraints by, and what they stay ones by.
fn mark(bench: &mut Bench<'_>) -> Result<(), String> {
    for solver in [2, 3].map(|i| solvers()[i].clone()) {
        let solving = Solving::of(&solver);
        let mut fixture = Fixture::with_constraints(5, solver, bench.exact)?;
        let kernel = kernel_of(bench, Name::new("mark_active"), &fixture)?;
        let mut start = work(&fixture, &solving, 4);
        put_on_thresholds(&mut fixture, &mut start.constraints);
        start.active_counts.fill(POISON);
        if !bench.exact {
            // None so near that rounding decides.
            let near = |constraint: &Constraint, fraction: f32| Constraint {
                rest_length: constraint.rest_length * fraction,
                ..*constraint
            };
            let decides = |constraint: &Constraint| {
                let is = |fraction| is_active(&near(constraint, fraction), &fixture.old.position, &solving);
                is(0.9999) != is(1.0001)
            };
            start
                .constraints
                .iter_mut()
                .filter(|constraint| decides(constraint))
                .for_each(|constraint| constraint.rest_length *= 0.9);
        }
        let mut twin = Twin { fixture: &fixture, solving, work: start.clone() };
        twin.mark();
        let (arrays, records) = (arrays(&fixture, &start), fixture.records());
        let groups = fixture.tables.constraints.constraint_groups.len();
        bench.run(&kernel, &Given { arrays: &arrays, records: &records, groups }, |written| {
            compare(written, &kernel, &twin.work, &[]);
        })?;
    }
    Ok(())
}

/// A spring with 1.25 times its length, and one with its length, both active before and not, each of them free.
fn put_on_thresholds(fixture: &mut Fixture, constraints: &mut [Constraint]) {
    for (i, (length, was)) in [(2.5, 0), (2.5, 1), (2.0, 0), (2.0, 1)].into_iter().enumerate() {
        let constraint = &mut constraints[700 + 300 * i];
        let [a, b] = [constraint.a, constraint.b].map(|end| end as usize);
        let mass = fixture.old.position[a][3];
        fixture.old.position[a] = [0.5, 0.25, -1.0, mass];
        fixture.old.position[b][..3].copy_from_slice(&[0.5 + length, 0.25, -1.0]);
        (constraint.rest_length, constraint.is_active) = (2.0, was);
    }
}

/// Lists of all sizes, of one body and of several.
fn list(bench: &mut Bench<'_>) -> Result<(), String> {
    let kernel = bench.kernel(Name::new("list_active"), &[("KINDS", 1.0)])?;
    for sizes in [&[0][..], &[1], &[255], &[256], &[257], &[100_000], &[300, 1, 0, 700, 256]] {
        for fraction in [-1.0, -0.4, 0.7, 1.0] {
            let mut chance = Chance::new(sizes.len() as u64);
            let (groups, mut work) = listed(sizes, &mut chance, fraction);
            let before = work.clone();
            list_twin(&groups, &mut work);
            let mut all = Arrays::new();
            all.insert("constraint_groups", words(&or_one(&groups)));
            all.insert("constraints", words(&or_one(&before.constraints)));
            all.insert("active_constraints", or_one(&before.active_constraints));
            all.insert("active_counts", or_one(&work.active_counts));
            all.insert("solves", words(&before.solves));
            let records = vec![Substep::zeroed(); SUBSTEPS_SEEN];
            let given = Given { arrays: &all, records: &records, groups: groups.len() };
            let work = Work {
                constraints: or_one(&work.constraints),
                active_constraints: or_one(&work.active_constraints),
                active_counts: or_one(&work.active_counts),
                ..work
            };
            bench.run(&kernel, &given, |written| compare(written, &kernel, &work, &[]))?;
        }
    }
    Ok(())
}

/// An array cannot be empty.
fn or_one<T: Pod>(all: &[T]) -> Vec<T> {
    if all.is_empty() { vec![T::zeroed()] } else { all.to_vec() }
}

/// Constraints of bodies of these sizes, of which about a share is active.
fn listed(sizes: &[usize], chance: &mut Chance, fraction: f32) -> (Vec<ConstraintGroup>, Work) {
    let (mut tables, mut start) = (ConstraintTables::default(), 0);
    for &size in sizes {
        tables.add_groups(start..start + size, 0, 0, false);
        start += size;
    }
    let none = Constraint { a: 0, b: NONE, k: 1.0, damping: 2.0, rest_length: 3.0, is_active: 0 };
    let mut constraint = || Constraint { is_active: u32::from(chance.number() < fraction), ..none };
    let fours: Vec<Four> = Vec::new();
    let work = Work {
        constraints: (0..start).map(|_| constraint()).collect(),
        rows: Vec::new(),
        scales: Vec::new(),
        predicted_contacts: Vec::new(),
        active_constraints: vec![POISON; start],
        active_counts: vec![0; tables.constraint_groups.len()],
        solves: tables.solves.iter().map(|solve| Solve { active_constraints: 0, ..*solve }).collect(),
        sums: Vec::new(),
        response: fours.clone(),
        force: fours.clone(),
        new_velocity: fours,
        statistics: SolveStatistics::default(),
    };
    (tables.constraint_groups, work)
}
