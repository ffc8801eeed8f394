//! Bodies at rest fall asleep: they stand still, cost nothing, and wake when something comes near.

use crate::common::{gpu, norm, positions, sub};
use taffeta::diagnostics::FrameReport;
use taffeta::scene::{
    Air, Body, Collider, ConstraintForm, Gust, Icosphere, Keyframe, Mass, Material, Mesh, Method, Scene,
    Seam, SeamSide, Select, Sleep, Volume, VolumeForm, World,
};
use taffeta::{OnDivergence, Options, Pose, Precision, Simulation, StepError};

const SLEEP: Sleep = Sleep { speed: 2e-3, after: 0.1 };

/// A scene whose motion is damped within a tenth of a second.
fn calm(title: &str) -> Scene {
    let mut scene = Scene::new(title).time(0.01, 1e-3);
    scene.world.drag = 0.02;
    scene.sleep = Some(SLEEP);
    scene
}

fn sheet(name: &str, at: [f64; 3]) -> Body {
    let body = Body::cloth(name, Mesh::grid(6, 7, [0.3, 0.25]));
    body.with_mass(Mass::Node(1e-3)).structural(20.0, 1e-3).shear(10.0, 1e-3).at(at)
}

/// A sheet that hangs from one of its rows.
fn curtain(name: &str, at: [f64; 3]) -> Body {
    sheet(name, at).pin(Select::rows(0, 0))
}

/// A pin that swings for ever.
fn swinging() -> Vec<Keyframe> {
    (0..400)
        .map(|step| Keyframe::translate(0.1 * f64::from(step), [0.0, 0.0, 0.05 * f64::from(step % 2)]))
        .collect()
}

fn build(scene: &Scene, options: Options) -> Simulation {
    Simulation::new(scene, &options).unwrap()
}

fn in_f64(scene: &Scene) -> Simulation {
    build(scene, Options { precision: Precision::F64, threads: Some(1), ..Options::default() })
}

fn is_asleep(simulation: &Simulation, body: &str) -> bool {
    simulation.is_asleep(simulation.body(body).unwrap()).unwrap()
}

/// Runs until a body sleeps; at most ten seconds.
fn run_until_asleep(simulation: &mut Simulation, body: &str) {
    while !is_asleep(simulation, body) {
        assert!(simulation.step().unwrap().time < 10.0, "`{body}` does not fall asleep");
    }
}

/// Nothing in it depends on how many threads and what device has looked for contacts.
fn comparable(report: &FrameReport) -> FrameReport {
    FrameReport { pair_searches: 0, ..report.clone() }
}

#[test]
fn a_body_that_sleeps_stands_still_until_something_acts_on_it_and_no_step_is_taken() {
    let mut simulation = in_f64(&calm("a curtain").body(curtain("curtain", [0.0; 3])));
    run_until_asleep(&mut simulation, "curtain");
    assert_eq!((simulation.report().asleep, simulation.report().kinetic), (1, 0.0));
    simulation.advance(2).unwrap();
    let (hash, before) = (simulation.state_hash(), simulation.report().clone());
    let report = simulation.advance(5).unwrap();
    let time = f64::from(before.frame + 5) * 0.01;
    assert_eq!(*report, FrameReport { frame: before.frame + 5, time, substeps: 0, ..before.clone() });
    // The pin still bears the weight of six rows in seven, and its own.
    let force = report.reactions[0].force.unwrap();
    assert!((force[1] - 42.0 * 1e-3 * 9.81).abs() < 1e-3, "{force:?}");
    assert_eq!(simulation.state_hash(), hash);
    let curtain = simulation.body("curtain").unwrap();
    simulation.apply_force(curtain, 41, [0.0, 0.0, 0.1]).unwrap();
    assert_eq!(simulation.step().unwrap().substeps, 10);
    assert!(!simulation.is_asleep(curtain).unwrap());
    assert_ne!(simulation.state_hash(), hash);
}

