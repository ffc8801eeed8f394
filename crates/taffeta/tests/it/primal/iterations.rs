//! How many iterations a system takes, and whether what is said of it is true.

use super::{newton, with};
use crate::common::compare::{cloth, join_grid, reference};
use crate::common::state::{state, stiffen};
use crate::common::{build, build_as, run, turned};
use taffeta::Precision;
use taffeta::diagnostics::SolverReport;
use taffeta::scene::{Body, Ice, Icosphere, Mass, Mesh, Scene, Select};

/// A tolerance that takes more than the first few iterations.
fn fine() -> Ice {
    Ice { tolerance: 1e-6, ..newton(1) }
}

/// What the solver says of the first frames of 1/60 s, from nothing.
fn solved(body: Body, ice: Ice, frames: u32) -> SolverReport {
    let h = 1.0 / 60.0;
    let scene = with(Scene::new("iterations").time(h, h).body(body), Ice { warm_start: false, ..ice });
    let mut simulation = build_as(&scene, Precision::F64, 2);
    simulation.disturb(1e-4, 3);
    let mut worst = SolverReport::default();
    for _ in 0..frames {
        run(&mut simulation, 1);
        let solver = simulation.report().solver;
        assert!(solver.capped == 0 && solver.residual > 0.0, "{solver:?}");
        worst = if solver.iterations > worst.iterations { solver } else { worst };
    }
    worst
}

/// A square metre of 0.2 kg in n × n nodes that hangs by a row, whatever n is the same cloth.
fn sheet(n: u32, k: f64) -> Body {
    let body = Body::cloth("sheet", Mesh::grid(n, n, [1.0, 1.0])).with_mass(Mass::Whole(0.2));
    let mut body = body.structural(k, 0.0).shear(k, 0.0).bend(k, 0.0).pin(Select::rows(0, 0));
    body.place = turned([1.0, 0.0, 0.0], 60.0, [0.0; 3]);
    body
}

#[test]
fn a_hundred_times_as_many_nodes_of_a_sheet_take_hardly_more_iterations() {
    for k in [1e3, 1e5] {
        let found =
            [32, 100, 316].map(|n| solved(sheet(n, k), fine(), if n > 200 { 2 } else { 5 }).iterations);
        assert!(found[0] > 0 && found.iter().all(|&n| 2 * n <= 3 * found[0] && n < 25), "{k} N/m: {found:?}");
    }
}

#[test]
fn sixteen_times_as_many_nodes_of_a_ball_take_hardly_more_iterations() {
    for bend in [0.0, 1e4] {
        let found = [4, 6].map(|subdivisions| {
            let ball = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions });
            let body = Body::cloth("ball", ball).with_mass(Mass::Whole(1.0)).structural(1e5, 0.1);
            let body = if bend > 0.0 { body.bend(bend, 0.0) } else { body };
            solved(body.pin(Select::nodes([0])), fine(), if subdivisions > 5 { 2 } else { 5 }).iterations
        });
        assert!(found[0] > 0 && 2 * found[1] <= 3 * found[0] && found[1] < 80, "bend {bend}: {found:?}");
    }
}

#[test]
fn more_accuracy_takes_more_iterations_and_a_limit_is_kept_and_told() {
    let told = |tolerance, max_iterations| {
        let ice = Ice { tolerance, max_iterations, warm_start: false, ..newton(1) };
        let h = 1.0 / 60.0;
        let scene = with(Scene::new("told").time(h, h).body(sheet(20, 1e4)), ice);
        let mut simulation = build(&scene);
        simulation.disturb(1e-3, 3);
        run(&mut simulation, 3);
        simulation.report().solver
    };
    let [rough, fine, finer] = [1e-3, 1e-6, 1e-9].map(|tolerance| told(tolerance, 1000));
    for (solver, tolerance) in [(rough, 1e-3), (fine, 1e-6), (finer, 1e-9)] {
        assert!(solver.capped == 0 && solver.residual <= tolerance, "{solver:?}");
        assert_eq!(solver.active_fraction, 1.0);
    }
    assert!(rough.iterations < fine.iterations && fine.iterations < finer.iterations, "{fine:?} {finer:?}");
    let cut = told(1e-6, 1);
    assert!(cut.capped == 1 && cut.iterations == 1 && cut.residual > 1e-6, "{cut:?}");
}

/// The error that some iterations leave of a step, in the norm of its system, and the one that is reported.
fn left(max_iterations: u32) -> [f64; 2] {
    let h = 0.01;
    let mut body = cloth(12, 11, [1.0, 1.1]).pin(Select::nodes([0, 10]));
    stiffen(&mut body, 1e3);
    let at_first = Ice { tolerance: 1e-12, warm_start: false, ..newton(1) };
    let scene = |ice: Ice| with(Scene::new("error").time(h, h).body(body.clone()), ice);
    let mut before = build(&scene(at_first.clone()));
    before.disturb(1e-3, 3);
    run(&mut before, 2);
    let scene = scene(Ice { tolerance: 1e-6, max_iterations, ..at_first });
    let mut simulation = build(&scene);
    let mut reference = reference(&scene, &simulation, vec![0.05; 132]);
    join_grid(&mut reference, 12, 11);
    reference.springs.iter_mut().for_each(|spring| spring.2 *= 1e3);
    reference.held.extend([0, 10]);
    // Of another scene as far as iterations go, which no state depends on.
    let mut snapshot = before.snapshot();
    snapshot.scene = simulation.snapshot().scene;
    simulation.restore(&snapshot).unwrap();
    (reference.x, reference.v) = state(&simulation);
    run(&mut simulation, 1);
    let free = reference.free_velocities(&reference.forces(), h);
    let left = reference.error(&free, &state(&simulation).1, h);
    let said = simulation.report().solver;
    assert!(said.iterations == max_iterations && said.capped == 1, "{said:?}");
    [left, said.residual]
}

#[test]
fn the_residual_that_is_reported_is_about_the_error_before_the_last_iteration() {
    let mut before = 1.0;
    for max_iterations in 1..8 {
        let [after, said] = left(max_iterations);
        assert!(after < said && said < 1.5 * before && said > 0.5 * before, "{max_iterations}: {said:e}");
        before = after;
    }
}

#[test]
fn what_falls_unstrained_is_solved_in_one_iteration_of_each_newton_step() {
    let body = Body { pins: Vec::new(), ..sheet(12, 1e4) };
    let mut simulation = build(&with(Scene::new("falls").time(0.01, 0.01).body(body), newton(2)));
    run(&mut simulation, 5);
    let solver = simulation.report().solver;
    assert!(solver.capped == 0 && solver.iterations <= 2 && solver.residual < 1e-6, "{solver:?}");
}
