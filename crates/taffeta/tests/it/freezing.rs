//! One body's failure is that body's alone: it stands still where it was, and the others go on as if a program had pinned it there.

use crate::common::{gpu, positions};
use crate::halted::bursting;
use taffeta::scene::{Body, Collider, ConstraintForm, Keyframe, Mass, Mesh, Method, Scene, Select};
use taffeta::{OnDivergence, Options, Pose, Precision, Simulation, StepError};

fn options(on_divergence: OnDivergence, precision: Precision, threads: usize) -> Options {
    Options { threads: Some(threads), precision, on_divergence, ..Options::default() }
}

fn freezing(scene: &Scene) -> Simulation {
    Simulation::new(scene, &options(OnDivergence::Freeze, Precision::F64, 1)).unwrap()
}

/// Four sheets one above the other, of which the third is thrown.
fn sheets(collide: bool) -> Scene {
    let sheet = |number: usize| {
        let body = Body::cloth(format!("sheet {number}"), Mesh::grid(6, 7, [0.3, 0.25]));
        let body = body.with_mass(Mass::Node(1e-3)).structural(20.0, 1e-3);
        let body = body.at([0.0, 0.02 * number as f64, 0.0]);
        if collide { body.collide(0.005) } else { body }
    };
    let mut scene =
        Scene::new("sheets").time(0.01, 1e-3).collider(Collider::plane([0.0, -0.005, 0.0], [0.0, 1.0, 0.0]));
    for number in 0..4 {
        scene = scene.body(sheet(number));
    }
    scene.bodies[0] = scene.bodies[0].clone().pin(Select::nodes([0]));
    scene
}

/// Throws a corner of a body sideways, away from the others, so that its next frame fails.
fn throw(simulation: &mut Simulation, body: &str) {
    let body = simulation.body(body).unwrap();
    simulation.apply_force(body, 41, [1e15, 0.0, 0.0]).unwrap();
}

/// Pins all vertices of a body where they are.
fn pin_all(simulation: &mut Simulation, body: &str) {
    let handle = simulation.body(body).unwrap();
    let places = positions(simulation);
    let mut first = 0;
    for info in simulation.bodies().to_vec() {
        if info.handle == handle {
            for vertex in 0..info.vertices {
                simulation.pin_vertex(handle, vertex, places[first + vertex]).unwrap();
            }
        }
        first += info.vertices;
    }
}

/// Pins all vertices of the third sheet but that of its pin.
fn pin_others(simulation: &mut Simulation) {
    let handle = simulation.body("sheet 2").unwrap();
    let places = positions(simulation);
    for vertex in 1..42 {
        simulation.pin_vertex(handle, vertex, places[84 + vertex]).unwrap();
    }
}

/// Throws sheets in one frame and runs some more, by a simulation that freezes them; in another they are pinned beforehand instead.
fn frozen_is_as_pinned(scene: &Scene, [freezes, stops]: [&Options; 2], thrown: &[&str]) {
    let [mut simulation, mut pinned] = [freezes, stops].map(|on| Simulation::new(scene, on).unwrap());
    for one in [&mut simulation, &mut pinned] {
        one.advance(4).unwrap();
    }
    assert_eq!(simulation.state_hash(), pinned.state_hash());
    for &body in thrown {
        throw(&mut simulation, body);
        pin_all(&mut pinned, body);
    }
    for frame in 5..12 {
        assert_eq!(simulation.step().unwrap().frame, frame);
        pinned.step().unwrap();
        assert_eq!(simulation.state_hash(), pinned.state_hash(), "frame {frame} of {}", scene.title);
    }
    let mut names: Vec<&str> = simulation.frozen().iter().map(|one| one.why.body.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, thrown);
    assert!(simulation.frozen().iter().all(|one| (one.why.first, one.why.frame) == (5, 5)));
}

fn solved(mut scene: Scene, method: Method, form: ConstraintForm) -> Scene {
    scene.solver.method = method;
    scene.solver.ice.form = form;
    scene
}

