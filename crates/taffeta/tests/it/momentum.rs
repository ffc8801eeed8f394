//! Without forces from outside, linear and angular momentum stay what they are, damped or not.

use crate::common::{build, build_as, norm, run, weightless};
use taffeta::scene::{Body, Cube, Icosphere, Internal, Mass, Mesh, Torus};
use taffeta::{Precision, Simulation};

fn bodies() -> Vec<Body> {
    let ball = Mesh::Icosphere(Icosphere { radius: 0.4, subdivisions: 2 });
    let ring = Mesh::Torus(Torus { major: 0.5, minor: 0.2, rings: 16, segments: 8 });
    let mut cube = Body::soft("cube", Mesh::Cube(Cube { size: 0.6, divisions: 4 }));
    cube.springs.internal = Some(Internal { count: 60, k: 100.0, d: 0.3, ..Internal::default() });
    vec![
        Body::cloth("sheet", Mesh::grid(12, 15, [1.0, 0.8]))
            .with_mass(Mass::Area(2.0))
            .structural(200.0, 0.2)
            .shear(120.0, 0.1)
            .bend(80.0, 0.1)
            .hinge(0.01, 1e-4),
        Body::cloth("wide", Mesh::grid(4, 600, [60.0, 0.3]))
            .with_mass(Mass::Node(0.02))
            .structural(200.0, 0.2),
        Body::cloth("ball", ball).with_mass(Mass::Node(0.02)).structural(200.0, 0.1).bend(80.0, 0.1),
        Body::soft("ring", ring).with_mass(Mass::Volume(200.0)).structural(300.0, 0.2).hinge(0.02, 1e-4),
        cube.with_mass(Mass::Whole(2.0)).structural(200.0, 0.2),
        Body::cloth("chain", Mesh::chain(20, 2.0))
            .with_mass(Mass::Node(0.05))
            .structural(200.0, 0.1)
            .bend(20.0, 0.0),
    ]
}

/// Off the origin, disturbed, with a push and a twist from the first frame, then left alone.
fn pushed(body: Body, precision: Precision) -> Simulation {
    let name = body.name.clone();
    let mut simulation =
        build_as(&weightless(&name, 0.005, 0.0005).body(body.at([0.5, 1.0, -2.0])), precision, 2);
    simulation.disturb(0.005, 3);
    for (vertex, force) in [(0, [3.0, 1.0, -2.0]), (9, [0.0, -4.0, 1.0])] {
        simulation.apply_force(simulation.body(&name).unwrap(), vertex, force).unwrap();
    }
    run(&mut simulation, 1);
    simulation
}

/// Largest change of linear and angular momentum over a second, each against its own size.
fn drift(mut simulation: Simulation) -> [f64; 2] {
    let start = simulation.report().clone();
    let mut worst = [0.0_f64; 2];
    for _ in 0..200 {
        run(&mut simulation, 1);
        let now = simulation.report();
        for (i, (p, q)) in [(now.momentum, start.momentum), (now.angular_momentum, start.angular_momentum)]
            .into_iter()
            .enumerate()
        {
            worst[i] = worst[i].max(norm(crate::common::sub(p, q)) / norm(q));
        }
    }
    assert!(simulation.report().energy() < 0.9 * start.energy(), "damping takes energy all the same");
    worst
}

#[test]
fn momentum_does_not_drift_in_64_bits() {
    for body in bodies() {
        let name = body.name.clone();
        let [linear, angular] = drift(pushed(body, Precision::F64));
        // 2,000 steps, each with a rounding of a few ulps of forces that add up to nothing.
        assert!(linear < 1e-12 && angular < 1e-12, "{name}: {linear:e} {angular:e}");
    }
}

#[test]
fn momentum_drifts_by_roundings_alone_in_32_bits() {
    for body in bodies() {
        let name = body.name.clone();
        let [linear, angular] = drift(pushed(body, Precision::F32));
        assert!(linear < 1e-3 && angular < 1e-3, "{name}: {linear:e} {angular:e}");
    }
}

#[test]
fn a_body_at_rest_stays_at_rest() {
    for body in bodies() {
        let mut simulation = build(&weightless("rest", 0.005, 0.0005).body(body));
        run(&mut simulation, 20);
        let report = simulation.report();
        // Rest lengths are known to a rounding; so are speeds, times k h/m of some 1e3 1/s.
        assert!(report.kinetic < 1e-20 && (report.max_stretch - 1.0).abs() < 1e-12, "{report:?}");
    }
}

#[test]
fn undamped_springs_keep_their_energy_within_a_bound_that_shrinks_with_the_step() {
    let error = |h: f64| {
        let body = Body::cloth("sheet", Mesh::grid(12, 15, [1.0, 0.8]));
        let body = body.with_mass(Mass::Node(0.02)).structural(200.0, 0.0).shear(120.0, 0.0).hinge(0.01, 0.0);
        let mut simulation = build(&weightless("energy", 0.005, h).body(body));
        simulation.disturb(0.003, 3);
        let start = simulation.report().energy();
        let mut worst = 0.0_f64;
        for _ in 0..200 {
            run(&mut simulation, 1);
            worst = worst.max((simulation.report().energy() / start - 1.0).abs());
        }
        worst
    };
    let [coarse, fine] = [error(5e-4), error(1.25e-4)];
    assert!(coarse < 0.05 && fine < coarse / 3.0, "{coarse} {fine}");
}
