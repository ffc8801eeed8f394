//! Falls and presses: how much volume each form loses.

use super::{ball, error, ring};
use crate::common::{build_as, positions, run};
use taffeta::scene::{Body, Collider, Keyframe, Scene, Spring, VolumeForm};
use taffeta::{Precision, StepError};

const FLOOR: f64 = 0.0;

fn floor() -> Collider {
    Collider::plane([0.0, FLOOR, 0.0], [0.0, 1.0, 0.0]).offset(0.0)
}

/// From 1 m onto a floor.
fn fall(body: Body) -> Scene {
    Scene::new("fall").time(0.01, 0.0005).body(body.at([0.0, 1.5, 0.0])).collider(floor())
}

/// Between a floor and a plate that comes down to `gap` [m] in half a second.
fn press(body: Body, height: f64, gap: f64, h: f64) -> Scene {
    let plate = Collider::plane([0.0, height + 0.02, 0.0], [0.0, -1.0, 0.0]).offset(0.0);
    let plate = plate.keyframe(Keyframe::translate(0.5, [0.0, gap - height - 0.02, 0.0]));
    let body = body.at([0.0, 0.5 * height + 0.01, 0.0]);
    Scene::new("press").time(0.01, h).body(body).collider(floor()).collider(plate)
}

fn soft(mut body: Body, k: f64) -> Body {
    body.springs.structural = Some(Spring { k, d: 0.2 });
    body
}

/// Largest relative error over 0.7 seconds, and the lowest node [m].
fn worst(scene: &Scene, precision: Precision) -> (f64, f64) {
    let mut simulation = build_as(scene, precision, 1);
    let rest = simulation.report().volumes[0].unwrap();
    let (mut worst, mut lowest, mut touched) = (0.0_f64, f64::INFINITY, 0);
    for _ in 0..70 {
        run(&mut simulation, 1);
        let volume = simulation.report().volumes[0].unwrap();
        worst = worst.max((volume / rest - 1.0).abs());
        lowest = positions(&simulation).iter().map(|x| x[1]).fold(lowest, f64::min);
        touched += simulation.report().contacts;
    }
    assert!(touched > 100, "it touches something: {touched}");
    (worst, lowest)
}

fn scenes(form: VolumeForm) -> [Scene; 4] {
    [
        fall(soft(ball(3, form), 1000.0)),
        fall(soft(ring(form), 1000.0)),
        press(soft(ball(3, form), 1000.0), 1.0, 0.5, 0.0005),
        press(soft(ring(form), 1000.0), 0.4, 0.25, 0.00025),
    ]
}

#[test]
fn corrected_forces_keep_the_volume_within_a_thousandth() {
    for precision in [Precision::F64, Precision::F32] {
        for scene in &scenes(VolumeForm::Corrected) {
            let (error, lowest) = worst(scene, precision);
            assert!(error < 1e-3, "{}, {precision}: {error:e}", scene.title);
            assert!(lowest >= FLOOR, "{}, {precision}: {lowest:e} m", scene.title);
        }
    }
}

#[test]
fn projection_keeps_the_volume_to_rounding() {
    for (precision, most) in [(Precision::F64, 1e-9), (Precision::F32, 1e-5)] {
        for scene in &scenes(VolumeForm::Projected) {
            let (error, lowest) = worst(scene, precision);
            assert!(error < most, "{}, {precision}: {error:e}", scene.title);
            assert!(lowest >= FLOOR, "{}, {precision}: {lowest:e} m", scene.title);
        }
    }
}

#[test]
fn what_corrected_forces_lose_in_a_press_is_of_second_order_in_the_step() {
    // Nodes that a plate holds back are counted among those that can give way.
    let error =
        |h: f64| worst(&press(soft(ring(VolumeForm::Corrected), 1000.0), 0.4, 0.25, h), Precision::F64).0;
    let [coarse, fine] = [error(0.001), error(0.0005)];
    assert!((3.0..5.0).contains(&(coarse / fine)) && coarse < 0.02, "{coarse:e} {fine:e}");
}

#[test]
fn a_plate_is_not_passed_by_nodes_that_are_moved_to_restore_a_volume() {
    let mut simulation = build_as(&scenes(VolumeForm::Projected)[2], Precision::F64, 1);
    for frame in 1..=100 {
        run(&mut simulation, 1);
        let plate = 1.02 - 0.52 * (f64::from(frame) / 50.0).min(1.0);
        let highest = positions(&simulation).iter().map(|x| x[1]).fold(0.0, f64::max);
        assert!(highest <= plate + 1e-12, "frame {frame}: {highest} above {plate}");
    }
}

#[test]
fn springs_alone_lose_more_than_half_of_the_volume() {
    let weak = |body: Body| Body { volume: None, ..soft(body, 100.0) };
    for scene in
        [fall(weak(ball(3, VolumeForm::None))), press(weak(ball(3, VolumeForm::None)), 1.0, 0.2, 0.0005)]
    {
        let (loss, _) = worst(&scene, Precision::F32);
        assert!(loss > 0.5, "{}: {loss}", scene.title);
    }
}

#[test]
fn the_form_of_the_papers_programs_loses_some_volume_and_does_not_get_it_back() {
    for (i, scene) in scenes(VolumeForm::PaperShader).iter().enumerate() {
        let (loss, _) = worst(scene, Precision::F64);
        assert!((0.005..0.5).contains(&loss), "{} {i}: {loss}", scene.title);
    }
}

#[test]
fn the_printed_form_blows_up_at_once_and_says_so() {
    for scene in &scenes(VolumeForm::Printed)[..2] {
        for precision in [Precision::F32, Precision::F64] {
            let mut simulation = build_as(scene, precision, 1);
            simulation.disturb(1e-4, 1);
            let Err(StepError::Diverged(end)) = (0..100).try_for_each(|_| simulation.step().map(drop)) else {
                panic!("{}, {precision}: it does not", scene.title)
            };
            assert!(end.frame < 60, "{end}");
        }
    }
}

#[test]
fn a_body_squeezed_to_nothing_stays_finite_or_says_what_is_wrong() {
    for form in [VolumeForm::Corrected, VolumeForm::Projected, VolumeForm::PaperShader, VolumeForm::None] {
        for gap in [0.01, -0.3] {
            for precision in [Precision::F32, Precision::F64] {
                let scene = press(soft(ball(2, form), 300.0), 1.0, gap, 0.0005);
                let mut simulation = build_as(&scene, precision, 1);
                let end = (0..100).try_for_each(|_| simulation.step().map(drop));
                match end {
                    Ok(()) => assert!(positions(&simulation).iter().flatten().all(|c| c.is_finite())),
                    Err(StepError::Diverged(end)) => assert_eq!(end.body, "ball"),
                    Err(other) => panic!("{other}"),
                }
            }
        }
    }
}

#[test]
fn a_body_that_rests_keeps_its_volume_and_stands_still() {
    for form in [VolumeForm::Corrected, VolumeForm::Projected] {
        let mut scene = fall(soft(ball(2, form), 1000.0));
        scene.bodies[0].place.position = [0.0, 0.49, 0.0];
        scene.bodies[0].springs.structural = Some(Spring { k: 1000.0, d: 2.0 });
        let mut simulation = build_as(&scene, Precision::F64, 1);
        let mut error_at = |frames| {
            run(&mut simulation, frames);
            (error(&simulation).abs(), simulation.report().kinetic)
        };
        let (moving, resting) = (error_at(10), error_at(400));
        assert!(resting.0 < 1e-4 && resting.1 < 1e-3 * moving.1, "{form:?}: {moving:?} {resting:?}");
    }
}