/// Nodes of a sheet are so light that it is thrown beyond all numbers. What the solver then has of it stays in memory beside what it has
/// of the others, on coarser levels, too, and must not reach them.
#[test]
fn no_number_of_a_body_that_overflows_reaches_its_neighbours() {
    for thrown in [0, 2] {
        let mut scene = solved(sheets(false), Method::Ice, ConstraintForm::Primal);
        for (number, body) in scene.bodies.iter_mut().enumerate() {
            let mass = Mass::Node(if number == thrown { 1e-15 } else { 1e-3 });
            *body = Body { mesh: Mesh::grid(14, 15, [0.3, 0.25]), ..body.clone() }.with_mass(mass);
        }
        for threads in [1, 2] {
            let [freeze, stop] =
                [OnDivergence::Freeze, OnDivergence::Stop].map(|on| options(on, Precision::F32, threads));
            frozen_is_as_pinned(&scene, [&freeze, &stop], &[&format!("sheet {thrown}")]);
        }
    }
}

#[test]
fn the_others_go_on_bit_by_bit_as_if_it_were_pinned() {
    let solvers = [
        (Method::Springs, ConstraintForm::Compliant),
        (Method::Ice, ConstraintForm::Compliant),
        (Method::Ice, ConstraintForm::Primal),
        (Method::Acad, ConstraintForm::Compliant),
    ];
    for collide in [false, true] {
        for (method, form) in solvers {
            for (precision, threads) in [(Precision::F64, 1), (Precision::F32, 3)] {
                let [freeze, stop] =
                    [OnDivergence::Freeze, OnDivergence::Stop].map(|on| options(on, precision, threads));
                let mut scene = solved(sheets(collide), method, form);
                scene.title = format!("{method:?} {form:?} {precision:?}, contact: {collide}");
                frozen_is_as_pinned(&scene, [&freeze, &stop], &["sheet 2"]);
            }
        }
    }
}

#[test]
fn several_that_fail_at_once_are_all_frozen() {
    let [freeze, stop] = [OnDivergence::Freeze, OnDivergence::Stop].map(|on| options(on, Precision::F64, 2));
    frozen_is_as_pinned(&sheets(true), [&freeze, &stop], &["sheet 1", "sheet 2"]);
    let all = ["sheet 0", "sheet 1", "sheet 2", "sheet 3"];
    frozen_is_as_pinned(&sheets(false), [&freeze, &stop], &all);
}

#[test]
fn on_a_gpu_the_others_go_on_as_if_it_were_pinned_too() {
    for (method, collide) in [(Method::Springs, true), (Method::Ice, false)] {
        let on = |on_divergence| Options { gpu: Some(gpu().into()), on_divergence, ..Options::default() };
        let [freeze, stop] = [OnDivergence::Freeze, OnDivergence::Stop].map(on);
        // A frame that fails is repeated in shorter and shorter sub-steps, so it begins with one.
        let scene = sheets(collide).method(method).time(1e-3, 1e-3);
        frozen_is_as_pinned(&scene, [&freeze, &stop], &["sheet 2"]);
    }
}

#[test]
fn a_body_that_blows_up_slowly_is_told_from_its_neighbour() {
    let scene = bursting();
    let mut simulation = freezing(&scene);
    simulation.disturb(1e-6, 1);
    let before = positions(&simulation);
    simulation.advance(1).unwrap();
    while simulation.frozen().is_empty() {
        simulation.step().unwrap();
    }
    let [frozen] = simulation.frozen() else { panic!("{:?}", simulation.frozen()) };
    assert_eq!((frozen.body, frozen.why.body.as_str()), (1, "stiff"));
    assert_eq!(frozen.why.first, simulation.frame());
    let moved = |places: &[[f64; 3]], body: usize| places[42 * body..42 * (body + 1)].to_vec();
    let at = positions(&simulation);
    for _ in 0..5 {
        assert!(simulation.step().unwrap().is_finite());
    }
    let after = positions(&simulation);
    assert_eq!(moved(&at, 1), moved(&after, 1));
    assert!(moved(&at, 0) != moved(&after, 0) && before != after);
}

