//! What is kept, and what a step of backward Euler does not keep.

use super::common::compare::cloth;
use super::common::state::{set, state, stiffen};
use super::common::{add, build, cross, near, norm, positions, run, scale, sub, weightless};
use super::{accurate, newton, with};
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
        simulation.apply_force(name, vertex, force).unwrap();
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
fn linear_momentum_does_not_drift() {
    for body in bodies() {
        let scene = weightless("free", 0.005, 0.005).body(body.at([0.5, 1.0, -2.0]));
        for ice in [accurate(1), accurate(3), newton(1), newton(2), Ice { max_iterations: 2, ..newton(1) }] {
            let [linear, angular] = drift(&with(scene.clone(), ice.clone()));
            println!("{} {ice:?}: {linear:e} {angular:e}", scene.bodies[0].name);
            assert!(linear < 1e-11, "{}, {ice:?}: {linear:e}", scene.bodies[0].name);
        }
    }
}

#[test]
fn angular_momentum_is_lost_at_first_order_in_the_step() {
    for body in bodies() {
        let lost = [4e-3, 2e-3, 1e-3].map(|h| {
            let scene = weightless("free", 0.004, h).body(body.clone().at([0.5, 1.0, -2.0]));
            drift(&with(scene, accurate(1)))[1]
        });
        println!("{}: {lost:?}", body.name);
        assert!(lost[0] < 0.05 && lost[1] < 0.65 * lost[0] && lost[2] < 0.65 * lost[1], "{lost:?}");
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
fn what_moves_on_at_rest_moves_on_and_what_turns_keeps_its_place() {
    for body in bodies() {
        let scene = with(weightless("turns", 0.002, 0.002).body(body.at([0.5, 1.0, -2.0])), accurate(1));
        let mut simulation = build(&scene);
        let (x, mut v) = state(&simulation);
        let middle = scale(x.iter().copied().fold([0.0; 3], add), 1.0 / x.len() as f64);
        // Masses differ: momentum says where the middle of masses goes.
        for (v, &x) in v.iter_mut().zip(&x) {
            *v = add([0.3, -0.1, 0.2], cross([0.5, 1.0, -0.4], sub(x, middle)));
        }
        set(&mut simulation, &x, &v);
        run(&mut simulation, 1);
        let start = simulation.report().clone();
        run(&mut simulation, 100);
        let now = simulation.report();
        near("momentum", norm(sub(now.momentum, start.momentum)) / norm(start.momentum), 0.0, 1e-12);
        // What turns at 1.2 rad/s in steps of 2 ms loses about h ω² of its spin a second.
        let lost = norm(sub(now.angular_momentum, start.angular_momentum)) / norm(start.angular_momentum);
        println!("{}: {lost:e} {}", scene.bodies[0].name, now.max_stretch);
        assert!(lost < 2e-3 && now.max_stretch < 1.01, "{lost:e}, {}", now.max_stretch);
    }
}
