//! A simulation that is restored from a snapshot goes on as if it had never stopped.

use crate::common::{add, build_as, positions, run};
use taffeta::scene::{Body, Collider, Icosphere, Keyframe, Kind, Mass, Mesh, Method, Scene, Select, World};
use taffeta::{Pose, Precision, Simulation};

/// Cloth with a moving pin and one for the hand, beside a soft ball with hinges that falls onto a plane.
fn scene() -> Scene {
    let cloth = Body::cloth("cloth", Mesh::grid(9, 11, [0.4, 0.3]))
        .with_mass(Mass::Node(0.01))
        .structural(50.0, 0.05)
        .shear(30.0, 0.02)
        .bend(5.0, 0.0)
        .pin(Select::nodes([0]))
        .pin_moving(Select::nodes([10]), vec![Keyframe::translate(0.2, [0.1, 0.0, 0.05])]);
    let ball = Mesh::Icosphere(Icosphere { radius: 0.1, subdivisions: 2 });
    let mut ball = Body::cloth("ball", ball).with_mass(Mass::Whole(0.5)).structural(200.0, 0.1);
    ball.kind = Kind::Soft;
    ball.springs.hinge = Some(taffeta::scene::Hinge { k: 0.01, d: 1e-5 });
    let mut scene = Scene::new("stopped").time(0.01, 0.001).body(cloth).body(ball);
    scene.colliders.push(Collider::plane([0.0, -0.12, 0.0], [0.0, 1.0, 0.0]));
    scene
}

/// The same with springs that are, or become, constraints, and fewer sub-steps.
fn constrained(method: Method) -> Scene {
    scene().method(method).time(0.01, 0.0025)
}

/// Frame by frame the same pulls of the hand.
fn pull(simulation: &mut Simulation, frames: std::ops::Range<u32>) {
    for frame in frames {
        let to = add([0.1, 0.02, 0.1], [0.0, 0.001 * f64::from(frame), 0.0]);
        if frame % 5 < 3 {
            simulation.pin_vertex(simulation.body("cloth").unwrap(), 50, to).unwrap();
        }
        simulation
            .apply_force(simulation.body("ball").unwrap(), 3, [0.1, 0.0, f64::from(frame % 3)])
            .unwrap();
        run(simulation, 1);
    }
}

#[test]
fn a_restored_simulation_goes_on_bit_by_bit() {
    for precision in [Precision::F32, Precision::F64] {
        // The last frame before a stop moves the pin, or lets it stand.
        for stop in [8, 9, 11] {
            let mut whole = build_as(&scene(), precision, 1);
            pull(&mut whole, 0..stop);
            let snapshot = whole.snapshot();
            pull(&mut whole, stop..20);
            for threads in [1, 3] {
                let mut again = build_as(&scene(), precision, threads);
                again.restore(&snapshot).unwrap();
                assert_eq!(again.snapshot(), snapshot, "what is restored is what was taken");
                pull(&mut again, stop..20);
                assert_eq!(again.state_hash(), whole.state_hash(), "{precision}, stopped at {stop}");
                assert_eq!(again.report(), whole.report());
            }
        }
    }
}

/// A checkpoint of a simulation whose constraints have something to remember.
fn taut(method: Method, precision: Precision) -> taffeta::Snapshot {
    let mut whole = build_as(&constrained(method), precision, 2);
    pull(&mut whole, 0..9);
    let snapshot = whole.snapshot();
    let active = whole.report().solver.active_fraction;
    // All or some springs: both are to be found again.
    assert!(if method == Method::Ice { active == 1.0 } else { active > 0.0 && active < 1.0 }, "{active}");
    assert!(snapshot.constraints.iter().any(|&byte| byte != 0));
    snapshot
}

#[test]
fn constraints_go_on_bit_by_bit_and_would_not_without_what_they_remember() {
    for (method, precision) in
        [(Method::Ice, Precision::F32), (Method::Acad, Precision::F32), (Method::Acad, Precision::F64)]
    {
        let mut whole = build_as(&constrained(method), precision, 1);
        pull(&mut whole, 0..14);
        let snapshot = taut(method, precision);
        let again = |snapshot: &taffeta::Snapshot, threads| {
            let mut again = build_as(&constrained(method), precision, threads);
            // It may have been elsewhere before.
            pull(&mut again, 0..threads as u32 - 1);
            again.restore(snapshot).unwrap();
            assert_eq!(again.snapshot(), *snapshot, "what is restored is what was taken");
            pull(&mut again, 9..14);
            (again.state_hash(), again.report().clone())
        };
        for threads in [1, 2, 3] {
            assert_eq!(again(&snapshot, threads), (whole.state_hash(), whole.report().clone()), "{method:?}");
        }
        let pulls = snapshot.pulls as usize * precision.bytes();
        for lost in [0..pulls, pulls..snapshot.constraints.len()].into_iter().filter(|lost| !lost.is_empty())
        {
            let mut forgetful = snapshot.clone();
            forgetful.constraints[lost].fill(0);
            assert_ne!(again(&forgetful, 1).0, whole.state_hash(), "{method:?}: nothing depends on it");
        }
    }
}