#[test]
fn a_frozen_body_and_its_pins_stay_where_they_were() {
    let mut scene = sheets(false);
    for (body, key) in [(2, Keyframe::translate(1.0, [5.0, 0.0, 0.0])), (3, Keyframe::default())] {
        scene.bodies[body] = scene.bodies[body].clone().pin_moving(Select::nodes([0]), vec![key]);
    }
    let mut simulation = freezing(&scene);
    simulation.advance(2).unwrap();
    let hand = simulation.body("sheet 3").unwrap();
    let pin = simulation.pin(hand, 0).unwrap();
    let before = positions(&simulation);
    for body in ["sheet 2", "sheet 3"] {
        throw(&mut simulation, body);
    }
    simulation.pin_vertex(hand, 5, [9.0, 0.0, 0.0]).unwrap();
    simulation.move_pin(pin, Pose { translate: [0.0, 3.0, 0.0], ..Pose::default() }).unwrap();
    for _ in 0..3 {
        simulation.step().unwrap();
        simulation.pin_vertex(hand, 6, [9.0, 0.0, 0.0]).unwrap();
        simulation.unpin_vertex(hand, 7).unwrap();
        simulation.move_pin(pin, Pose { translate: [0.0, 1.0, 0.0], ..Pose::default() }).unwrap();
        throw(&mut simulation, "sheet 3");
    }
    let after = positions(&simulation);
    let far = crate::common::farthest(&before[84..], &after[84..]);
    assert!(far < 1e-12, "{far} m");
    assert_ne!(before[..84], after[..84]);
}

#[test]
fn a_snapshot_has_what_is_frozen() {
    let mut simulation = freezing(&sheets(true));
    simulation.advance(2).unwrap();
    let before = simulation.snapshot();
    throw(&mut simulation, "sheet 1");
    simulation.advance(3).unwrap();
    let snapshot = simulation.snapshot();
    let mut other = freezing(&sheets(true));
    other.restore(&snapshot).unwrap();
    assert_eq!((other.frozen(), other.frozen().len()), (simulation.frozen(), 1));
    simulation.advance(4).unwrap();
    other.advance(4).unwrap();
    assert_eq!(simulation.state_hash(), other.state_hash());
    // From before all bodies move again, as they would have.
    other.restore(&before).unwrap();
    let mut whole = freezing(&sheets(true));
    whole.advance(6).unwrap();
    other.advance(4).unwrap();
    assert_eq!((other.frozen().len(), other.state_hash()), (0, whole.state_hash()));
    let mut bad = snapshot.clone();
    bad.changes.frozen[0].body = 4;
    assert!(other.restore(&bad).unwrap_err().to_string().contains("body 4 is frozen, the scene has 4"));
    bad.changes.frozen[0].body = 2;
    let error = other.restore(&bad).unwrap_err().to_string();
    assert!(error.contains("body `sheet 2` is frozen in it, but node 84 is not held"), "{error}");
}

