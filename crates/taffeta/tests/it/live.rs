//! What a program changes while a scene runs.

use crate::common::{build, build_as, farthest, gpu, near, positions, run, weightless};
use taffeta::scene::{Air, Body, Collider, Keyframe, Mass, Mesh, Place, Rotation, Scene, Select, World};
use taffeta::{InputError, Options, Pose, Precision, Simulation};

const DT: f64 = 0.01;

fn sheet(k: f64) -> Body {
    Body::cloth("sheet", Mesh::grid(6, 7, [0.6, 0.5])).with_mass(Mass::Node(0.01)).structural(k, 0.01)
}

/// Half a metre up and a turn, in two frames.
fn lifted(t: f64, share: f64) -> Keyframe {
    let rotate = Some(Rotation { axis: [0.0, 1.0, 0.0], degrees: 4.0 * share });
    Keyframe { t, translate: [0.0, 0.03 * share, 0.01 * share], rotate, ..Keyframe::default() }
}

fn pose(share: f64) -> Pose {
    let key = lifted(0.0, share);
    Pose { rotate: key.rotate.unwrap_or_default(), translate: key.translate }
}

#[test]
fn a_collider_and_pins_moved_from_frame_to_frame_do_what_keyframes_do() {
    let scene = |keys: &[Keyframe]| {
        let ball = Collider::sphere([0.1, -0.21, 0.0], 0.2).friction(0.5);
        let ball = keys.iter().fold(ball, |ball, key| ball.keyframe(key.clone()));
        let mut keys = keys.to_vec();
        keys.insert(0, Keyframe::default());
        Scene::new("lifted")
            .time(DT, 1e-3)
            .body(sheet(50.0).pin_moving(Select::nodes([0, 6]), keys))
            .collider(ball)
    };
    let mut keyed = build(&scene(&[lifted(DT, 0.5), lifted(2.0 * DT, 1.0)]));
    let mut of_user = build(&scene(&[]));
    let ball = of_user.collider("collider0").unwrap();
    let pin = of_user.pin(of_user.body("sheet").unwrap(), 0).unwrap();
    for share in [0.5, 1.0] {
        of_user.move_collider(ball, pose(0.1)).unwrap();
        // The last word counts.
        of_user.move_collider(ball, pose(share)).unwrap();
        of_user.move_pin(pin, pose(share)).unwrap();
        run(&mut keyed, 1);
        run(&mut of_user, 1);
        assert!(farthest(&positions(&keyed), &positions(&of_user)) < 1e-12);
    }
    run(&mut keyed, 5);
    run(&mut of_user, 5);
    assert!(farthest(&positions(&keyed), &positions(&of_user)) < 1e-12);
    let moved = of_user.collider_pose(ball, 1.0).unwrap();
    near("shift", moved.translation.y, 0.03, 1e-15);
    near("turn", moved.matrix3.z_axis.x, 4.0_f64.to_radians().sin(), 1e-12);
}

#[test]
fn a_collider_that_changes_its_shape_tells_where_its_nodes_are() {
    let flat = taffeta::topology::shapes::surface(&Mesh::grid(2, 2, [1.0, 1.0])).unwrap().nodes;
    let raised = flat.iter().map(|&[x, y, z]| [x, y + 0.3, z]).collect();
    // From a pose to the other in three frames; a bar keeps its shape.
    let posed = Collider::mesh(Mesh::grid(2, 2, [1.0, 1.0])).offset(0.01).posed(3.0 * DT, vec![flat, raised]);
    let bar = Collider::capsule([0.0, -9.0, 0.0], [1.0, -9.0, 0.0], 0.1);
    let at = Place { position: [0.0, -2.0, 0.0], ..Place::default() };
    let scene = Scene::new("posed").time(DT, DT).body(sheet(50.0)).collider(posed.placed(at)).collider(bar);
    let mut simulation = build(&scene);
    let [posed, bar] = [0, 1].map(|index| simulation.colliders()[index].handle);
    let height =
        |simulation: &Simulation, share| simulation.collider_nodes(posed, share).unwrap().unwrap()[3][1];
    near("at the start", height(&simulation, 1.0), -2.0, 1e-15);
    for (frame, share, expected) in [(1, 0.5, -1.95), (2, 1.0, -1.8), (3, 0.0, -1.8), (4, 1.0, -1.7)] {
        run(&mut simulation, 1);
        assert_eq!(simulation.frame(), frame);
        near("height", height(&simulation, share), expected, 1e-12);
    }
    assert_eq!(simulation.collider_nodes(bar, 1.0), Ok(None));
}

