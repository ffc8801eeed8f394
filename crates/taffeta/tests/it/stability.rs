//! The largest stable step is where runs begin to blow up, and a run that does says what and why.

use crate::common::{build, build_as, farthest, near, normals, positions, run, weightless};
use taffeta::scene::{Body, FabricDamping, Icosphere, Mass, Material, Mesh, Method, Scene, Select};
use taffeta::{Advice, Diverged, Precision, Simulation, StepError};

fn grid(rows: u32, cols: u32, d: f64) -> Body {
    let size = [0.1 * f64::from(cols - 1), 0.1 * f64::from(rows - 1)];
    let body = Body::cloth("grid", Mesh::grid(rows, cols, size)).with_mass(Mass::Node(0.01));
    body.structural(100.0, d).shear(100.0, d).bend(100.0, d)
}

fn ball() -> Body {
    let mesh = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 2 });
    Body::cloth("ball", mesh).with_mass(Mass::Whole(1.0)).structural(200.0, 0.05).bend(100.0, 0.02)
}

fn largest(body: Body) -> f64 {
    build(&weightless("limit", 1.0, 1.0).body(body)).largest_stable_step()
}

#[test]
fn equal_springs_on_a_large_grid_have_the_step_of_the_closed_form() {
    // k h² + 2 d h = 4 m/λ: λ = 10.125 with all three kinds, 8 with structural and shear springs.
    for d in [0.0, 0.1, 1.0] {
        let root = |limit: f64| (-2.0 * d + (4.0 * d * d + 4.0 * 100.0 * limit).sqrt()) / 200.0;
        let all = root(4.0 * 0.01 / 10.125);
        near("all kinds", largest(grid(60, 70, d)), all, 0.01 * all);
        let two = Body {
            springs: taffeta::scene::Springs { bend: None, ..grid(2, 2, d).springs },
            ..grid(60, 70, d)
        };
        let expected = root(4.0 * 0.01 / 8.0);
        near("without bend", largest(two), expected, 0.01 * expected);
    }
}

/// At most what theory allows, and within a hundredth of it.
#[track_caller]
fn no_longer_and_near(what: &str, got: f64, theory: f64) {
    assert!(got <= theory && got > 0.99 * theory, "{what}: {got}, expected up to {theory}");
}

#[test]
fn a_single_spring_has_the_step_of_its_two_masses() {
    // h² k (1/m + 1/m) = 4; with one end held, h² k/m = 4.
    let pair = || Body::cloth("pair", Mesh::chain(1, 1.0)).with_mass(Mass::Node(0.02)).structural(50.0, 0.0);
    let [free, held] = [4.0 * 0.02 / 100.0_f64, 4.0 * 0.02 / 50.0].map(f64::sqrt);
    no_longer_and_near("free", largest(pair()), free);
    no_longer_and_near("held", largest(pair().pin(Select::nodes([0]))), held);
    let loose = Body::cloth("loose", Mesh::grid(3, 3, [1.0, 1.0])).with_mass(Mass::Node(0.1));
    assert_eq!(largest(loose), f64::INFINITY);
}

/// How far nodes get from rest after 3,000 steps at `share` of the largest stable step, disturbed by 1e-6 m; infinite
/// if the run breaks off.
fn excursion(body: &Body, share: f64) -> f64 {
    let h = share * largest(body.clone());
    let mut simulation =
        build_as(&weightless("excursion", 10.0 * h, h).body(body.clone()), Precision::F64, 2);
    let rest = positions(&simulation);
    simulation.disturb(1e-6, 9);
    let mut worst = 0.0_f64;
    for _ in 0..300 {
        if simulation.step().is_err() {
            return f64::INFINITY;
        }
        worst = worst.max(farthest(&positions(&simulation), &rest));
    }
    worst
}

#[track_caller]
fn holds_and_bursts_above(body: Body) {
    let below = excursion(&body, 1.0);
    assert!(below < 1e-4, "{}: {below:e} m at the largest step", body.name);
    let above = excursion(&body, 1.025);
    assert!(above > 1e-3, "{}: {above:e} m at 1.025 of the step", body.name);
}

