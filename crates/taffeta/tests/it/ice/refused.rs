//! What the method says: of settings that mean nothing, and of systems that it did not solve.

use super::{stiffen, with_acad, with_ice};
use crate::common::compare::cloth;
use crate::common::{build, run, scene_error};
use taffeta::scene::{Acad, Ice, Scene, Select, Solver};
use taffeta::{Options, Simulation};

fn hanging() -> Scene {
    let mut body = cloth(12, 12, [1.1, 1.1]).pin(Select::rows(0, 0));
    stiffen(&mut body, 1e3);
    Scene::new("hanging").time(0.01, 0.01).body(body)
}

/// The place in the scene that an error names.
fn refused(change: impl Fn(&mut Solver)) -> String {
    let mut scene = hanging();
    change(&mut scene.solver);
    let error = scene_error(Simulation::new(&scene, &Options::default()));
    assert!(error.message.contains("would do"), "{error}");
    error.path
}

#[test]
fn settings_that_mean_nothing_are_refused_by_their_names() {
    for value in [0.0, -1e-3, 1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(refused(|solver| solver.ice.tolerance = value), "solver.ice.tolerance", "{value}");
    }
    assert_eq!(refused(|solver| solver.ice.max_iterations = 0), "solver.ice.max_iterations");
    for value in [-0.1, f64::NAN, f64::INFINITY] {
        assert_eq!(refused(|solver| solver.ice.epsilon = value), "solver.ice.epsilon", "{value}");
        assert_eq!(refused(|solver| solver.acad.epsilon = value), "solver.acad.epsilon", "{value}");
        assert_eq!(refused(|solver| solver.acad.release = value), "solver.acad.release", "{value}");
        assert_eq!(refused(|solver| solver.acad.target = value), "solver.acad.target", "{value}");
    }
    // At a threshold of zero every rounding would make a spring a constraint.
    for value in [0.0, -0.1, f64::NAN, f64::INFINITY] {
        assert_eq!(refused(|solver| solver.acad.threshold = value), "solver.acad.threshold", "{value}");
    }
    // What releases, or is aimed at, lies below the threshold.
    assert_eq!(refused(|solver| solver.acad.release = 0.11), "solver.acad.release");
    assert_eq!(refused(|solver| solver.acad.target = 0.11), "solver.acad.target");
}

#[test]
fn a_system_that_was_not_solved_is_reported() {
    let solver = |ice: Ice| {
        let mut simulation = build(&with_ice(hanging(), ice));
        simulation.disturb(0.001, 3);
        run(&mut simulation, 3);
        simulation.report().solver
    };
    let ice = Ice { tolerance: 1e-6, max_iterations: 2000, warm_start: false, ..Ice::default() };
    let solved = solver(ice.clone());
    assert!(solved.capped == 0 && solved.residual <= 1e-6 && solved.residual > 0.0, "{solved:?}");
    assert!(solved.iterations > 2 && solved.iterations < 2000, "{solved:?}");
    assert_eq!(solved.active_fraction, 1.0);
    let cut = solver(Ice { max_iterations: 2, ..ice.clone() });
    assert!(cut.capped == 1 && cut.residual > 1e-6 && cut.iterations == 2, "{cut:?}");
    // More accuracy takes more iterations.
    let finer = solver(Ice { tolerance: 1e-9, ..ice });
    assert!(finer.capped == 0 && finer.residual <= 1e-9 && finer.iterations > solved.iterations, "{finer:?}");
}

#[test]
fn each_sub_step_that_was_cut_counts() {
    let ice = Ice { tolerance: 1e-9, max_iterations: 2, ..Ice::default() };
    let mut simulation = build(&with_ice(hanging().time(0.01, 0.0025), ice));
    simulation.disturb(0.001, 3);
    run(&mut simulation, 1);
    assert_eq!(simulation.report().solver.capped, 4);
}

#[test]
fn springs_alone_have_no_system_to_report() {
    let mut scene = hanging().time(1e-4, 1e-4);
    for method in ["springs", "acad"] {
        if method == "acad" {
            scene = with_acad(scene, Acad::default(), Ice::default());
        }
        let mut simulation = build(&scene);
        run(&mut simulation, 1);
        let solver = &simulation.report().solver;
        assert_eq!((solver.iterations, solver.residual, solver.capped), (0, 0.0, 0), "{method}");
        assert_eq!(solver.active_fraction, 0.0, "{method}");
    }
}
