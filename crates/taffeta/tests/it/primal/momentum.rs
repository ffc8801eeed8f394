//! What is kept, and what a step of backward Euler does not keep.

use super::{accurate, newton, with};
use crate::common::compare::cloth;
use crate::common::state::{set, state, stiffen};
use crate::common::{build, cross, near, norm, positions, run, scale, sub, weightless};
use taffeta::scene::{Body, Ice, Icosphere, Internal, Mass, Mesh, Scene};

fn bodies() -> [Body; 2] {
    let mesh = Mesh::Icosphere(Icosphere { radius: 0.4, subdivisions: 1 });
    let mut ball = Body::soft("ball", mesh).with_mass(Mass::Area(2.0)).structural(5e3, 0.5).bend(300.0, 0.1);
    ball.springs.internal = Some(Internal { count: 20, k: 100.0, d: 0.3, ..Internal::default() });
    let mut sheet = cloth(9, 11, [1.0, 0.8]);
    stiffen(&mut sheet, 50.0);
    [sheet, ball]
}

/// Off the origin, disturbed, with a push and a twist in the first frame, then left alone for a quarter of a second.
/// Largest change of linear and angular momentum, each against its own size.
fn drift(scene: &Scene) -> [f64; 2] {
    let mut simulation = build(scene);
    simulation.disturb(0.005, 3);
    let name = scene.bodies[0].name.as_str();
    for (vertex, force) in [(0, [3.0, 1.0, -2.0]), (9, [0.0, -4.0, 1.0])] {
        simulation.apply_force(simulation.body(name).unwrap(), vertex, force).unwrap();
    }
    run(&mut simulation, 1);
    let start = simulation.report().clone();
    let mut worst = [0.0_f64; 2];
    for _ in 0..50 {
        run(&mut simulation, 1);
        let now = simulation.report();
        let both = [(now.momentum, start.momentum), (now.angular_momentum, start.angular_momentum)];
        for (worst, (p, q)) in worst.iter_mut().zip(both) {
            *worst = worst.max(norm(sub(p, q)) / norm(q));
        }
    }
    worst
}

#[test]
fn linear_momentum_does_not_drift_at_any_tolerance() {
    for body in bodies() {
        let scene = weightless("free", 0.005, 0.005).body(body.at([0.5, 1.0, -2.0]));
        for tolerance in [1e-13, 1e-6, 1e-3] {
            for newton_steps in [1, 3] {
                let ice = Ice { tolerance, ..accurate(newton_steps) };
                let [linear, _] = drift(&with(scene.clone(), ice));
                assert!(
                    linear < 1e-10,
                    "{}, {tolerance:e}, {newton_steps}: {linear:e}",
                    scene.bodies[0].name
                );
            }
        }
    }
}

#[test]
fn what_falls_at_rest_falls_as_a_stone() {
    for body in bodies() {
        for ice in [newton(1), newton(2), accurate(1)] {
            let scene = with(Scene::new("falls").time(0.05, 0.01).body(body.clone()), ice);
            let mut simulation = build(&scene);
            let start = positions(&simulation);
            run(&mut simulation, 20);
            // n steps of h: g h² n (n + 1)/2.
            let fall = [0.0, -9.81 * 1e-4 * 100.0 * 101.0 / 2.0, 0.0];
            let (x, v) = state(&simulation);
            for (n, (&x, &from)) in x.iter().zip(&start).enumerate() {
                near("fall", norm(sub(sub(x, from), fall)), 0.0, 1e-11);
                near("speed", norm(sub(v[n], [0.0, -9.81, 0.0])), 0.0, 1e-10);
            }
        }
    }
}

#[test]
fn a_ball_that_spins_slows_down_as_backward_euler_has_it() {
    // What turns at ω loses the share h² ω² of its spin in a step: 1/ω² = 1/ω₀² + 2 h t.
    let mesh = Mesh::Icosphere(Icosphere { radius: 0.4, subdivisions: 2 });
    let body = Body::cloth("ball", mesh).with_mass(Mass::Node(0.01)).structural(2e3, 0.5);
    let axis = [1.0, 2.0, -2.0];
    for h in [4e-3, 2e-3] {
        let mut ball = build(&with(weightless("spins", 0.4, h).body(body.clone()), accurate(2)));
        let (x, _) = state(&ball);
        let v: Vec<_> = x.iter().map(|&x| cross(axis, x)).collect();
        set(&mut ball, &x, &v);
        ball.disturb(0.0, 0);
        let start = ball.report().angular_momentum;
        run(&mut ball, 1);
        let left = (1.0_f64 / 9.0 / (1.0 / 9.0 + 2.0 * h * 0.4)).sqrt();
        let now = ball.report();
        near(
            "spin",
            norm(sub(now.angular_momentum, scale(start, left))) / norm(start),
            0.0,
            0.05 * (1.0 - left),
        );
        assert!(norm(now.momentum) < 1e-12, "{now:?}");
    }
}