#[test]
fn frames_submitted_together_run_again_with_what_each_was_given() {
    let mut scene = sheets(true).collider(Collider::sphere([0.1, 0.2, 0.1], 0.05).named("ball"));
    scene.bodies[2] = scene.bodies[2].clone().pin_moving(Select::nodes([0]), vec![Keyframe::default()]);
    let [freeze, stop] = [OnDivergence::Freeze, OnDivergence::Stop].map(|on| options(on, Precision::F64, 1));
    let [mut simulation, mut pinned] = [&freeze, &stop].map(|on| Simulation::new(&scene, on).unwrap());
    pin_others(&mut pinned);
    throw(&mut simulation, "sheet 2");
    for (one, is_pinned) in [(&mut simulation, false), (&mut pinned, true)] {
        let ball = one.collider("ball").unwrap();
        let free = one.body("sheet 0").unwrap();
        for frame in 0..6 {
            one.move_collider(
                ball,
                Pose { translate: [0.0, -0.02 * f64::from(frame), 0.0], ..Pose::default() },
            )
            .unwrap();
            if !is_pinned {
                // It goes on with its hand until it is seen that it has failed.
                let pin = one.pin(one.body("sheet 2").unwrap(), 0).unwrap();
                let away = [0.01 * f64::from(frame), 0.0, 0.0];
                one.move_pin(pin, Pose { translate: away, ..Pose::default() }).unwrap();
            }
            if frame == 2 {
                one.pin_vertex(free, 20, [0.1, 0.1, 0.1]).unwrap();
            }
            if frame == 3 {
                // Thrown, with the velocity that it was moved with.
                one.unpin_vertex(free, 20).unwrap();
            }
            if frame == 4 {
                one.pin_vertex(free, 30, [0.1, 0.1, 0.1]).unwrap();
            }
            one.submit(1).unwrap();
        }
        one.unpin_vertex(free, 30).unwrap();
        one.move_collider(ball, Pose::default()).unwrap();
        one.poll().unwrap();
        one.advance(2).unwrap();
    }
    assert_eq!(simulation.frozen().len(), 1);
    assert_eq!(simulation.state_hash(), pinned.state_hash());
    // And from a snapshot, with the pin where it stopped.
    let snapshot = simulation.snapshot();
    let mut other = Simulation::new(&scene, &freeze).unwrap();
    other.restore(&snapshot).unwrap();
    for one in [&mut simulation, &mut other] {
        one.advance(2).unwrap();
    }
    assert_eq!(simulation.state_hash(), other.state_hash());
}

#[test]
fn frames_that_are_good_one_by_one_are_good_together() {
    // What a hand pulls apart gains more than four times its energy in some frames, but not in one.
    let pull = |simulation: &mut Simulation, ways: &[f64], one_by_one: bool| {
        let held = simulation.body("sheet 3").unwrap();
        for far in ways {
            simulation.pin_vertex(held, 41, [0.15 + far, 0.06, 0.125]).unwrap();
            simulation.submit(1).unwrap();
            if one_by_one {
                simulation.poll().unwrap();
            }
        }
        simulation.poll().map(drop)
    };
    let [freeze, stop] = [OnDivergence::Freeze, OnDivergence::Stop].map(|on| options(on, Precision::F64, 1));
    let [mut frozen, mut single, mut stopped] =
        [&freeze, &stop, &stop].map(|on| Simulation::new(&sheets(false), on).unwrap());
    for one in [&mut frozen, &mut single, &mut stopped] {
        pin_all(one, "sheet 3");
        pull(one, &[0.5, 0.9], true).unwrap();
    }
    let ways = [1.5, 2.5, 4.2, 7.0];
    pull(&mut stopped, &ways, false).unwrap_err();
    pull(&mut single, &ways, true).unwrap();
    pull(&mut frozen, &ways, false).unwrap();
    assert_eq!((frozen.frozen().len(), frozen.state_hash()), (0, single.state_hash()));
}

#[test]
fn what_no_freezing_mends_stops_the_scene() {
    let mut simulation = freezing(&sheets(false));
    pin_all(&mut simulation, "sheet 3");
    simulation.advance(2).unwrap();
    let (hash, before) = (simulation.state_hash(), positions(&simulation));
    // A hand pulls apart what nothing else moves.
    let held = simulation.body("sheet 3").unwrap();
    simulation.pin_vertex(held, 41, [900.0, 0.0, 0.0]).unwrap();
    let error = simulation.step().unwrap_err();
    assert!(matches!(&error, StepError::Diverged(end) if end.body == "sheet 3"), "{error}");
    assert_eq!((simulation.state_hash(), positions(&simulation)), (hash, before));
    assert_eq!((simulation.frame(), simulation.frozen().len()), (2, 0));
    assert_eq!(simulation.step().unwrap_err().to_string(), error.to_string());
}
