//! After a blow-up there is nothing to see of it: the last good state stays, and no frame runs before a snapshot is restored.

use crate::common::{build, build_as, positions};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use taffeta::scene::{Body, Mass, Mesh, Method, Scene, Select, World};
use taffeta::{InputError, Options, Precision, Simulation, StepError};

/// A sheet a little too stiff for its step, and another that would hold.
pub fn bursting() -> Scene {
    let sheet = |name: &str, k: f64| {
        let body = Body::cloth(name, Mesh::grid(6, 7, [0.6, 0.5])).with_mass(Mass::Node(1e-3));
        body.structural(k, 1e-4).pin(Select::nodes([0]))
    };
    Scene::new("bursts").time(0.01, 2.5e-3).body(sheet("soft", 1.0)).body(sheet("stiff", 160.0))
}

/// Steps by some frames until there is an error. Returns the state before it, and the error.
pub fn burst(simulation: &mut Simulation, frames: u32) -> (u64, Vec<[f64; 3]>, StepError) {
    simulation.disturb(1e-6, 1);
    for _ in 0..100 {
        let (hash, before) = (simulation.state_hash(), positions(simulation));
        if let Err(error) = simulation.advance(frames) {
            return (hash, before, error);
        }
    }
    panic!("it held");
}

#[test]
fn positions_after_a_blow_up_are_those_of_the_last_good_frame() {
    for (precision, frames) in [(Precision::F32, 1), (Precision::F64, 1), (Precision::F32, 3)] {
        let mut simulation = build_as(&bursting(), precision, 2);
        let (hash, before, error) = burst(&mut simulation, frames);
        let StepError::Diverged(end) = &error else { panic!("{error}") };
        assert_eq!((end.body.as_str(), end.first - 1), ("stiff", simulation.frame()));
        assert!(simulation.frame() >= frames, "{precision:?}, {frames}");
        assert_eq!((simulation.state_hash(), positions(&simulation)), (hash, before));
        assert!(simulation.report().is_finite());
        let mut velocities: Vec<[f32; 3]> = Vec::new();
        simulation.velocities_f32(&mut velocities);
        assert!(velocities.iter().flatten().all(|v| v.is_finite()));
    }
}

#[test]
fn a_frame_with_contact_that_is_broken_off_as_it_blows_up_leaves_nothing_behind() {
    // The drag of the air is far too much for the step: velocities change their sign, and grow, in each.
    let sheet = |name: &str, height: f64| {
        let body = Body::cloth(name, Mesh::grid(12, 12, [0.3, 0.3])).with_mass(Mass::Node(1e-3));
        body.structural(20.0, 1e-3).collide(0.005).at([0.0, height, 0.0])
    };
    let mut scene = Scene::new("held").time(0.02, 1e-3).body(sheet("lower", 0.0)).body(sheet("upper", 0.006));
    scene.bodies[0] = scene.bodies[0].clone().pin(Select::nodes([0]));
    scene.world.drag = 2000.0;
    for threads in [1, 3] {
        let mut simulation =
            Simulation::new(&scene, &Options { threads: Some(threads), ..Options::default() }).unwrap();
        let before = positions(&simulation);
        let error = simulation.step().unwrap_err();
        assert!(matches!(&error, StepError::Diverged(_)), "{error}");
        assert_eq!((simulation.frame(), positions(&simulation)), (0, before));
        // Without that drag it goes on as if it had never had it.
        let calm = World { drag: 0.0, ..World::default() };
        let mut fresh =
            Simulation::new(&scene, &Options { threads: Some(threads), ..Options::default() }).unwrap();
        let start = fresh.snapshot();
        for one in [&mut simulation, &mut fresh] {
            one.restore(&start).unwrap();
            one.set_world(&calm).unwrap();
            one.advance(5).unwrap();
        }
        assert_eq!(simulation.state_hash(), fresh.state_hash());
    }
}

#[test]
fn a_simulation_that_blew_up_says_so_again_and_computes_nothing() {
    let mut simulation = build(&bursting());
    let good = simulation.snapshot();
    let (hash, _, error) = burst(&mut simulation, 1);
    let frame = simulation.frame();
    for _ in 0..3 {
        assert_eq!(simulation.step().unwrap_err().to_string(), error.to_string());
        assert_eq!(simulation.submit(2).unwrap_err().to_string(), error.to_string());
        assert_eq!(simulation.poll().unwrap_err().to_string(), error.to_string());
        assert_eq!((simulation.frame(), simulation.state_hash()), (frame, hash));
    }
    let after = simulation.snapshot();
    assert!(simulation.restore(&after).unwrap_err().to_string().contains("one from before would do"));
    simulation.restore(&good).unwrap();
    let mut fresh = build(&bursting());
    for frame in 1..4 {
        assert_eq!(simulation.step().unwrap().frame, frame);
        fresh.step().unwrap();
        assert_eq!(simulation.state_hash(), fresh.state_hash());
    }
}

#[test]
fn what_solvers_remember_of_a_frame_that_blew_up_goes_nowhere() {
    let scene = bursting().method(Method::Ice);
    let fresh = build(&scene);
    let mut failed = build(&scene);
    failed.advance(3).unwrap();
    let (good, before) = (failed.snapshot(), positions(&failed));
    failed.apply_force(failed.body("soft").unwrap(), 20, [1e15, 0.0, 0.0]).unwrap();
    assert!(matches!(failed.step(), Err(StepError::Diverged(_))));
    let pulls = |simulation: &Simulation| simulation.snapshot().constraints;
    assert_ne!(pulls(&failed), good.constraints, "they remember the frame");
    let mut next = build(&scene);
    next.adopt_state(&failed);
    assert_eq!((positions(&next), pulls(&next)), (before, pulls(&fresh)));
    // One that has failed goes on from a snapshot, or with the state of another.
    let mut whole = build(&scene);
    whole.advance(4).unwrap();
    failed.restore(&good).unwrap();
    failed.step().unwrap();
    assert_eq!(failed.state_hash(), whole.state_hash());
    failed.apply_force(failed.body("soft").unwrap(), 20, [1e15, 0.0, 0.0]).unwrap();
    failed.step().unwrap_err();
    failed.adopt_state(&whole);
    assert_eq!(failed.step().unwrap().frame, 5);
}

#[test]
fn a_frame_that_is_stopped_leaves_those_under_way_whole() {
    let (mut simulation, mut whole) = (build(&bursting()), build(&bursting()));
    simulation.submit(2).unwrap();
    let stopped = simulation.step_unless(&Arc::new(AtomicBool::new(true)));
    assert!(matches!(stopped, Err(StepError::Stopped { frame: 3 })));
    whole.advance(2).unwrap();
    assert_eq!((simulation.frame(), simulation.state_hash()), (2, whole.state_hash()));
}

#[test]
fn a_simulation_that_takes_over_from_one_that_blew_up_gets_no_number_that_is_none() {
    let mut simulation = build(&bursting());
    let (_, before, _) = burst(&mut simulation, 1);
    let mut scene = bursting();
    scene.time.max_step = Some(1e-5);
    let mut next = build(&scene);
    next.adopt_state(&simulation);
    assert_eq!(positions(&next), before);
    assert!(next.step().unwrap().is_finite());
}

#[test]
fn frames_beyond_32_bits_are_refused() {
    let mut simulation = build(&bursting());
    simulation.step().unwrap();
    let error = simulation.submit(u32::MAX).unwrap_err();
    assert!(matches!(error, StepError::Input(InputError::TooManyFrames { before: 1, frames: u32::MAX })));
    assert_eq!(simulation.frame(), 1);
}