#[test]
fn a_constraint_that_is_no_longer_too_long_is_still_one_after_a_stop() {
    let links = Body::cloth("link", Mesh::chain(1, 1.0)).with_mass(Mass::Node(1.0)).structural(1.0, 0.0);
    let mut scene = Scene::new("drawn").time(0.01, 0.01).method(Method::Acad).body(links);
    scene.world.gravity = [0.0; 3];
    // It gives way so much that it takes some steps to get from 1.2 to 1.
    scene.solver.acad.epsilon = 20.0;
    let build = || build_as(&scene, Precision::F64, 1);
    let mut whole = build();
    let mut drawn = whole.snapshot();
    drawn.state[24..32].copy_from_slice(&0.7_f64.to_le_bytes());
    whole.restore(&drawn).unwrap();
    while whole.report().max_stretch > 1.1 || whole.frame() == 0 {
        run(&mut whole, 1);
    }
    let snapshot = whole.snapshot();
    let mut again = build();
    again.restore(&snapshot).unwrap();
    for simulation in [&mut whole, &mut again] {
        run(simulation, 1);
        assert_eq!(simulation.report().solver.active_fraction, 1.0, "nothing but memory says so");
    }
    assert_eq!(again.snapshot(), whole.snapshot());
}

#[test]
fn what_constraints_remember_takes_little_and_is_rounded_with_the_state() {
    let fine = taut(Method::Acad, Precision::F64);
    let springs = build_as(&scene(), Precision::F64, 1)
        .bodies()
        .iter()
        .flat_map(|body| &body.springs)
        .map(|(_, n)| n)
        .sum::<usize>();
    assert_eq!((fine.pulls, fine.adaptive), (springs as u64, springs as u64));
    assert_eq!(fine.constraints.len(), 8 * springs + springs.div_ceil(8));
    let mut coarse = build_as(&constrained(Method::Acad), Precision::F32, 1);
    coarse.restore(&fine).unwrap();
    let coarse = coarse.snapshot();
    let [many, few] =
        [&fine, &coarse].map(|all| all.constraints.split_at(all.pulls as usize * all.precision.bytes()));
    let rounded: Vec<_> = many.0.as_chunks().0.iter().map(|&pull| f64::from_le_bytes(pull) as f32).collect();
    let found: Vec<_> = few.0.as_chunks().0.iter().map(|&pull| f32::from_le_bytes(pull)).collect();
    assert_eq!((found, few.1), (rounded, many.1));
    // What starts from nothing, or is always there, needs nothing.
    let mut cold = constrained(Method::Ice);
    cold.solver.ice.warm_start = false;
    cold.colliders.clear();
    let cold = build_as(&cold, Precision::F32, 1).snapshot();
    assert_eq!((cold.pulls, cold.adaptive, cold.constraints.len()), (0, 0, 0));
}

#[test]
fn a_snapshot_in_64_bits_is_rounded_to_32() {
    let mut fine = build_as(&scene(), Precision::F64, 1);
    pull(&mut fine, 0..10);
    let mut coarse = build_as(&scene(), Precision::F32, 1);
    coarse.restore(&fine.snapshot()).unwrap();
    let rounded: Vec<_> = positions(&fine).into_iter().map(|p| p.map(|x| f64::from(x as f32))).collect();
    assert_eq!(positions(&coarse), rounded);
    assert_eq!(coarse.frame(), 10);
}