#[test]
fn what_cannot_be_moved_is_refused_by_name() {
    let keyed =
        Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).keyframe(Keyframe::translate(9.0, [0.0, 1.0, 0.0]));
    let mut simulation =
        build(&Scene::new("refused").body(sheet(50.0).pin(Select::nodes([0]))).collider(keyed));
    let said = |error: InputError| error.to_string();
    let plane = simulation.collider("collider0").unwrap();
    let still = simulation.move_collider(plane, Pose::default()).unwrap_err();
    assert_eq!(said(still), "collider `collider0` follows keyframes; one that does not could be moved");
    let none = said(simulation.collider("ball").unwrap_err());
    assert_eq!(none, "there is no collider `ball`; there are: collider0");
    let sheet = simulation.body("sheet").unwrap();
    let pin = simulation.pin(sheet, 0).unwrap();
    assert!(said(simulation.move_pin(pin, Pose::default()).unwrap_err()).contains("keyframe at t = 0"));
    assert!(said(simulation.pin(sheet, 1).unwrap_err()).contains("has 1 pins and none with index 1"));
    let nowhere = Pose { translate: [f64::NAN, 0.0, 0.0], ..Pose::default() };
    assert!(said(simulation.move_collider(plane, nowhere).unwrap_err()).contains("finite"));
}

#[test]
fn a_handle_is_of_its_own_simulation_alone() {
    let scene = || {
        let ball = Collider::sphere([0.0, -1.0, 0.0], 0.2);
        let keys = vec![Keyframe::default()];
        Scene::new("handles").body(sheet(50.0).pin_moving(Select::nodes([0]), keys)).collider(ball)
    };
    let (mut one, other) = (build(&scene()), build(&scene()));
    let (body, ball) = (other.body("sheet").unwrap(), other.collider("collider0").unwrap());
    let pin = other.pin(body, 0).unwrap();
    assert_ne!(one.body("sheet").unwrap(), body);
    let before = one.state_hash();
    let foreign = Err(InputError::ForeignHandle);
    assert_eq!(one.pin_vertex(body, 0, [0.0; 3]), foreign);
    assert_eq!(one.unpin_vertex(body, 0), foreign);
    assert_eq!(one.apply_force(body, 0, [0.0; 3]), foreign);
    assert_eq!(one.move_collider(ball, Pose::default()), foreign);
    assert_eq!(one.move_pin(pin, Pose::default()), foreign);
    assert_eq!(one.normals::<[f32; 3]>(body).err(), Some(InputError::ForeignHandle));
    assert_eq!(one.surface(body).err(), Some(InputError::ForeignHandle));
    assert_eq!(one.collider_pose(ball, 1.0).err(), Some(InputError::ForeignHandle));
    assert_eq!(one.collider_nodes(ball, 1.0).err(), Some(InputError::ForeignHandle));
    assert_eq!(one.pin(body, 0), Err(InputError::ForeignHandle));
    assert_eq!(one.state_hash(), before);
}

#[test]
fn gravity_may_change_while_things_fall() {
    let mut simulation = build(&Scene::new("fall").time(DT, DT).body(sheet(0.0)));
    run(&mut simulation, 10);
    let world = World { gravity: [0.0, 9.81, 0.0], ..World::default() };
    simulation.set_world(&world).unwrap();
    run(&mut simulation, 10);
    near("momentum", simulation.report().momentum[1], 0.0, 1e-12);
    // Symplectic Euler: Σ h v over ten steps down and ten up.
    near("fall", positions(&simulation)[0][1], -9.81 * DT * DT * 100.0, 1e-12);
    let air = World { air: Some(Air::default()), ..world };
    assert!(simulation.set_world(&air).unwrap_err().to_string().contains("without air"));
    let wrong = World { drag: -1.0, ..World::default() };
    assert!(simulation.set_world(&wrong).unwrap_err().to_string().contains("world.drag"));
}