#[test]
fn sleep_changes_nothing_before_a_body_sleeps_and_never_a_scene_that_does_not_rest() {
    let scene = calm("a curtain").body(curtain("curtain", [0.0; 3]));
    let mut awake = in_f64(&Scene { sleep: None, ..scene.clone() });
    let mut simulation = in_f64(&scene);
    for frame in 0.. {
        awake.step().unwrap();
        simulation.step().unwrap();
        if simulation.report().asleep == 1 {
            assert!(frame > 10);
            break;
        }
        assert_eq!(simulation.state_hash(), awake.state_hash(), "frame {frame}");
    }
    // Gusts, and what a program moves or pushes every frame, do not rest.
    let mut gusty = scene.clone();
    gusty.world.air = Some(Air { gust: Some(Gust { speed: 1e-3, ..Gust::default() }), ..Air::default() });
    let mut gusty = in_f64(&gusty);
    assert_eq!(gusty.advance(400).unwrap().asleep, 0);
    let mut pushed = in_f64(&scene);
    for _ in 0..400 {
        let curtain = pushed.body("curtain").unwrap();
        pushed.apply_force(curtain, 41, [0.0, 0.0, 1e-9]).unwrap();
        assert_eq!(pushed.step().unwrap().asleep, 0);
    }
}

#[test]
fn a_body_wakes_for_pins_that_move_and_for_a_world_that_changes() {
    let moves = vec![Keyframe::translate(3.0, [0.0; 3]), Keyframe::translate(3.5, [0.0, 0.1, 0.0])];
    let mut still = curtain("still", [2.0, 0.0, 0.0]);
    still.pins[0].motion = vec![Keyframe::translate(0.0, [0.0; 3])];
    let scene =
        calm("curtains").body(sheet("moves", [0.0; 3]).pin_moving(Select::rows(0, 0), moves)).body(still);
    let mut simulation = in_f64(&scene);
    simulation.advance(300).unwrap();
    assert_eq!(simulation.report().asleep, 2);
    simulation.step().unwrap();
    assert!(!is_asleep(&simulation, "moves") && is_asleep(&simulation, "still"));
    let still = simulation.body("still").unwrap();
    let pin = simulation.pin(still, 0).unwrap();
    simulation.move_pin(pin, Pose { translate: [0.0, 0.01, 0.0], ..Pose::default() }).unwrap();
    assert_eq!(simulation.step().unwrap().asleep, 0);
    run_until_asleep(&mut simulation, "still");
    // A vertex that a program pins stays pinned when the body wakes, and is free again when it lets go.
    let vertex = simulation.positions_of(still, 41);
    simulation.pin_vertex(still, 41, sub(vertex, [0.0, 0.0, 0.05])).unwrap();
    simulation.advance(100).unwrap();
    run_until_asleep(&mut simulation, "still");
    assert!((simulation.positions_of(still, 41)[2] - vertex[2] + 0.05).abs() < 1e-12);
    simulation.unpin_vertex(still, 41).unwrap();
    run_until_asleep(&mut simulation, "moves");
    run_until_asleep(&mut simulation, "still");
    assert!(
        norm(sub(simulation.positions_of(still, 41), vertex)) < 2e-3,
        "{:?}",
        simulation.positions_of(still, 41)
    );
    let world = World { wind_force: [0.0, 0.0, 1e-3], ..scene.world.clone() };
    simulation.set_world(&scene.world).unwrap();
    assert_eq!(simulation.step().unwrap().asleep, 2, "it has not changed");
    simulation.set_world(&world).unwrap();
    assert_eq!(simulation.step().unwrap().asleep, 0);
}

trait Positions {
    fn positions_of(&self, body: taffeta::BodyHandle, vertex: usize) -> [f64; 3];
}

impl Positions for Simulation {
    fn positions_of(&self, body: taffeta::BodyHandle, vertex: usize) -> [f64; 3] {
        let index = self.bodies().iter().position(|info| info.handle == body).unwrap();
        let first: usize = self.bodies()[..index].iter().map(|info| info.vertices).sum();
        positions(self)[first + vertex]
    }
}

