//! Pulls act on both ends alike and along the line between them, however roughly they are found.

use super::{accurate, stiffen, with_acad, with_ice};
use crate::common::compare::cloth;
use crate::common::{build, norm, run, sub, weightless};
use taffeta::Simulation;
use taffeta::scene::{Acad, Body, ConstraintForm, Ice, Icosphere, Internal, Mass, Mesh, Scene};

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
    let mut simulation: Simulation = build(scene);
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
fn momentum_does_not_drift_whatever_the_tolerance_is() {
    let rough = Ice { tolerance: 0.3, max_iterations: 2, ..Ice::default() };
    let printed = ConstraintForm::Printed;
    let low = Acad { threshold: 1e-3, ..Acad::default() };
    for body in bodies() {
        let scene = weightless("free", 0.005, 0.005).body(body.at([0.5, 1.0, -2.0]));
        let all = [
            with_ice(scene.clone(), Ice { tolerance: 1e-9, ..accurate() }),
            with_ice(scene.clone(), rough.clone()),
            with_ice(scene.clone(), Ice { form: printed, ..rough.clone() }),
            with_acad(scene.clone(), low.clone(), Ice::default()),
            with_acad(scene.time(0.005, 0.001), Acad { form: printed, ..low.clone() }, rough.clone()),
        ];
        for scene in all {
            let [linear, angular] = drift(&scene);
            let name = &scene.bodies[0].name;
            // Roundings of forces along each line and back, some of them a thousand times what is left of them.
            assert!(linear < 1e-11 && angular < 1e-11, "{name}, {:?}: {linear:e} {angular:e}", scene.solver);
        }
    }
}