#[test]
fn a_grid_holds_at_its_largest_step_and_bursts_just_above() {
    for d in [0.0, 0.1, 1.0] {
        holds_and_bursts_above(grid(14, 11, d));
    }
    holds_and_bursts_above(grid(60, 52, 0.1).pin(Select::rows(0, 0)));
    holds_and_bursts_above(grid(3, 120, 0.1).with_mass(Mass::Area(1.0)));
}

#[test]
fn a_mesh_holds_at_its_largest_step_and_bursts_just_above() {
    holds_and_bursts_above(ball());
}

#[test]
fn hinges_hold_at_their_largest_step_and_burst_just_above() {
    // Stiff in bending, so that the hinges set the step.
    holds_and_bursts_above(ball().hinge(2.0, 1e-3));
    holds_and_bursts_above(grid(14, 11, 0.01).hinge(1.0, 1e-3));
}

#[test]
fn hinges_of_a_large_grid_hold_at_its_largest_step_and_burst_just_above() {
    holds_and_bursts_above(grid(50, 50, 0.01).hinge(1.0, 1e-3));
}

#[test]
fn a_fabric_holds_at_its_largest_step_and_bursts_just_above() {
    // Set by stretch, by bending, and by its damping, which moves nodes across the plane of the sheet alone.
    for (bending, time) in [(1e-5, 1e-5), (3e-3, 1e-5), (1e-5, 0.3)] {
        let material = Material {
            bending: Some(bending.into()),
            damping: Some(FabricDamping { stretch: 1e-6, bending: time }),
            ..Material::preset("cotton")
        };
        holds_and_bursts_above(Body::cloth("fabric", Mesh::sheet([0.3, 0.2], 0.02)).with_material(material));
    }
}

#[test]
fn drag_lowers_the_largest_step_as_its_own_damping() {
    // The pair's mode has κ = 2 k/m = 5000 1/s² and δ = c/m = 25 1/s.
    let mut scene = weightless("drag", 1.0, 1.0);
    scene.world.drag = 0.5;
    let pair = Body::cloth("pair", Mesh::chain(1, 1.0)).with_mass(Mass::Node(0.02)).structural(50.0, 0.0);
    let h = build(&scene.body(pair)).largest_stable_step();
    no_longer_and_near("h²κ + 2hδ", h * h * 5000.0 + 2.0 * h * 25.0, 4.0);
}

#[test]
fn a_step_that_is_too_long_is_warned_of_and_one_that_is_short_is_not() {
    let limit = largest(grid(10, 10, 0.1));
    let warnings = |share: f64| {
        crate::common::warnings(&build(&weightless("", 0.05, share * limit).body(grid(10, 10, 0.1))))
            .join(" ")
    };
    assert!(warnings(1.2).contains("will blow up") && warnings(1.2).contains("take sub-steps of"));
    assert!(warnings(0.95).contains("folded"));
    assert_eq!(warnings(0.5), "");
}

#[test]
fn implicit_springs_leave_the_step_to_hinges_and_drag() {
    let step =
        |body: Body, method| build(&weightless("", 1.0, 1.0).body(body).method(method)).largest_stable_step();
    assert_eq!(step(grid(10, 10, 0.1), Method::Ice), f64::INFINITY);
    assert_eq!(step(grid(10, 10, 0.1), Method::Acad), step(grid(10, 10, 0.1), Method::Springs));
    let bare = Body { springs: taffeta::scene::Springs::default(), ..grid(10, 10, 0.1) };
    let hinges = step(bare.hinge(0.1, 1e-3), Method::Springs);
    assert_eq!(step(grid(10, 10, 0.1).hinge(0.1, 1e-3), Method::Ice), hinges);
    let mut drag = weightless("", 1.0, 1.0).body(grid(10, 10, 0.1)).method(Method::Ice);
    drag.world.drag = 0.5;
    no_longer_and_near("h c/m", build(&drag).largest_stable_step() * 0.5 / 0.01, 2.0);
}