#[test]
fn a_collider_that_moves_wakes_what_it_comes_near_to_and_nothing_else() {
    let cube = Mesh::Cube(taffeta::scene::Cube { size: 0.2, divisions: 1 });
    let shapes = [Collider::sphere([0.0; 3], 0.1), Collider::mesh(cube)];
    for shape in shapes {
        let mut scene = calm("rooms").body(curtain("near", [0.0; 3])).body(curtain("far", [3.0, 0.0, 0.0]));
        scene = scene.collider(
            shape
                .named("ball")
                .placed(taffeta::scene::Place { position: [0.0, -0.3, 2.0], ..Default::default() }),
        );
        let mut simulation = in_f64(&scene);
        simulation.advance(300).unwrap();
        assert_eq!(simulation.report().asleep, 2);
        let ball = simulation.collider("ball").unwrap();
        // It comes along the third axis, 5 cm a frame, and goes through in the end.
        let mut woke = None;
        for step in 1..80 {
            let z = -0.05 * f64::from(step);
            simulation.move_collider(ball, Pose { translate: [0.0, 0.0, z], ..Pose::default() }).unwrap();
            let before = positions(&simulation);
            simulation.step().unwrap();
            assert!(is_asleep(&simulation, "far"));
            if !is_asleep(&simulation, "near") {
                let distance =
                    before[..42].iter().map(|x| norm(sub(*x, [0.0, -0.3, 2.05 + z]))).fold(1e9, f64::min);
                woke.get_or_insert(distance);
            }
        }
        let distance = woke.expect("it came by");
        assert!(distance > 0.14 && distance < 0.3, "it was {distance} m from the middle before the frame");
        // So does one that goes past in a single frame, and is far from it before and after.
        simulation.move_collider(ball, Pose { translate: [0.35, 0.0, -2.8], ..Pose::default() }).unwrap();
        simulation.step().unwrap();
        run_until_asleep(&mut simulation, "near");
        simulation.move_collider(ball, Pose { translate: [0.35, 0.0, -1.2], ..Pose::default() }).unwrap();
        simulation.step().unwrap();
        assert!(!is_asleep(&simulation, "near") && is_asleep(&simulation, "far"));
    }
}

#[test]
fn a_body_that_falls_on_a_sleeping_one_wakes_it_before_they_touch() {
    let floor = Collider::plane([0.0, -0.01, 0.0], [0.0, 1.0, 0.0]).friction(0.5);
    let mut scene = calm("a fall").collider(floor).body(sheet("lies", [0.0; 3]).collide(0.01));
    scene = scene
        .body(sheet("falls", [0.02, 1.5, 0.03]).collide(0.01))
        .body(sheet("aside", [2.0, 0.0, 0.0]).collide(0.01));
    scene.world.drag = 2e-3;
    let mut simulation = in_f64(&scene);
    // It takes about 0.7 s to fall.
    simulation.advance(40).unwrap();
    assert!(
        is_asleep(&simulation, "lies") && is_asleep(&simulation, "aside") && !is_asleep(&simulation, "falls")
    );
    let gap =
        |simulation: &Simulation| positions(simulation)[42..84].iter().map(|x| x[1]).fold(1e9, f64::min);
    let (mut before, mut woke) = (gap(&simulation), None);
    while simulation.report().pairs == 0 {
        if !is_asleep(&simulation, "lies") {
            woke.get_or_insert(before);
        }
        before = gap(&simulation);
        assert!(simulation.step().unwrap().time < 1.5);
    }
    let woke = woke.expect("it woke before it was touched");
    assert!(woke > 0.015 && woke < 0.4, "{woke} m");
    // It bounces. In the end both sleep, one on the other.
    while !(is_asleep(&simulation, "lies") && is_asleep(&simulation, "falls")) {
        assert!(simulation.step().unwrap().time < 20.0);
        assert!(is_asleep(&simulation, "aside"));
    }
    let highest = positions(&simulation)[42..84].iter().map(|x| x[1]).fold(0.0, f64::max);
    assert!(highest > 0.005 && highest < 0.2, "{highest} m");
    assert_eq!(simulation.intersections().pairs, 0);
}

