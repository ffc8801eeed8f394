//! Without forces from outside: momenta, rest, and what a step leaves.

use super::{ball, error, ring};
use crate::common::{V, build, build_as, farthest, norm, positions, run, sub, weightless};
use taffeta::scene::{Body, Volume, VolumeForm, VolumeWeights};
use taffeta::{Precision, Simulation};

fn bodies() -> Vec<(&'static str, Body)> {
    let weighted = |mut body: Body| {
        let weights = VolumeWeights { center: [0.9, 1.1, -2.0], radius: 0.4 };
        body.volume = Some(Volume { weights: Some(weights), ..Volume::default() });
        body
    };
    let mut blown = ball(2, VolumeForm::None);
    blown.volume = Some(Volume { pressure: Some(20.0), ..Volume::default() });
    vec![
        ("corrected ball", ball(3, VolumeForm::Corrected)),
        ("corrected ring", ring(VolumeForm::Corrected)),
        ("paper-shader ball", ball(2, VolumeForm::PaperShader)),
        ("weighted ball", weighted(ball(2, VolumeForm::Corrected))),
        ("weighted ring", weighted(ring(VolumeForm::Corrected))),
        ("ball under pressure", blown),
    ]
}

/// Off the origin, disturbed, with a push and a twist in the first frame, then left alone.
fn pushed(body: Body, precision: Precision, h: f64) -> Simulation {
    let name = body.name.clone();
    let mut simulation = build_as(&weightless(&name, 0.005, h).body(body.at([0.5, 1.0, -2.0])), precision, 2);
    simulation.disturb(0.005, 3);
    for (vertex, force) in [(0, [3.0, 1.0, -2.0]), (9, [0.0, -4.0, 1.0])] {
        simulation.apply_force(simulation.body(&name).unwrap(), vertex, force).unwrap();
    }
    run(&mut simulation, 1);
    simulation
}

/// Largest change of linear and angular momentum over some frames, each against its own size.
fn drift(mut simulation: Simulation, frames: u32) -> [f64; 2] {
    let start = simulation.report().clone();
    let mut worst = [0.0_f64; 2];
    for _ in 0..frames {
        run(&mut simulation, 1);
        let now = simulation.report();
        let pairs = [(now.momentum, start.momentum), (now.angular_momentum, start.angular_momentum)];
        for (worst, (p, q)) in worst.iter_mut().zip(pairs) {
            *worst = worst.max(norm(sub(p, q)) / norm(q));
        }
    }
    worst
}

#[test]
fn forces_that_keep_volumes_leave_linear_and_angular_momentum_alone() {
    for (name, body) in bodies() {
        let [linear, angular] = drift(pushed(body, Precision::F64, 0.0005), 200);
        assert!(linear < 1e-12 && angular < 1e-12, "{name}: {linear:e} {angular:e}");
    }
}

#[test]
fn the_printed_form_diverges_without_changing_momenta() {
    let [linear, angular] = drift(pushed(ball(2, VolumeForm::Printed), Precision::F64, 0.0025), 4);
    assert!(linear < 1e-11 && angular < 1e-11, "{linear:e} {angular:e}");
}

#[test]
fn moving_nodes_leaves_linear_momentum_alone_and_angular_momentum_to_first_order_in_the_step() {
    let of = |h: f64| drift(pushed(ball(2, VolumeForm::Projected), Precision::F64, h), 50);
    let [[linear, coarse], [_, fine]] = [of(0.001), of(0.0005)];
    assert!(linear < 1e-12 && coarse < 1e-4, "{linear:e} {coarse:e}");
    assert!(fine < 0.6 * coarse, "{coarse:e} {fine:e}");
}

#[test]
fn a_body_at_rest_stays_at_rest() {
    for form in [VolumeForm::Corrected, VolumeForm::Projected, VolumeForm::PaperShader] {
        for body in [ball(3, form), ring(form)] {
            let mut simulation = build(&weightless("rest", 0.005, 0.0005).body(body));
            let start = positions(&simulation);
            run(&mut simulation, 20);
            let report = simulation.report();
            let apart = farthest(&start, &positions(&simulation));
            assert!(
                report.kinetic < 1e-20 && apart < 1e-12 && error(&simulation).abs() < 1e-13,
                "{report:?}"
            );
        }
    }
}

#[test]
fn a_step_leaves_an_error_of_second_order_in_its_length() {
    // A moving, stretched ball whose volume is right to 1e-10.
    let mut start = pushed(ball(2, VolumeForm::Projected), Precision::F64, 0.0005);
    run(&mut start, 20);
    let snapshot = start.snapshot();
    let residual = |h: f64| {
        let scene = weightless("step", h, h).body(ball(2, VolumeForm::Corrected).at([0.5, 1.0, -2.0]));
        let mut simulation = build(&scene);
        // The state of another scene.
        let mut snapshot = snapshot.clone();
        snapshot.scene = simulation.snapshot().scene;
        simulation.restore(&snapshot).unwrap();
        run(&mut simulation, 1);
        error(&simulation).abs()
    };
    let [coarse, middle, fine] = [residual(0.002), residual(0.001), residual(0.0005)];
    assert!(fine > 1e-9, "more than was there before: {fine:e}");
    for ratio in [coarse / middle, middle / fine] {
        assert!((3.8..4.2).contains(&ratio), "{coarse:e} {middle:e} {fine:e}");
    }
}

#[test]
fn far_from_the_origin_32_bits_keep_the_volume_as_well_as_places_can_say() {
    let worst = |away: f64, form: VolumeForm| {
        let place: V = [away, -0.5 * away, 0.3 * away];
        let mut simulation =
            build_as(&weightless("far", 0.005, 0.0005).body(ball(3, form).at(place)), Precision::F32, 1);
        simulation.disturb(0.005, 3);
        simulation.apply_force(simulation.body("ball").unwrap(), 0, [30.0, 10.0, -20.0]).unwrap();
        let mut worst = 0.0_f64;
        for frame in 0..200 {
            run(&mut simulation, 1);
            if frame > 2 {
                worst = worst.max(error(&simulation).abs());
            }
        }
        worst
    };
    for (away, corrected, projected) in [(0.0, 4e-6, 1e-6), (100.0, 1e-5, 1e-5), (1000.0, 1e-4, 1e-4)] {
        let got = worst(away, VolumeForm::Corrected);
        assert!(got < corrected, "{away} m: {got:e}");
        let got = worst(away, VolumeForm::Projected);
        assert!(got < projected, "{away} m: {got:e}");
    }
}