#[test]
fn a_scene_goes_on_with_other_springs_and_another_body() {
    let pinned = |k| sheet(k).pin(Select::nodes([0, 6]));
    let other = Body::cloth("other", Mesh::grid(3, 3, [0.1, 0.1])).with_mass(Mass::Node(0.01));
    let scene = |k| Scene::new("sheets").time(DT, 1e-3).body(pinned(k));
    let mut first = build(&scene(50.0));
    run(&mut first, 20);
    let mut more = build(&scene(50.0).body(other));
    more.adopt_state(&first);
    assert_eq!(more.frame(), 20);
    assert_eq!(positions(&more)[..42], positions(&first));
    near("momentum", more.report().momentum[1], first.report().momentum[1], 1e-15);
    run(&mut first, 5);
    run(&mut more, 5);
    assert_eq!(positions(&more)[..42], positions(&first));
    let mut stiff = build(&scene(500.0));
    stiff.adopt_state(&more);
    run(&mut stiff, 40);
    run(&mut more, 40);
    assert!(stiff.report().max_stretch < more.report().max_stretch);
}

#[test]
fn frames_that_were_launched_are_those_of_steps() {
    let build = || build_as(&Scene::new("").time(DT, 1e-3).body(sheet(50.0)), Precision::F32, 1);
    let (mut stepped, mut submitted): (Simulation, Simulation) = (build(), build());
    run(&mut stepped, 7);
    submitted.submit(3).unwrap();
    submitted.submit(4).unwrap();
    assert_eq!((submitted.frame(), submitted.report().frame), (7, 0));
    assert_eq!(submitted.poll().unwrap(), stepped.report());
    assert_eq!(submitted.state_hash(), stepped.state_hash());
}

#[test]
fn what_no_scene_could_have_is_refused_while_one_runs_and_changes_nothing() {
    let scene = Scene::new("far")
        .time(DT, 1e-3)
        .body(sheet(50.0).pin_moving(Select::nodes([0]), vec![Keyframe::default()]))
        .collider(Collider::sphere([0.0, -0.3, 0.0], 0.1));
    let mut simulation = build(&scene);
    let (cloth, ball) = (simulation.body("sheet").unwrap(), simulation.collider("collider0").unwrap());
    let pin = simulation.pin(cloth, 0).unwrap();
    let endless =
        Pose { rotate: Rotation { axis: [f64::INFINITY, 0.0, 0.0], degrees: 0.0 }, ..Pose::default() };
    let shift = |x: f64| Pose { translate: [0.0, x, 0.0], ..Pose::default() };
    let turn =
        |length: f64| Pose { rotate: Rotation { axis: [0.0, length, 0.0], degrees: 5.0 }, ..Pose::default() };
    for odd in [
        shift(1e300),
        shift(1.1e6),
        shift(f64::NAN),
        turn(0.0),
        turn(1e-200),
        turn(1e200),
        turn(f64::NAN),
        endless,
    ] {
        for refused in [simulation.move_collider(ball, odd), simulation.move_pin(pin, odd)] {
            assert!(matches!(refused, Err(InputError::Value(_))), "{odd:?}");
        }
    }
    for odd in [1e300, f64::INFINITY, f64::NAN] {
        assert!(matches!(simulation.pin_vertex(cloth, 3, [odd, 0.0, 0.0]), Err(InputError::Value(_))));
        assert!(matches!(simulation.apply_force(cloth, 3, [odd, 0.0, 0.0]), Err(InputError::Value(_))));
        simulation.disturb(if odd.is_finite() { 0.0 } else { f64::NAN }, 1);
    }
    let far = simulation.move_collider(ball, shift(1.1e6)).unwrap_err().to_string();
    assert!(far.contains("pose.translate") && far.contains("within ±1000000 m would do"), "{far}");
    simulation.move_collider(ball, Pose::default()).unwrap();
    simulation.move_collider(ball, turn(1e-6)).unwrap();
    simulation.move_collider(ball, shift(0.0)).unwrap();
    let mut untouched = build(&scene);
    run(&mut untouched, 3);
    run(&mut simulation, 3);
    assert_eq!(positions(&simulation), positions(&untouched));
}

#[test]
fn air_that_is_taken_away_acts_no_more() {
    let air = Air { velocity: [3.0, 2.0, 1.0], ..Air::default() };
    let mut scene = weightless("blown", 0.01, 2e-3);
    scene.world.air = Some(air);
    let scene = scene.body(Body::cloth("sheet", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Node(1e-3)));
    for gpu in [None, Some(gpu().into())] {
        let mut simulation = Simulation::new(&scene, &Options { gpu, ..Options::default() }).unwrap();
        let before = simulation.advance(2).unwrap().momentum;
        assert!(before[1] > 1e-6, "{before:?}");
        simulation.set_world(&World { air: None, ..scene.world.clone() }).unwrap();
        let after = simulation.advance(5).unwrap().momentum;
        assert_eq!(after, before, "on {}", simulation.device());
    }
}