#[test]
fn what_is_sewn_together_sleeps_together() {
    let side = |body: &str| SeamSide { body: body.into(), select: Some(Select::nodes([41])) };
    let mut scene = calm("sewn").body(curtain("curtain", [0.0; 3])).body(sheet("rag", [0.3, 0.0, 0.0]));
    scene = scene
        .seam(Seam::new(side("curtain"), side("rag")).closing(0.0, 0.5, 0.0))
        .body(curtain("alone", [2.0, 0.0, 0.0]));
    let mut simulation = in_f64(&scene);
    loop {
        let report = simulation.step().unwrap();
        assert!(report.time < 20.0);
        let asleep = ["curtain", "rag"].map(|body| is_asleep(&simulation, body));
        assert_eq!(asleep[0], asleep[1]);
        if asleep[0] {
            break;
        }
    }
    let rag = simulation.body("rag").unwrap();
    simulation.wake(rag).unwrap();
    simulation.step().unwrap();
    assert!(!is_asleep(&simulation, "curtain") && is_asleep(&simulation, "alone"));
}

/// Bodies of all kinds that come to rest, beside one that swings.
fn all_kinds(method: Method, form: ConstraintForm, fabric: bool) -> Scene {
    let mut scene = calm("all kinds").method(method);
    scene.sleep = Some(Sleep { speed: 0.02, ..SLEEP });
    scene.solver.ice.form = form;
    scene.world.air = Some(Air { velocity: [0.3, 0.0, 0.2], ..Air::default() });
    let volume = Volume { form: VolumeForm::Projected, ..Volume::default() };
    let ball = Body::soft("ball", Mesh::Icosphere(Icosphere { radius: 0.1, subdivisions: 1 }));
    let ball = Body { volume: Some(volume), ..ball.with_mass(Mass::Node(1e-3)).structural(20.0, 0.01) };
    scene = scene
        .body(curtain("swings", [0.0; 3]).hinge(1e-5, 0.0))
        .body(curtain("hinged", [1.0, 0.0, 0.0]).hinge(1e-5, 1e-7));
    scene.bodies[0].pins[0].motion = swinging();
    scene = scene.body(ball.at([2.0, 0.1, 0.0])).body(curtain("last", [3.0, 0.0, 0.0]));
    if fabric {
        let cloth =
            Body::cloth("fabric", Mesh::grid(6, 7, [0.3, 0.25])).at([4.0, 0.0, 0.0]).pin(Select::rows(0, 0));
        scene = scene.body(Body { material: Some(Material::preset("cotton")), ..cloth });
    }
    scene.collider(Collider::plane([0.0, -0.5, 0.0], [0.0, 1.0, 0.0]).friction(0.8))
}

/// A simulation that takes up its own state again before each frame never leaves anything out.
fn step_restored(simulation: &mut Simulation) {
    let now = simulation.snapshot();
    simulation.restore(&now).unwrap();
    simulation.step().unwrap();
}

