//! Rows of springs that are solved for by nodes.

use crate::contact::colliders::gpu::Contact;
use crate::gpu::kernels::Name;
use crate::parity::bench::{Bench, Given};
use crate::parity::fixture::{Fixture, Maker, SUBSTEP};
use crate::parity::row::{Row, Tolerance};
use crate::scene::{ConstraintForm, Method, Solver};
use crate::solvers::explicit::parity::kernel_of;
use crate::solvers::implicit::gpu::{CONTACTS, COUPLED};
use crate::solvers::implicit::gpu_layout::{CoarseEdge, LevelGroup};
use crate::solvers::implicit::parity_work::{CASES, DONE, POISON, arrays, compare, work};
use crate::solvers::implicit::twin::Twin;

const COUNTED: &str = "numbers alone";
const SAME: &str = "the same operations in the same order; hardware may fuse products and sums";
const SUMMED: &str =
    "the same sums by halves; hardware may fuse products and sums, and what is residual of them is small";
const INVERTED: &str = "the same operations in the same order; hardware may fuse products and sums, and blocks that \
                        are nearly flat are inverted";
const BORNE: &str = "the same operations in the same order; hardware may fuse products and sums, and what a surface bears \
                     is a small difference of velocities";

/// One row for each kernel.
pub const ROWS: &[Row] = &[
    row("free_nodes", Tolerance::new(0.0, 64.0, SAME), free),
    row("predict_contacts_implicit", Tolerance::new(1.0, 512.0, SAME), predict_contacts),
    row("predict_mesh_contacts_implicit", Tolerance::new(0.0, 512.0, SAME), predict_mesh_contacts),
    row("next_newton_step", Tolerance::new(0.0, 64.0, SAME), next_newton_step),
    row("sum_motion", Tolerance::new(0.0, 64.0, SUMMED), sum_motion),
    row("weigh_motion", Tolerance::new(0.0, 64.0, SUMMED), weigh_motion),
    row("count_next_step", Tolerance::new(0.0, 0.0, COUNTED), count_next_step),
    row("set_up_nodes", Tolerance::new(0.0, 512.0, INVERTED), set_up),
    row("coarsen_springs", Tolerance::new(0.0, 64.0, SAME), coarsen_springs),
    row("coarsen_edges", Tolerance::new(0.0, 64.0, SAME), coarsen_edges),
    row("coarsen_nodes", Tolerance::new(0.0, 512.0, INVERTED), coarsen_nodes),
    row("start_nodes", Tolerance::new(0.0, 64.0, SUMMED), start),
    row("step_nodes", Tolerance::new(0.0, 64.0, SUMMED), step),
    row("residual_of_nodes", Tolerance::new(0.0, 64.0, SAME), residual_of_nodes),
    row("restrict_level", Tolerance::new(0.0, 64.0, SAME), restrict),
    row("residual_of_level", Tolerance::new(0.0, 64.0, SAME), residual_of_level),
    row("cycle_tail", Tolerance::new(0.0, 512.0, SAME), tail),
    row("prolong_level", Tolerance::new(0.0, 64.0, SAME), follow),
    row("smooth_level", Tolerance::new(0.0, 64.0, SAME), smooth_level),
    row("smooth_level_back", Tolerance::new(0.0, 64.0, SAME), smooth_level_back),
    row("smooth_nodes", Tolerance::new(0.0, 64.0, SAME), smooth_nodes),
    row("apply_nodes", Tolerance::new(0.0, 64.0, SUMMED), apply),
    row("count_open_systems", Tolerance::new(0.0, 0.0, COUNTED), count),
    row("count_left", Tolerance::new(0.0, 0.0, COUNTED), count_left),
    row("spring_impulses", Tolerance::new(0.0, 64.0, SAME), impulses),
    row("add_implicit_forces", Tolerance::new(0.0, 1024.0, BORNE), push),
    row("place_implicit_nodes", Tolerance::new(0.0, 64.0, SAME), place),
    row("record_implicit_statistics", Tolerance::new(0.0, 8.0, SAME), note),
    row("set_up_couplings", Tolerance::new(0.0, 64.0, SAME), set_up_couplings),
    row("coarsen_couplings", Tolerance::new(0.0, 4096.0, INVERTED), coarsen_couplings),
    row("bound_couplings", Tolerance::new(0.0, 512.0, SAME), bound_couplings),
    row("scale_inverses", Tolerance::new(0.0, 64.0, SAME), scale_inverses),
];

