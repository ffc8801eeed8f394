//! Bodies and colliders that a program puts elsewhere at once.

use crate::common::{build_as, farthest, positions, run, turned};
use crate::gpu::on_gpu;
use taffeta::glam::{DAffine3, DQuat, DVec3};
use taffeta::scene::{
    Body, Collider, ConstraintForm, Ice, Icosphere, Keyframe, Mass, Mesh, Method, Pin, Scene, Select,
    SelfCollision, Sleep,
};
use taffeta::{InputError, Pose, Precision, Simulation};

/// Far away and turned: gravity must stay where it is.
fn motion() -> (DQuat, DVec3) {
    (DQuat::from_rotation_y(1.3), DVec3::new(20.0, 3.0, -45.0))
}

/// A cape on a moving bar that falls on a ball and a box.
fn cape(ice: Option<Ice>) -> Scene {
    let hold = Keyframe::translate(0.0, [0.0; 3]);
    let cape = Body::cloth("cape", Mesh::grid(12, 9, [0.5, 0.4])).with_mass(Mass::Node(0.005));
    let touching = SelfCollision { thickness: 0.004, ..SelfCollision::default() };
    let cape =
        Body { self_collision: Some(touching), place: turned([1.0, 0.0, 0.0], 20.0, [0.0; 3]), ..cape };
    let mut scene = Scene::new("cape")
        .body(cape.structural(60.0, 0.02).shear(20.0, 0.02).pin_moving(Select::rows(0, 0), vec![hold]))
        .collider(Collider::mesh(Mesh::Icosphere(Icosphere { radius: 0.1, subdivisions: 2 })).named("ball"))
        .collider(Collider::cuboid([0.12, -0.15, 0.0], [0.05, 0.05, 0.05]).friction(0.3))
        .time(0.01, 1e-3);
    scene.colliders[0].place.position = [-0.08, -0.16, 0.0];
    if let Some(ice) = ice {
        scene = scene.method(Method::Ice).time(0.01, 0.005);
        scene.solver.ice = Ice { form: ConstraintForm::Primal, ..ice };
    }
    scene
}

/// Puts all of it elsewhere.
fn teleport(simulation: &mut Simulation) {
    let (turn, shift) = motion();
    let body = simulation.bodies()[0].handle;
    simulation.teleport_body(body, Pose::new(turn, shift)).unwrap();
    for index in 0..simulation.colliders().len() {
        let collider = simulation.colliders()[index].handle;
        simulation.teleport_collider(collider, Pose::new(turn, shift)).unwrap();
    }
}

/// Sends the bar on, from where it was put.
fn send(simulation: &mut Simulation, frame: u32, (turn, shift): (DQuat, DVec3)) {
    let pin = simulation.pin(simulation.bodies()[0].handle, 0).unwrap();
    let own = DVec3::new(0.004, 0.0, 0.002) * f64::from(frame);
    simulation.move_pin(pin, Pose::new(turn, shift + turn * own)).unwrap();
}

/// How far a cape that is put elsewhere is from where it would be, frame by frame [m].
fn off(mut start: impl FnMut() -> Simulation) -> Vec<f64> {
    let (mut stays, mut goes) = (start(), start());
    let stay = (DQuat::IDENTITY, DVec3::ZERO);
    // Before it touches anything: what contacts remember is forgotten.
    for frame in 0..4 {
        [&mut stays, &mut goes].into_iter().for_each(|one| send(one, frame, stay));
        run(&mut stays, 1);
        run(&mut goes, 1);
    }
    teleport(&mut goes);
    let whole = DAffine3::from_rotation_translation(motion().0, motion().1);
    let off = (4..25).map(|frame| {
        send(&mut stays, frame, stay);
        send(&mut goes, frame, motion());
        run(&mut stays, 1);
        run(&mut goes, 1);
        let there = |&x: &[f64; 3]| whole.transform_point3(x.into()).to_array();
        let expected: Vec<[f64; 3]> = positions(&stays).iter().map(there).collect();
        farthest(&expected, &positions(&goes))
    });
    let off = off.collect();
    let mut distances = Vec::new();
    goes.collider_distances(1.0, &mut distances);
    let near = distances.iter().filter(|&&distance| distance < 0.015).count();
    assert!(near > 3, "{near} nodes at colliders");
    off
}

#[test]
fn cloth_that_is_put_elsewhere_with_all_around_it_moves_on_as_it_would_have() {
    let ice = |order, tolerance| Some(Ice { order, tolerance, ..Ice::default() });
    // At second order roundings decide which nodes bounce off the ball, from the thirteenth frame on.
    for (ice, frames) in [(None, 21), (ice(1, 1e-9), 21), (ice(2, 1e-9), 12)] {
        let found = off(|| build_as(&cape(ice.clone()), Precision::F64, 2));
        assert!(found[..frames].iter().all(|&off| off < 1e-6), "{ice:?}: {found:?} m");
    }
    // In 32 bits no solver reaches more.
    for (ice, frames) in [(None, 21), (ice(2, 1e-4), 12)] {
        let found = off(|| on_gpu(&cape(ice.clone())));
        assert!(found[..frames].iter().all(|&off| off < 5e-3), "{ice:?} on a GPU: {found:?} m");
    }
}

