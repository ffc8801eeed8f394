//! The same bits however a scene runs, and what is remembered from one frame to the next.

use super::common::compare::cloth;
use super::common::{build_as, levels, positions, run, turned};
use super::{chain, stiffen, with_acad, with_ice};
use taffeta::scene::{
    Acad, Body, Collider, ConstraintForm, Ice, Icosphere, Internal, Keyframe, Mass, Mesh, Method,
};
use taffeta::scene::{Scene, Select};
use taffeta::{Precision, Simulation};

/// A sheet that a moving pin pulls, a soft ball with struts that lands, a chain, and a sheet that nothing holds.
fn bodies() -> Scene {
    let pull = vec![Keyframe::translate(0.05, [0.05, 0.1, -0.02])];
    let mut sheet = cloth(24, 21, [2.0, 2.3]).pin_moving(Select::nodes([0, 20]), pull);
    sheet.place = turned([1.0, 0.2, 0.0], 70.0, [0.0, 2.0, 0.0]);
    let mesh = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 3 });
    let mut ball =
        Body::soft("ball", mesh).with_mass(Mass::Node(0.02)).structural(90.0, 0.05).bend(30.0, 0.01);
    ball.springs.internal = Some(Internal { count: 200, k: 60.0, d: 0.05, ..Internal::default() });
    let free = Body { name: "free".into(), ..cloth(5, 130, [12.9, 0.4]) }.hinge(1e-3, 1e-5);
    let mut scene = Scene::new("bits")
        .time(0.01, 0.005)
        .body(sheet)
        .body(ball.at([5.0, 0.49, 0.0]))
        .body(chain(300, 30.0, 0.02, [90.0, 0.05]).at([0.0, 1.0, 4.0]).pin(Select::nodes([150])))
        .body(free.at([0.0, 1.0, 6.0]))
        .collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]));
    scene.bodies.iter_mut().for_each(|body| stiffen(body, 3.0));
    scene
}

/// Loose and few iterations, so that what they start from shows.
fn scenes() -> [Scene; 3] {
    let rough = Ice { tolerance: 1e-3, max_iterations: 5, ..Ice::default() };
    let mut ice = bodies();
    ice.bodies.iter_mut().for_each(|body| stiffen(body, 100.0));
    let acad = Acad { threshold: 0.01, release: 0.005, target: 0.002, ..Acad::default() };
    let printed = Acad { form: ConstraintForm::Printed, ..acad.clone() };
    [
        with_ice(ice, rough.clone()),
        with_acad(bodies(), acad, rough.clone()),
        with_acad(bodies(), printed, Ice { max_iterations: 3, warm_start: false, ..rough }),
    ]
}

fn start(scene: &Scene, precision: Precision, threads: usize) -> Simulation {
    let mut simulation = build_as(scene, precision, threads);
    simulation.disturb(0.002, 11);
    simulation
}

fn ran(scene: &Scene, precision: Precision, threads: usize) -> Simulation {
    let mut simulation = start(scene, precision, threads);
    run(&mut simulation, 4);
    simulation
}

#[test]
fn any_number_of_threads_gives_the_same_bits_and_every_time() {
    for scene in scenes() {
        for precision in [Precision::F32, Precision::F64] {
            let one = ran(&scene, precision, 1);
            let solver = &one.report().solver;
            assert!(solver.iterations > 2 && one.report().contacts > 0, "{solver:?}");
            assert!(solver.active_fraction > 0.05, "{solver:?}");
            for threads in [1, 2, 3, 8] {
                let many = ran(&scene, precision, threads);
                assert_eq!(one.state_hash(), many.state_hash(), "{:?}, {precision}, {threads}", scene.solver);
                assert_eq!(one.report(), many.report(), "{:?}, {precision}, {threads}", scene.solver);
            }
        }
    }
}

#[test]
#[ignore = "run by the test of vector instructions, in processes of their own"]
fn prints_hashes() {
    for scene in scenes() {
        for precision in [Precision::F32, Precision::F64] {
            println!("hash|{:?} {precision} {:016x}", scene.solver, ran(&scene, precision, 2).state_hash());
        }
    }
}

#[test]
fn any_vector_instructions_give_the_same_bits() {
    levels::assert_same("bits::prints_hashes", 6);
}

#[test]
fn each_body_moves_as_if_it_were_alone_and_in_any_order() {
    for scene in scenes() {
        let places = |bodies: &[Body], threads| {
            let mut simulation =
                build_as(&Scene { bodies: bodies.to_vec(), ..scene.clone() }, Precision::F32, threads);
            run(&mut simulation, 4);
            positions(&simulation)
        };
        let alone: Vec<_> = scene.bodies.iter().map(|body| places(std::slice::from_ref(body), 1)).collect();
        assert!(alone.concat() == places(&scene.bodies, 2), "{:?}", scene.solver);
        let turned: Vec<_> = scene.bodies.iter().rev().cloned().collect();
        let back: Vec<_> = alone.iter().rev().flatten().copied().collect();
        assert!(back == places(&turned, 2), "{:?}", scene.solver);
    }
}

#[test]
fn a_restored_simulation_goes_on_bit_by_bit() {
    for scene in scenes() {
        for precision in [Precision::F32, Precision::F64] {
            let mut whole = start(&scene, precision, 1);
            run(&mut whole, 2);
            let snapshot = whole.snapshot();
            run(&mut whole, 2);
            for threads in [1, 2] {
                let mut again = build_as(&scene, precision, threads);
                again.restore(&snapshot).unwrap();
                assert_eq!(again.snapshot(), snapshot, "what is restored is what was taken");
                run(&mut again, 2);
                assert_eq!(again.state_hash(), whole.state_hash(), "{:?}, {precision}", scene.solver);
                assert_eq!(again.report(), whole.report(), "{:?}, {precision}", scene.solver);
            }
        }
    }
}

/// Goes on from places and velocities alone: what else is remembered is that of a simulation just built.
fn from_state_alone(scene: &Scene, of: &Simulation) -> Simulation {
    let mut again = build_as(scene, of.precision(), 1);
    let mut snapshot = again.snapshot();
    let taken = of.snapshot();
    (snapshot.state, snapshot.start, snapshot.report) = (taken.state, taken.start, taken.report);
    again.restore(&snapshot).unwrap();
    again
}

#[test]
fn pulls_and_constraints_are_remembered_and_nothing_else() {
    let both = |scene: &Scene| {
        let mut whole = start(scene, Precision::F64, 1);
        run(&mut whole, 2);
        let mut again = from_state_alone(scene, &whole);
        for simulation in [&mut whole, &mut again] {
            run(simulation, 2);
        }
        whole.state_hash() == again.state_hash()
    };
    let [ice, acad, _] = scenes();
    let cold = |mut scene: Scene| {
        scene.solver.ice.warm_start = false;
        scene
    };
    // With what releases at the threshold, springs are what their lengths say.
    let at_once = |mut scene: Scene| {
        scene.solver.acad.release = scene.solver.acad.threshold;
        scene
    };
    assert!(!both(&ice), "pulls of ICE");
    assert!(!both(&cold(ice.clone())), "pulls of ICE, by which surfaces go");
    let free = Scene { colliders: Vec::new(), ..ice };
    assert!(both(&cold(free)), "ICE without them");
    assert!(!both(&at_once(acad.clone())), "pulls of ACAD");
    assert!(!both(&cold(acad.clone())), "constraints of ACAD");
    assert!(both(&cold(at_once(acad.clone()))), "ACAD without both");
    let mut springs = acad;
    springs.solver.method = Method::Springs;
    assert!(both(&springs), "springs");
}