#[test]
fn what_is_left_out_of_bodies_that_sleep_changes_no_bit_of_anything() {
    let solvers = [
        (Method::Springs, ConstraintForm::Compliant, false),
        (Method::Ice, ConstraintForm::Primal, true),
        (Method::Ice, ConstraintForm::Compliant, false),
        (Method::Acad, ConstraintForm::Compliant, false),
    ];
    for (method, form, fabric) in solvers {
        // Fabric is light, and sinks through the air for long.
        let (pushed, frames) = if fabric { (580, 600) } else { (380, 400) };
        let scene = all_kinds(method, form, fabric);
        let options = |threads| Options { threads: Some(threads), ..Options::default() };
        let [mut one, mut three] = [1, 3].map(|threads| build(&scene, options(threads)));
        let mut restored = build(&scene, options(1));
        let mut most = 0;
        for frame in 1..=frames {
            if frame == pushed {
                for simulation in [&mut one, &mut three, &mut restored] {
                    let hinged = simulation.body("hinged").unwrap();
                    simulation.apply_force(hinged, 41, [0.0, 0.0, 0.05]).unwrap();
                }
            }
            one.step().unwrap();
            three.step().unwrap();
            // The force to come is not part of a snapshot.
            if frame == pushed {
                restored.step().map(drop).unwrap()
            } else {
                step_restored(&mut restored)
            }
            most = most.max(one.report().asleep);
            for (other, what) in [(&three, "three threads"), (&restored, "nothing left out")] {
                assert_eq!(
                    one.state_hash(),
                    other.state_hash(),
                    "{method:?} {form:?}, frame {frame}, {what}"
                );
                assert_eq!(
                    comparable(one.report()),
                    comparable(other.report()),
                    "{method:?}, frame {frame}, {what}"
                );
            }
        }
        let bodies = scene.bodies.len() as u32;
        // Constraints that come and go keep one awake for longer.
        assert!(most + 2 >= bodies, "{method:?} {form:?}: {most} of {bodies} fall asleep");
    }
}

#[test]
fn a_gpu_decides_the_same_and_has_the_same_bits() {
    let scene = all_kinds(Method::Springs, ConstraintForm::Compliant, false);
    let mut cpu = build(&scene, Options { threads: Some(1), ..Options::default() });
    let mut device = build(&scene, Options { gpu: Some(gpu().into()), ..Options::default() });
    for frames in [150, 1, 1, 100, 1, 100] {
        cpu.advance(frames).unwrap();
        device.advance(frames).unwrap();
        assert_eq!(cpu.report().asleep, device.report().asleep);
        assert_eq!(cpu.state_hash(), device.state_hash(), "frame {}", cpu.frame());
    }
    assert_eq!(cpu.report().asleep, 3);
    // Nothing is run where all sleep.
    let mut scene = scene;
    scene.bodies.remove(0);
    let mut device = build(&scene, Options { gpu: Some(gpu().into()), ..Options::default() });
    device.advance(400).unwrap();
    let hash = device.state_hash();
    assert_eq!((device.report().asleep, device.advance(3).unwrap().substeps), (3, 0));
    assert_eq!(device.state_hash(), hash);
}

#[test]
fn a_snapshot_of_sleepers_goes_on_bit_by_bit_and_one_that_cannot_be_is_refused() {
    let scene = calm("a curtain").body(curtain("curtain", [0.0; 3])).body(curtain("far", [3.0, 0.0, 0.0]));
    let mut simulation = in_f64(&scene);
    let mut others: Vec<Simulation> = Vec::new();
    // From shortly before they fall asleep until no frame is run any more.
    run_until_asleep(&mut simulation, "curtain");
    let asleep_at = simulation.frame();
    let mut simulation = in_f64(&scene);
    simulation.advance(asleep_at - 3).unwrap();
    for _ in 0..8 {
        let snapshot = simulation.snapshot();
        let mut other = in_f64(&scene);
        other.restore(&snapshot).unwrap();
        others.push(other);
        simulation.step().unwrap();
        for other in &mut others {
            assert_eq!(other.step().unwrap(), simulation.report());
            assert_eq!(other.state_hash(), simulation.state_hash());
        }
    }
    let snapshot = simulation.snapshot();
    assert_eq!((simulation.report().substeps, snapshot.changes.asleep.len()), (0, 2));
    let broken = |change: &dyn Fn(&mut taffeta::Snapshot)| {
        let mut broken = snapshot.clone();
        change(&mut broken);
        in_f64(&scene).restore(&broken).unwrap_err().to_string()
    };
    assert!(broken(&|one| one.changes.asleep = vec![2]).contains("body 2 is asleep"));
    assert!(broken(&|one| one.changes.rest.truncate(1)).contains("of 1 bodies"));
    assert!(broken(&|one| one.held.retain(|&node| node != 20)).contains("node 20"));
    assert!(broken(&|one| one.changes.asleep = vec![0]).contains("is held in it"));
}