#[test]
fn a_step_that_is_too_long_for_implicit_springs_is_warned_of_by_what_is_explicit() {
    let warned = |body: Body, step, method| {
        let scene = weightless("", 0.05, step).body(body).method(method);
        crate::common::warnings(&build(&scene)).join("\n")
    };
    let limit = largest(grid(10, 10, 0.1));
    assert_eq!(warned(grid(10, 10, 0.1), 1.2 * limit, Method::Ice), "");
    let acad = warned(grid(10, 10, 0.1), 1.2 * limit, Method::Acad);
    assert!(acad.contains("below the threshold stay explicit") && !acad.contains("will blow up"), "{acad}");
    let hinged = warned(grid(10, 10, 0.1).hinge(1.0, 0.0), 1.2 * limit, Method::Ice);
    assert!(
        hinged.contains("of hinges and drag")
            && hinged.contains("lower the stiffness k = 1 N·m/rad of hinges to"),
        "{hinged}"
    );
}

fn burst() -> (Scene, Simulation) {
    let body = grid(10, 12, 0.1).pin(Select::nodes([0, 11]));
    let scene = Scene::new("burst").time(1.0 / 60.0, 1.0 / 60.0).body(ball().at([5.0, 5.0, 0.0])).body(body);
    let simulation = build(&scene);
    (scene, simulation)
}

fn diverged(error: StepError) -> Diverged {
    match error {
        StepError::Diverged(error) => error,
        other => panic!("{other}"),
    }
}

#[test]
fn a_burst_names_frame_body_vertex_and_the_step_that_would_do() {
    let (scene, mut simulation) = burst();
    let mut good = 0;
    let error = loop {
        match simulation.step() {
            Ok(report) => good = report.frame,
            Err(error) => break diverged(error),
        }
        assert!(good < 1000, "the step is beyond the largest by far");
        assert!(positions(&simulation).iter().flatten().all(|c| c.is_finite()), "shown frames are finite");
    };
    assert_eq!((error.first, error.frame, simulation.frame()), (good + 1, good + 1, good));
    assert_eq!(error.body, "grid");
    assert!(error.vertex < 120);
    let words = error.to_string();
    assert!(words.contains("frame") && words.contains("`grid`") && words.contains("vertex"), "{words}");
    // The advice is taken, and does.
    let [Advice::LongestStep(step), ..] = error.advice[..] else { panic!("a step to set: {error:?}") };
    let mut corrected = build(&scene.time(1.0 / 60.0, step));
    run(&mut corrected, 3 * good.max(60));
    // Nothing panics after the error.
    for _ in 0..3 {
        assert!(simulation.step().is_err());
    }
    let _ = (positions(&simulation), simulation.state_hash(), normals(&simulation, 0), simulation.report());
}

#[test]
fn frames_that_are_not_looked_at_one_by_one_say_by_which_it_burst() {
    let (_, mut simulation) = burst();
    let alone = loop {
        if let Err(error) = simulation.step() {
            break diverged(error).frame;
        }
    };
    let (_, mut simulation) = burst();
    simulation.advance(2).unwrap();
    let error = diverged(simulation.advance(alone + 7).unwrap_err());
    assert_eq!((error.first, error.frame), (3, alone + 9));
    assert!(
        error.to_string().starts_with(&format!("by frame {} (frame 2 was good): body", alone + 9)),
        "{error}"
    );
}

#[test]
fn a_number_that_is_not_finite_names_its_own_vertex() {
    for vertex in [0, 17, 100, 161] {
        // So light that its nodes are beyond 32 bits at once.
        let ball = ball().with_mass(Mass::Node(1e-14));
        let scene = weightless("", 1.0, 1.0).body(grid(3, 3, 0.1)).body(ball);
        let mut simulation = build_as(&scene, Precision::F32, 1);
        for _ in 0..1_000 {
            simulation.apply_force(simulation.body("ball").unwrap(), vertex, [0.0, 1e15, 0.0]).unwrap();
        }
        let error = diverged(simulation.step().unwrap_err());
        assert_eq!((error.frame, error.body.as_str(), error.vertex), (1, "ball", vertex), "{error}");
        assert!(error.what.contains("no longer a finite number"), "{error}");
    }
}