const fn row(
    name: &'static str,
    tolerance: Tolerance,
    check: fn(&mut Bench<'_>) -> Result<(), String>,
) -> Row {
    Row { name, entry: name, tolerance, check }
}

fn solvers() -> [Solver; 3] {
    [(true, 1, 0), (false, 1, 1), (true, 2, 0)].map(|(warm, order, newton_steps)| {
        let mut solver = Solver { method: Method::Ice, ..Solver::default() };
        solver.ice.form = ConstraintForm::Primal;
        (solver.ice.order, solver.ice.newton_steps) = (order, newton_steps);
        (solver.ice.max_iterations, solver.ice.tolerance, solver.ice.warm_start) = (9, 0.03125, warm);
        solver
    })
}

/// What of a level a kernel is given.
#[derive(Clone, Copy)]
enum Part {
    /// All groups of a level, or their edges.
    Groups(usize),
    Edges(usize),
    /// What is in no tail, of a coarser level.
    Wide(usize),
    Tail,
    One,
}

/// Runs a kernel on a part, for each solver and at all cases, and its twin.
fn twins(
    bench: &mut Bench<'_>,
    entry: &'static str,
    part: Part,
    run: impl Fn(&mut Twin<'_>, &[LevelGroup]),
) -> Result<(), String> {
    twins_on(bench, (Name::new(entry), Fixture::with_levels), part, run)
}

/// The same for a kernel that takes the system, of springs alone and of elements beside them.
fn both_twins(
    bench: &mut Bench<'_>,
    entry: &'static str,
    part: Part,
    run: impl Fn(&mut Twin<'_>, &[LevelGroup]),
) -> Result<(), String> {
    twins(bench, entry, part, &run)?;
    twins_on(bench, (Name::new(entry).with(&[COUPLED]), Fixture::with_couplings), part, run)
}

/// The same for one that takes contacts of surfaces, too.
fn all_twins(
    bench: &mut Bench<'_>,
    entry: &'static str,
    run: impl Fn(&mut Twin<'_>, &[LevelGroup]),
) -> Result<(), String> {
    let part = Part::Groups(0);
    both_twins(bench, entry, part, &run)?;
    twins_on(bench, (Name::new(entry).with(&[COUPLED, CONTACTS]), Fixture::with_couplings), part, run)
}

/// The same for one that takes sums of systems, which contacts of surfaces may join.
fn joined_twins(bench: &mut Bench<'_>, entry: &'static str, run: fn(&mut Twin<'_>)) -> Result<(), String> {
    for name in [Name::new(entry), Name::new(entry).with(&[CONTACTS])] {
        twins_on(bench, (name, Fixture::with_levels), Part::Groups(0), |twin, _| run(twin))?;
    }
    Ok(())
}

/// The same for a kernel of elements.
fn coupled_twins(
    bench: &mut Bench<'_>,
    entry: &'static str,
    part: Part,
    run: impl Fn(&mut Twin<'_>, &[LevelGroup]),
) -> Result<(), String> {
    twins_on(bench, (Name::new(entry), Fixture::with_couplings), part, run)
}

/// The same for a kernel by its whole name, in a scene.
fn twins_on(
    bench: &mut Bench<'_>,
    (name, scene): (Name, Maker),
    part: Part,
    run: impl Fn(&mut Twin<'_>, &[LevelGroup]),
) -> Result<(), String> {
    for (seed, solver) in (1..).zip(solvers()) {
        let fixture = scene(seed, solver.clone(), bench.exact)?;
        let kernel = kernel_of(bench, name, &fixture)?;
        let in_contact = name.has(CONTACTS);
        let (multigrid, solving) = (&fixture.tables.multigrid, fixture.records()[SUBSTEP].solving);
        let (groups, edges) = match part {
            Part::Groups(level) => (&multigrid.groups[level][..], &[][..]),
            Part::Edges(level) => (&[][..], &multigrid.edges[level - 1][..]),
            Part::Wide(level) => (&multigrid.wide[level - 1][..], &[][..]),
            Part::Tail => (&multigrid.tail[..], &[][..]),
            Part::One => (&multigrid.groups[0][..], &[][..]),
        };
        let count = match part {
            Part::One => 1,
            Part::Edges(_) => edges.len().div_ceil(crate::gpu::layout::GROUP),
            _ => groups.len(),
        };
        if count == 0 {
            return Err(format!("the scene has no such part for `{}`", name.entry));
        }
        for shift in 0..CASES + DONE - 1 {
            let start = work(&fixture, &solving, shift, in_contact);
            let mut twin = Twin { fixture: &fixture, solving, in_contact, work: start.clone() };
            run(&mut twin, groups);
            let counts = twin.counts(name.entry, POISON);
            let none = [CoarseEdge { slots: [0; 2], first: 0, count: 0 }];
            let edges = if edges.is_empty() { &none[..] } else { edges };
            let no_group = [LevelGroup { first: 0, count: 0, solve: 0, first_group: 0, groups: 0 }];
            let groups = if groups.is_empty() { &no_group[..] } else { groups };
            let (arrays, records) = (arrays(&fixture, &start, groups, edges), fixture.records());
            bench.run(&kernel, &Given { arrays: &arrays, records: &records, groups: count }, |written| {
                compare(written, &kernel, &twin.work, &counts);
            })?;
        }
    }
    Ok(())
}

fn free(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "free_nodes", Part::Groups(0), |twin, _| twin.free())
}

fn predict_contacts(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "predict_contacts_implicit", Part::Groups(0), |twin, _| twin.predict_contacts())
}

fn predict_mesh_contacts(bench: &mut Bench<'_>) -> Result<(), String> {
    let name = Name::new("predict_mesh_contacts_implicit").with(Contact::Meshes.choices());
    let scene = Fixture::with_meshes_and_constraints;
    twins_on(bench, (name, scene), Part::Groups(0), |twin, _| twin.predict_mesh_contacts())
}

fn next_newton_step(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "next_newton_step", Part::Groups(0), |twin, _| twin.next_newton_step())
}

fn sum_motion(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "sum_motion", Part::Groups(0), |twin, _| twin.sum_motion())
}

fn weigh_motion(bench: &mut Bench<'_>) -> Result<(), String> {
    joined_twins(bench, "weigh_motion", |twin| twin.weigh_motion())
}

fn count_next_step(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "count_next_step", Part::One, |_, _| {})
}

fn set_up(bench: &mut Bench<'_>) -> Result<(), String> {
    both_twins(bench, "set_up_nodes", Part::Groups(0), |twin, _| twin.set_up())
}

fn coarsen_springs(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "coarsen_springs", Part::Edges(1), |twin, _| twin.coarsen_edges(1))
}

fn coarsen_edges(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "coarsen_edges", Part::Edges(2), |twin, _| twin.coarsen_edges(2))
}