#[test]
fn a_snapshot_of_something_else_is_refused_and_changes_nothing() {
    let mut simulation = build_as(&scene(), Precision::F32, 1);
    let before = simulation.state_hash();
    let good = simulation.snapshot();
    let mut refused = |change: &dyn Fn(&mut taffeta::Snapshot), words: &str| {
        let mut snapshot = good.clone();
        change(&mut snapshot);
        let error = simulation.restore(&snapshot).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
        assert_eq!(simulation.state_hash(), before);
    };
    refused(&|s| s.held.push(1), "node 1 is held in it and free in the scene");
    refused(&|s| s.changes.pinned.push(3), "node 3 is pinned by a program in it, and not held");
    refused(&|s| s.changes.pinned.push(261), "it pins node 261, the scene has 261");
    refused(&|s| s.changes.world.drag = -1.0, "world.drag: is -1 kg/s");
    refused(&|s| s.changes.colliders.push((7, Keyframe::default())), "it moves collider 7");
    let far = Keyframe { translate: [1e300, 0.0, 0.0], ..Keyframe::default() };
    refused(&|s| s.changes.colliders.push((0, far.clone())), "collider.motion[0].translate: is [1e300");
    refused(&|s| s.scene ^= 1, "it is of another scene");
    refused(&|s| s.start.springs = f64::NAN, "the report of its start has an energy");
    refused(&|s| s.report.kinetic = f64::INFINITY, "the report of its last frame has an energy");
    refused(&|s| s.start.frame = 1, "it is of frame 0, before its start in frame 1");
    refused(&|s| s.nodes = 7, "it holds 7 nodes, the scene has 261");
    refused(&|s| s.state.truncate(100), "has 100 bytes");
    refused(&|s| s.held.push(261), "node 261");
    refused(&|s| s.held.clear(), "node 0 is free in it and held in the scene");
    let nan = f32::NAN.to_le_bytes();
    refused(&|s| s.state[12 * 5..12 * 5 + 4].copy_from_slice(&nan), "node 5 has a number that is not finite");
    refused(&|s| s.pulls = 3, "it holds 3 pulls of constraints, the scene has 0");
    let mut fine = build_as(&scene(), Precision::F64, 1).snapshot();
    fine.state[8 * 5..8 * 6].copy_from_slice(&1e200_f64.to_le_bytes());
    refused(&|s| *s = fine.clone(), "node 1 has a number that is not finite in 32 bits");
    let mut heavier = scene();
    heavier.bodies[0].node_mass = Some(0.5);
    let heavier = build_as(&heavier, Precision::F32, 1).snapshot();
    refused(&|s| *s = heavier.clone(), "it is of another scene");
    let good = taut(Method::Acad, Precision::F32);
    let count = good.pulls;
    let mut simulation = build_as(&constrained(Method::Acad), Precision::F32, 1);
    let before = simulation.snapshot();
    let mut refused = |change: &dyn Fn(&mut taffeta::Snapshot), words: &str| {
        let mut snapshot = good.clone();
        change(&mut snapshot);
        let error = simulation.restore(&snapshot).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
        assert_eq!(simulation.snapshot(), before);
    };
    refused(&|s| s.pulls = 3, &format!("it holds 3 pulls of constraints, the scene has {count}"));
    refused(&|s| s.adaptive = 0, &format!("it holds 0 constraints that come and go, the scene has {count}"));
    refused(&|s| s.constraints.truncate(9), &format!("what its {count} constraints remember has 9 bytes"));
    refused(
        &|s| s.constraints[4 * 6..4 * 7].copy_from_slice(&nan),
        "constraint 6 has a pull that is not finite",
    );
}

#[test]
fn what_a_program_has_changed_comes_back_with_the_state() {
    let program = |simulation: &mut Simulation, frames: std::ops::Range<u32>| {
        let (cloth, floor) = (simulation.body("cloth").unwrap(), simulation.collider("collider0").unwrap());
        let pin = simulation.pin(cloth, 1).unwrap();
        for frame in frames {
            let share = 0.01 * f64::from(frame);
            simulation
                .move_collider(floor, Pose { translate: [0.0, share, 0.0], ..Pose::default() })
                .unwrap();
            if frame >= 20 {
                simulation.move_pin(pin, Pose { translate: [0.1, share, 0.05], ..Pose::default() }).unwrap();
            }
            if frame % 4 == 1 {
                simulation.pin_vertex(cloth, 60 + frame as usize, [0.1, 0.1 + share, 0.0]).unwrap();
            }
            if frame % 4 == 3 {
                simulation.unpin_vertex(cloth, 58 + frame as usize).unwrap();
            }
            let world = World { drag: 1e-3 * f64::from(frame % 3), ..World::default() };
            simulation.set_world(&world).unwrap();
            run(simulation, 1);
        }
    };
    for precision in [Precision::F32, Precision::F64] {
        let mut whole = build_as(&scene(), precision, 1);
        program(&mut whole, 0..22);
        let snapshot = whole.snapshot();
        program(&mut whole, 22..30);
        let mut fresh = build_as(&scene(), precision, 2);
        fresh.restore(&snapshot).unwrap();
        assert_eq!(fresh.snapshot(), snapshot);
        program(&mut fresh, 22..30);
        assert_eq!(fresh.state_hash(), whole.state_hash());
        // The same simulation goes back, and to before the program changed anything.
        whole.restore(&snapshot).unwrap();
        program(&mut whole, 22..30);
        assert_eq!(fresh.state_hash(), whole.state_hash());
        let start = build_as(&scene(), precision, 1);
        whole.restore(&start.snapshot()).unwrap();
        assert_eq!(whole.snapshot(), start.snapshot());
        program(&mut whole, 0..30);
        assert_eq!(fresh.state_hash(), whole.state_hash());
    }
}
