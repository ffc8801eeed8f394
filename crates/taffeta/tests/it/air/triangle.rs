//! A flat sheet in a steady flow.

use super::{AIR, GUSTY, STILL, blown, loose};
use crate::common::state::{set, state};
use crate::common::{V, build, near, norm, run, scale, sub, turned};
use taffeta::scene::{Air, Mass};

/// Speed of a sheet that falls flat from rest, after some time [s].
fn falling(h: f64, time: f64) -> f64 {
    let mut scene = blown(loose(3, 4), STILL, h);
    scene.world.gravity = [0.0, -9.81, 0.0];
    let mut simulation = build(&scene);
    run(&mut simulation, (time / h).round() as u32);
    -simulation.report().momentum[1] / 0.06
}

/// √(2 m g/(ρ C_D A)) [m/s]: 0.06 kg on 0.2 m².
fn terminal() -> f64 {
    (2.0 * 0.06 * 9.81 / (1.3 * 1.1 * 0.2_f64)).sqrt()
}

#[test]
fn a_sheet_that_falls_flat_comes_to_the_speed_at_which_drag_bears_its_weight() {
    // Up to a step of half the time in which it would fall that fast.
    for h in [1e-3, 1.0 / 240.0, 1.0 / 60.0, 0.1] {
        // Long enough to be there, and too short for a sheet to tilt: what rounding begins, lift would let grow.
        near(&format!("{h} s"), falling(h, 2.4), terminal(), 1e-6);
    }
}

#[test]
fn on_the_way_there_it_follows_the_hyperbolic_tangent() {
    let exact = terminal() * (9.81 * 0.5 / terminal()).tanh();
    let error = |h: f64| falling(h, 0.5) - exact;
    assert!(error(1e-3).abs() < 3e-3 * exact, "{}", error(1e-3));
    near("order", (error(2e-3) / error(1e-3)).log2(), 1.0, 0.02);
}

/// Force [N] on a sheet of a ton that stands in the flow `w`, turned by an angle about z.
fn force(degrees: f64, w: V) -> V {
    let mut body = loose(2, 2).with_mass(Mass::Whole(1000.0));
    body.place = turned([0.0, 0.0, 1.0], degrees, [0.0; 3]);
    let mut simulation = build(&blown(body, Air { velocity: w, ..AIR }, 1e-3));
    run(&mut simulation, 1);
    scale(simulation.report().momentum, 1e3)
}

#[test]
fn lift_and_drag_go_by_the_angle_of_attack() {
    // A flow along x; the sheet's edges are along z.
    let pressure = 0.5 * 1.3 * 0.2 * 25.0;
    for degrees in [0.0, 1.0, 10.0, 30.0, 45.0, 70.0, 90.0, 110.0, 179.0, 200.0, 300.0] {
        let angle = f64::to_radians(degrees);
        let drag = 1.1 * pressure * angle.sin().abs();
        // The edge that the flow meets is low where the angle is small: the flow presses down.
        let lift = -0.9 * pressure * 0.5 * (2.0 * angle).sin();
        let found = force(degrees, [5.0, 0.0, 0.0]);
        assert!(
            norm(sub(found, [drag, lift, 0.0])) < 1e-6 * pressure,
            "{degrees}°: {found:?}, {drag} and {lift}"
        );
    }
}

#[test]
fn force_grows_with_the_square_of_the_speed() {
    let [slow, fast] = [2.0, 6.0].map(|speed| norm(force(33.0, [speed, 0.0, 0.0])));
    near("ratio", fast / slow, 9.0, 1e-5);
}

#[test]
fn cloth_that_moves_with_the_air_feels_nothing() {
    let mut simulation = build(&blown(loose(4, 5), AIR, 0.01));
    let (x, v) = state(&simulation);
    set(&mut simulation, &x, &vec![AIR.velocity; v.len()]);
    run(&mut simulation, 50);
    let (_, after) = state(&simulation);
    assert!(after.iter().all(|v| norm(sub(*v, AIR.velocity)) < 1e-14));
}

#[test]
fn cloth_in_moving_air_and_cloth_that_moves_through_still_air_are_the_same() {
    // Gusts drift with the air.
    let still = Air { velocity: [0.0; 3], ..GUSTY };
    let body = || loose(4, 5).structural(20.0, 0.01);
    let [mut windy, mut moving] = [GUSTY, still].map(|air| build(&blown(body(), air, 0.005)));
    let (x, v) = state(&moving);
    set(&mut moving, &x, &vec![scale(GUSTY.velocity, -1.0); v.len()]);
    run(&mut windy, 60);
    run(&mut moving, 60);
    let way = scale(GUSTY.velocity, 60.0 * 0.005);
    let (there, _) = state(&windy);
    let (here, _) = state(&moving);
    for (a, b) in there.iter().zip(&here) {
        assert!(norm(sub(sub(*a, *b), way)) < 1e-9);
    }
    assert!(norm(sub(there[7], x[7])) > 0.05, "something has happened");
}
