//! A frame that is stopped on its way is given up, and done again from a snapshot as if nothing had been.

use crate::common::{build_as, positions};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use taffeta::diagnostics::FrameReport;
use taffeta::scene::{
    Body, Collider, ConstraintForm, Icosphere, Keyframe, Kind, Mass, Material, Mesh, Method, Scene, Select,
    SelfCollision,
};
use taffeta::{Precision, Simulation, StepError};

/// Two sheets that fall on each other, a soft ball that falls on them, and a floor that rises.
fn pile(method: Method, step: f64) -> Scene {
    let contact = SelfCollision { thickness: 0.01, ..SelfCollision::default() };
    let sheet = |name: &str, height: f64| {
        let body = Body::cloth(name, Mesh::grid(9, 9, [0.4, 0.4])).with_mass(Mass::Area(0.3));
        Body { self_collision: Some(contact.clone()), ..body.at([0.0, height, 0.0]) }
    };
    let springs = |body: Body| body.structural(40.0, 0.02).shear(20.0, 0.01).bend(1.0, 0.0);
    let ball = Mesh::Icosphere(Icosphere { radius: 0.08, subdivisions: 1 });
    let ball =
        Body::cloth("ball", ball).with_mass(Mass::Whole(0.1)).structural(60.0, 0.05).at([0.0, 0.12, 0.02]);
    let ball = Body { kind: Kind::Soft, self_collision: Some(contact.clone()), ..ball };
    let upper = if method == Method::Ice {
        sheet("upper", 0.02).with_material(Material::preset("cotton"))
    } else {
        springs(sheet("upper", 0.02))
    };
    let mut scene = Scene::new("pile").time(1.0 / 60.0, step).method(method);
    scene.solver.ice.form = ConstraintForm::Primal;
    let lower = springs(sheet("lower", 0.0)).pin(Select::nodes([0, 8]));
    let mut floor = Collider::plane([0.0, -0.03, 0.0], [0.0, 1.0, 0.0]);
    floor.motion = vec![Keyframe::translate(0.5, [0.0, 0.02, 0.0])];
    scene.body(lower).body(upper).body(ball).collider(floor)
}

fn hanging(form: ConstraintForm) -> Scene {
    let body = Body::cloth("cloth", Mesh::grid(9, 9, [0.4, 0.4])).with_mass(Mass::Node(0.01));
    let mut scene = Scene::new("hangs").time(1.0 / 60.0, 1.0 / 120.0).method(Method::Ice);
    scene.solver.ice.form = form;
    scene.body(body.structural(500.0, 0.1).bend(5.0, 0.0).pin(Select::nodes([0])))
}

/// A frame that another thread wants to stop when it has counted so far, if not at once.
fn step_unless_counted(simulation: &mut Simulation, to: u32) -> Result<(), StepError> {
    let stop = Arc::new(AtomicBool::new(to == 0));
    let other = Arc::clone(&stop);
    let counts = std::thread::spawn(move || {
        (0..to).for_each(|_| std::hint::spin_loop());
        other.store(true, Ordering::Relaxed);
    });
    let stepped = simulation.step_unless(&stop).map(|_| ());
    counts.join().unwrap();
    stepped
}

/// Runs some frames, all of which are stopped at their start and, as it comes, at other places, and restored. Returns how often one
/// was stopped.
fn with_stops(simulation: &mut Simulation, frames: u32) -> u32 {
    let mut stops = 0;
    for frame in 1..=frames {
        let before = simulation.snapshot();
        for attempt in 0..4 {
            match step_unless_counted(simulation, attempt * (977 * frame % 10_000)) {
                Ok(()) => assert_eq!(simulation.frame(), frame),
                Err(StepError::Stopped { frame: stopped }) => {
                    assert_eq!((stopped, simulation.frame()), (frame, frame - 1));
                    assert!(matches!(simulation.step(), Err(StepError::Stopped { .. })));
                    stops += 1;
                }
                Err(error) => panic!("{error}"),
            }
            simulation.restore(&before).unwrap();
        }
        simulation.step().unwrap();
    }
    stops
}

#[track_caller]
fn stops_leave_no_trace(scene: &Scene) {
    const FRAMES: u32 = 24;
    for threads in [1, 3] {
        let mut whole = build_as(scene, Precision::F32, threads);
        whole.advance(FRAMES).unwrap();
        let mut stopped = build_as(scene, Precision::F32, threads);
        let stops = with_stops(&mut stopped, FRAMES);
        assert!(stops >= FRAMES, "{stops} stops");
        assert_eq!(stopped.state_hash(), whole.state_hash(), "{}, {threads} threads", scene.title);
        // How often it searches depends on what it knows.
        let pair_searches = whole.report().pair_searches;
        assert_eq!(&FrameReport { pair_searches, ..stopped.report().clone() }, whole.report());
    }
}

#[test]
fn stopped_frames_of_explicit_springs_in_contact_leave_no_trace() {
    stops_leave_no_trace(&pile(Method::Springs, 5e-4));
}

#[test]
fn stopped_frames_of_implicit_fabric_in_contact_leave_no_trace() {
    stops_leave_no_trace(&pile(Method::Ice, 1.0 / 120.0));
}

#[test]
fn stopped_frames_of_constraints_leave_no_trace() {
    stops_leave_no_trace(&hanging(ConstraintForm::Compliant));
}

#[test]
fn what_was_asked_for_before_a_state_is_restored_is_forgotten() {
    let scene = hanging(ConstraintForm::Primal);
    let mut simulation = build_as(&scene, Precision::F64, 1);
    let before = simulation.snapshot();
    let body = simulation.bodies()[0].handle;
    simulation.apply_force(body, 40, [5.0, 0.0, 0.0]).unwrap();
    simulation.pin_vertex(body, 80, [0.3, 0.1, 0.0]).unwrap();
    simulation.submit(2).unwrap();
    simulation.apply_force(body, 40, [5.0, 0.0, 0.0]).unwrap();
    simulation.restore(&before).unwrap();
    assert_eq!(simulation.frame(), 0);
    simulation.step().unwrap();
    let mut fresh = build_as(&scene, Precision::F64, 1);
    fresh.step().unwrap();
    assert_eq!(positions(&simulation), positions(&fresh));
}