#[test]
fn bodies_sleep_on_when_another_one_is_frozen_and_a_sleeper_can_be_frozen() {
    let scene = calm("three")
        .body(curtain("a", [0.0; 3]))
        .body(curtain("b", [2.0, 0.0, 0.0]))
        .body(curtain("c", [4.0, 0.0, 0.0]));
    let options = Options { on_divergence: OnDivergence::Freeze, threads: Some(1), ..Options::default() };
    let mut simulation = build(&scene, options.clone());
    run_until_asleep(&mut simulation, "a");
    simulation.advance(2).unwrap();
    let hash = simulation.state_hash();
    let b = simulation.body("b").unwrap();
    simulation.apply_force(b, 41, [1e15, 0.0, 0.0]).unwrap();
    simulation.advance(3).unwrap();
    assert_eq!(simulation.frozen().iter().map(|one| one.why.body.as_str()).collect::<Vec<_>>(), ["b"]);
    assert!(is_asleep(&simulation, "a") && is_asleep(&simulation, "c"));
    assert_eq!(simulation.state_hash(), hash, "all of them stand still where they were");
    let snapshot = simulation.snapshot();
    let a = simulation.body("a").unwrap();
    let push = |simulation: &mut Simulation| {
        simulation.apply_force(a, 41, [0.0, 0.0, 0.1]).unwrap();
        simulation.advance(20).unwrap();
        simulation.state_hash()
    };
    let pushed = push(&mut simulation);
    assert_ne!(pushed, hash);
    simulation.restore(&snapshot).unwrap();
    assert_eq!(push(&mut simulation), pushed);
    // A frozen body does not wake.
    let stopped: Result<(), StepError> = simulation.advance(400).map(drop);
    assert!(stopped.is_ok() && simulation.frozen().len() == 1);
}

#[test]
fn what_a_program_does_while_frames_run_lasts_when_another_body_is_frozen() {
    let scene = calm("two").body(curtain("a", [0.0; 3])).body(curtain("b", [2.0, 0.0, 0.0]));
    let options = Options { on_divergence: OnDivergence::Freeze, threads: Some(1), ..Options::default() };
    let mut simulation = build(&scene, options);
    run_until_asleep(&mut simulation, "a");
    run_until_asleep(&mut simulation, "b");
    let asleep = simulation.snapshot();
    let [a, b] = ["a", "b"].map(|body| simulation.body(body).unwrap());
    let place = simulation.positions_of(a, 41);
    // Frame by frame, and while the frame that fails is under way.
    for frames in [0, 1] {
        simulation.restore(&asleep).unwrap();
        simulation.apply_force(b, 41, [1e15, 0.0, 0.0]).unwrap();
        simulation.submit(1).unwrap();
        simulation.pin_vertex(a, 41, place).unwrap();
        simulation.submit(frames).unwrap();
        simulation.poll().unwrap();
        assert_eq!(simulation.frozen().len(), 1);
        simulation.advance(30).unwrap();
        assert!(norm(sub(simulation.positions_of(a, 41), place)) < 1e-6, "it stays pinned");
        let snapshot = simulation.snapshot();
        simulation.restore(&snapshot).unwrap();
        // A wind that is there from then on moves what slept.
        simulation.restore(&asleep).unwrap();
        simulation.apply_force(b, 41, [1e15, 0.0, 0.0]).unwrap();
        simulation.submit(1).unwrap();
        let wind = World { wind_force: [0.0, 0.0, 3e-3], ..scene.world.clone() };
        simulation.set_world(&wind).unwrap();
        simulation.submit(frames).unwrap();
        simulation.poll().unwrap();
        simulation.advance(50).unwrap();
        assert!(simulation.positions_of(a, 41)[2] > place[2] + 0.01);
        simulation.restore(&asleep).unwrap();
    }
}