#[test]
fn a_run_that_is_restored_after_it_goes_on_bit_by_bit() {
    let start = || build_as(&cape(None), Precision::F32, 1);
    let mut whole = start();
    run(&mut whole, 5);
    teleport(&mut whole);
    send(&mut whole, 5, motion());
    run(&mut whole, 2);
    let mut again = start();
    again.restore(&whole.snapshot()).unwrap();
    for one in [&mut whole, &mut again] {
        send(one, 7, motion());
        run(one, 3);
    }
    assert_eq!(whole.state_hash(), again.state_hash());
}

#[test]
fn what_follows_keyframes_stays_on_them() {
    let mut scene = cape(None);
    scene.bodies[0].pins[0].motion = vec![Keyframe::translate(1.0, [0.0, 1.0, 0.0])];
    scene.colliders[0].motion = vec![Keyframe::translate(1.0, [0.0, 1.0, 0.0])];
    let mut simulation = build_as(&scene, Precision::F64, 1);
    let (body, collider) = (simulation.bodies()[0].handle, simulation.colliders()[0].handle);
    let before = simulation.state_hash();
    let to = Pose::new(motion().0, motion().1);
    for (found, wanted) in [
        (simulation.teleport_body(body, to), "pin 0 of body `cape`"),
        (simulation.teleport_collider(collider, to), "collider `ball`"),
    ] {
        let Err(InputError::FollowsKeyframes { what }) = found else { panic!("{found:?}") };
        assert_eq!(what, wanted);
    }
    assert_eq!(simulation.state_hash(), before);
}

#[test]
fn a_teleport_that_cannot_be_changes_nothing() {
    let mut simulation = build_as(&cape(None), Precision::F64, 1);
    let body = simulation.bodies()[0].handle;
    let before = simulation.state_hash();
    // The second takes a part of the body too far only, as the first has brought it there.
    for (far, works) in [(1e9, false), (9e5, true), (9e5, false)] {
        let far = Pose::new(DQuat::IDENTITY, DVec3::new(far, 0.0, 0.0));
        let at = simulation.state_hash();
        let done = simulation.teleport_body(body, far);
        assert_eq!((done.is_ok(), simulation.state_hash() != at), (works, works), "{done:?}");
    }
    assert_ne!(simulation.state_hash(), before);

    let mut scene = cape(None);
    scene.bodies[0].pins[0] =
        Pin { motion: Vec::new(), break_force: Some(5.0), ..scene.bodies[0].pins[0].clone() };
    let mut simulation = build_as(&scene, Precision::F64, 1);
    let (body, before) = (simulation.bodies()[0].handle, simulation.state_hash());
    let refused = simulation.teleport_body(body, Pose::new(motion().0, motion().1));
    let Err(InputError::Immovable { pin: 0, .. }) = refused else { panic!("{refused:?}") };
    assert_eq!(simulation.state_hash(), before);
}

#[test]
fn what_lay_on_a_body_that_is_put_elsewhere_wakes_up_and_falls() {
    let sheet = |name: &str, y: f64| {
        let touching = SelfCollision { thickness: 0.01, ..SelfCollision::default() };
        let sheet =
            Body::cloth(name, Mesh::grid(6, 6, [0.3, 0.3])).with_mass(Mass::Node(0.01)).at([0.0, y, 0.0]);
        Body { self_collision: Some(touching), ..sheet.structural(40.0, 0.5).shear(20.0, 0.5) }
    };
    let lower = sheet("lower", 0.0).pin(Select::nodes((0..36).collect::<Vec<_>>()));
    let mut scene = Scene::new("asleep").body(lower).body(sheet("upper", 0.0101)).time(0.01, 1e-3);
    scene.sleep = Some(Sleep::default());
    let mut simulation = build_as(&scene, Precision::F64, 1);
    while simulation.report().asleep < 2 {
        assert!(simulation.step().unwrap().time < 10.0, "{:?}", simulation.report());
    }
    let first = simulation.bodies()[0].nodes;
    let before = positions(&simulation)[first];
    let lower = simulation.bodies()[0].handle;
    simulation.teleport_body(lower, Pose::new(DQuat::IDENTITY, DVec3::new(5.0, 0.0, 0.0))).unwrap();
    run(&mut simulation, 30);
    let fallen = before[1] - positions(&simulation)[first][1];
    let free = 9.81 * 0.3 * 0.3 / 2.0;
    assert!((fallen - free).abs() < 0.1 * free, "{fallen} m");
}

#[test]
fn cloth_that_a_collider_is_put_into_is_pushed_out_of_it() {
    for start in [|scene: &Scene| build_as(scene, Precision::F64, 1), |scene: &Scene| on_gpu(scene)] {
        let mut scene = cape(None);
        scene.bodies[0].self_collision = None;
        let mut simulation = start(&scene);
        run(&mut simulation, 3);
        let ball = simulation.collider("ball").unwrap();
        simulation.teleport_collider(ball, Pose::new(DQuat::IDENTITY, DVec3::new(0.08, 0.08, 0.0))).unwrap();
        let deepest = |simulation: &Simulation| {
            let mut distances = Vec::new();
            simulation.collider_distances(1.0, &mut distances);
            distances.into_iter().fold(f32::INFINITY, f32::min)
        };
        let mut all = vec![(deepest(&simulation), simulation.report().max_stretch)];
        for _ in 0..40 {
            run(&mut simulation, 1);
            all.push((deepest(&simulation), simulation.report().max_stretch));
        }
        let (before, (after, stretch)) = (all[0].0, all[40]);
        assert!(before < -0.02 && after > -2e-3 && stretch < 1.5, "{all:?}");
    }
}