fn coarsen_nodes(bench: &mut Bench<'_>) -> Result<(), String> {
    [1, 2].into_iter().try_for_each(|level| {
        twins(bench, "coarsen_nodes", Part::Groups(level), |twin, _| twin.coarsen_nodes(level))
    })
}

fn start(bench: &mut Bench<'_>) -> Result<(), String> {
    all_twins(bench, "start_nodes", |twin, _| twin.start())
}

fn step(bench: &mut Bench<'_>) -> Result<(), String> {
    joined_twins(bench, "step_nodes", |twin| twin.step())
}

fn residual_of_nodes(bench: &mut Bench<'_>) -> Result<(), String> {
    all_twins(bench, "residual_of_nodes", |twin, groups| twin.leave(groups))
}

fn restrict(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "restrict_level", Part::Wide(1), |twin, groups| twin.restrict(groups))
}

fn residual_of_level(bench: &mut Bench<'_>) -> Result<(), String> {
    both_twins(bench, "residual_of_level", Part::Wide(1), |twin, groups| twin.leave(groups))
}

fn tail(bench: &mut Bench<'_>) -> Result<(), String> {
    both_twins(bench, "cycle_tail", Part::Tail, |twin, _| twin.tail())
}

fn follow(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "prolong_level", Part::Wide(1), |twin, groups| twin.follow(groups))?;
    twins(bench, "prolong_level", Part::Groups(0), |twin, groups| twin.follow(groups))
}

fn smooth_level(bench: &mut Bench<'_>) -> Result<(), String> {
    both_twins(bench, "smooth_level", Part::Wide(1), |twin, groups| twin.smooth(groups))
}

fn smooth_level_back(bench: &mut Bench<'_>) -> Result<(), String> {
    both_twins(bench, "smooth_level_back", Part::Wide(1), |twin, groups| twin.smooth_back(groups))
}

fn smooth_nodes(bench: &mut Bench<'_>) -> Result<(), String> {
    all_twins(bench, "smooth_nodes", |twin, groups| twin.smooth(groups))
}

fn apply(bench: &mut Bench<'_>) -> Result<(), String> {
    all_twins(bench, "apply_nodes", |twin, _| twin.apply())
}

fn count(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "count_open_systems", Part::One, |twin, _| twin.count_open())
}

fn count_left(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "count_left", Part::One, |twin, _| twin.count_left())
}

fn impulses(bench: &mut Bench<'_>) -> Result<(), String> {
    all_twins(bench, "spring_impulses", |twin, _| twin.impulses())
}

fn push(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "add_implicit_forces", Part::Groups(0), |twin, _| twin.push())
}

fn place(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "place_implicit_nodes", Part::Groups(0), |twin, _| twin.place())
}

fn note(bench: &mut Bench<'_>) -> Result<(), String> {
    twins(bench, "record_implicit_statistics", Part::One, |twin, _| twin.note())
}

fn set_up_couplings(bench: &mut Bench<'_>) -> Result<(), String> {
    coupled_twins(bench, "set_up_couplings", Part::Groups(0), |twin, _| twin.set_up_couplings())
}

fn coarsen_couplings(bench: &mut Bench<'_>) -> Result<(), String> {
    [1, 2].into_iter().try_for_each(|level| {
        coupled_twins(bench, "coarsen_couplings", Part::Groups(level), |twin, groups| {
            twin.coarsen_couplings(groups)
        })
    })
}

fn bound_couplings(bench: &mut Bench<'_>) -> Result<(), String> {
    [0, 1].into_iter().try_for_each(|level| {
        coupled_twins(bench, "bound_couplings", Part::Groups(level), |twin, groups| {
            twin.bound_couplings(groups)
        })
    })
}

fn scale_inverses(bench: &mut Bench<'_>) -> Result<(), String> {
    coupled_twins(bench, "scale_inverses", Part::Groups(1), |twin, groups| twin.scale_inverses(groups))
}