#[test]
fn frames_that_were_not_run_are_reported_so_whatever_is_changed_before_they_are_polled() {
    let scene = calm("a curtain").body(curtain("curtain", [0.0; 3]));
    let mut simulation = in_f64(&scene);
    run_until_asleep(&mut simulation, "curtain");
    simulation.advance(3).unwrap();
    simulation.submit(3).unwrap();
    simulation.set_world(&World { wind_force: [0.0, 0.0, 1e-3], ..scene.world }).unwrap();
    let report = simulation.poll().unwrap();
    assert_eq!((report.substeps, report.asleep), (0, 1));
    let report = simulation.step().unwrap();
    assert_eq!((report.substeps, report.asleep), (10, 0));
}

#[test]
fn a_body_has_time_to_set_out_however_soon_it_may_sleep() {
    let mut scene = calm("falls").body(sheet("sheet", [0.0; 3])).body(curtain("curtain", [2.0, 0.0, 0.0]));
    scene.sleep = Some(Sleep { speed: 0.02, after: 0.0 });
    let mut simulation = in_f64(&scene);
    assert_eq!(simulation.advance(20).unwrap().asleep, 0);
    run_until_asleep(&mut simulation, "curtain");
    let world = World { wind_force: [0.0, 0.0, 5e-3], ..scene.world.clone() };
    simulation.set_world(&world).unwrap();
    simulation.advance(5).unwrap();
    assert!(!is_asleep(&simulation, "curtain"));
}

#[test]
fn colliders_that_move_together_wake_nothing_that_is_far() {
    let mut scene = calm("a figure").body(curtain("far", [30.0, 0.0, 0.0]));
    for (name, x) in [("left", 0.0), ("right", 0.5)] {
        let arm = Collider::sphere([x, 0.0, 0.0], 0.1).named(name);
        // Both have keyframes inside of frames.
        scene = scene.collider((0..40).fold(arm, |arm, key| {
            arm.keyframe(Keyframe::translate(0.1234 * f64::from(key), [0.0, 0.1 * f64::from(key % 2), 0.0]))
        }));
    }
    let mut simulation = in_f64(&scene);
    run_until_asleep(&mut simulation, "far");
    while simulation.step().unwrap().time < 4.5 {
        assert!(is_asleep(&simulation, "far"));
    }
}

#[test]
fn a_contact_with_a_sleeper_that_was_not_seen_coming_is_the_same_with_all_left_in() {
    // A force by the program throws a sheet against a curtain within a frame.
    let mut scene = calm("thrown").method(Method::Ice).time(0.02, 0.005);
    scene.solver.ice.form = ConstraintForm::Primal;
    let collide = |body: Body| body.collide(0.01);
    scene =
        scene.body(collide(curtain("sleeps", [0.0; 3]))).body(collide(curtain("thrown", [0.0, 0.0, 0.4])));
    let options = Options { threads: Some(1), ..Options::default() };
    let [mut one, mut restored] = [(); 2].map(|()| build(&scene, options.clone()));
    let mut touched = false;
    for frame in 1..200 {
        if frame > 120 && frame % 20 == 0 {
            for simulation in [&mut one, &mut restored] {
                let thrown = simulation.body("thrown").unwrap();
                for vertex in 35..42 {
                    simulation.apply_force(thrown, vertex, [0.0, 0.0, -2.0]).unwrap();
                }
            }
            one.step().unwrap();
            restored.step().unwrap();
        } else {
            one.step().unwrap();
            step_restored(&mut restored);
        }
        touched |= one.report().pairs > 0 && is_asleep(&one, "sleeps");
        assert_eq!(one.state_hash(), restored.state_hash(), "frame {frame}");
    }
    assert!(touched, "it was touched in its sleep");
}
