//! Which springs become constraints, and for how long.

use super::{accurate, chain, set, with_acad};
use crate::common::compare::cloth;
use crate::common::{build, build_as, near, norm, positions, run, sub, turned, weightless};
use taffeta::scene::{Acad, Body, ConstraintForm, Icosphere, Keyframe, Mass, Mesh, Method, Scene, Select};
use taffeta::{Precision, Simulation};

const H: f64 = 0.01;

/// Two nodes of 0.1 kg joined by a spring of 1 m, 7 N/m, at a distance.
fn pair(apart: f64, acad: Acad) -> Simulation {
    let scene = weightless("pair", H, H).body(chain(1, 1.0, 0.1, [7.0, 0.0]));
    let mut simulation = build(&with_acad(scene, acad, accurate()));
    set(&mut simulation, &[[-0.5 * apart, 0.0, 0.0], [0.5 * apart, 0.0, 0.0]], &[[0.0; 3]; 2]);
    simulation
}

/// Length [m] and share of constraints after one more step.
fn step(pair: &mut Simulation) -> [f64; 2] {
    run(pair, 1);
    let x = positions(pair);
    [norm(sub(x[1], x[0])), pair.report().solver.active_fraction]
}

#[test]
fn a_spring_acts_up_to_the_threshold_and_a_constraint_beyond() {
    let spring = |l: f64| l - H * H * 20.0 * 7.0 * (l - 1.0);
    // What ε leaves of the gap.
    let constraint = |l: f64| 1.0 + (l - 1.0) * 0.3 / 1.3;
    for (length, expected, active) in [
        (1.09, spring(1.09), 0.0),
        (0.5, spring(0.5), 0.0),
        (1.11, constraint(1.11), 1.0),
        (3.0, constraint(3.0), 1.0),
    ] {
        let [after, fraction] = step(&mut pair(length, Acad::default()));
        near("length", after, expected, 1e-13);
        assert_eq!(fraction, active, "{length} m");
    }
    // A threshold, a target and an epsilon of the scene's own.
    let own = Acad { threshold: 0.5, target: 0.2, epsilon: 0.1, ..Acad::default() };
    near("below", step(&mut pair(1.49, own.clone()))[0], spring(1.49), 1e-13);
    near("above", step(&mut pair(1.51, own))[0], 1.2 + 0.31 * 0.1 / 1.1, 1e-13);
    // As printed nothing is left to compliance: half way to the square, as by ICE.
    let printed = Acad { form: ConstraintForm::Printed, target: 0.05, ..Acad::default() };
    near("printed", step(&mut pair(1.2, printed))[0], 0.5 * (1.2 + 1.05 * 1.05 / 1.2), 1e-13);
}

#[test]
fn a_constraint_stays_one_until_it_is_shorter_than_what_releases_it() {
    // From 1.2 m to 1.0923 m in one step: that is between 1.05 m and 1.1 m. It was moving inwards by 10.8 m/s: with
    // velocities taken away it is held there.
    let acad = Acad { target: 0.06, release: 0.05, ..Acad::default() };
    let mut held = pair(1.2, acad.clone());
    let [length, fraction] = step(&mut held);
    near("length", length, 1.06 + 0.14 * 0.3 / 1.3, 1e-13);
    assert_eq!(fraction, 1.0);
    let still = [[-0.5 * length, 0.0, 0.0], [0.5 * length, 0.0, 0.0]];
    set(&mut held, &still, &[[0.0; 3]; 2]);
    let [after, fraction] = step(&mut held);
    near("still a constraint", after, 1.06 + (length - 1.06) * 0.3 / 1.3, 1e-13);
    assert_eq!(fraction, 1.0);
    // One that was never longer is a spring at that length.
    let [after, fraction] = step(&mut pair(length, acad.clone()));
    near("a spring", after, length - H * H * 20.0 * 7.0 * (length - 1.0), 1e-13);
    assert_eq!(fraction, 0.0);
    // Released, it is a spring again, and one between both limits stays a spring.
    for length in [1.04, 1.07] {
        set(&mut held, &[[-0.5 * length, 0.0, 0.0], [0.5 * length, 0.0, 0.0]], &[[0.0; 3]; 2]);
        let [after, fraction] = step(&mut held);
        near("released", after, length - H * H * 20.0 * 7.0 * (length - 1.0), 1e-13);
        assert_eq!(fraction, 0.0);
    }
}

/// Bodies of every kind that stretch by less than a tenth.
fn gentle() -> Scene {
    let ball = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 2 });
    let mut sheet = cloth(20, 23, [2.2, 1.9]).hinge(2e-3, 1e-5).pin(Select::nodes([0]));
    sheet.place = turned([1.0, 0.3, 0.0], 20.0, [0.0, 1.0, 0.0]);
    let slow = Keyframe::translate(1.0, [0.0, 0.1, 0.0]);
    let chain = Body { name: "string".into(), ..chain(30, 3.0, 0.02, [90.0, 0.05]) };
    weightless("gentle", 0.01, 0.003)
        .body(sheet)
        .body(
            Body::cloth("ball", ball)
                .with_mass(Mass::Node(0.02))
                .structural(90.0, 0.05)
                .bend(30.0, 0.02)
                .at([4.0, 0.0, 0.0]),
        )
        .body(chain.at([0.0, 0.0, 3.0]).pin_moving(Select::nodes([3]), vec![slow]))
}

#[test]
fn where_no_spring_is_too_long_all_is_as_without_to_the_bit() {
    for precision in [Precision::F32, Precision::F64] {
        for threads in [1, 2] {
            let [springs, acad] = [Method::Springs, Method::Acad].map(|method| {
                let mut scene = gentle();
                scene.solver.method = method;
                let mut simulation = build_as(&scene, precision, threads);
                simulation.disturb(0.002, 4);
                run(&mut simulation, 20);
                simulation
            });
            assert!(acad.report().max_stretch > 1.01, "it is stretched");
            assert_eq!(acad.report().solver.active_fraction, 0.0);
            assert_eq!(springs.state_hash(), acad.state_hash(), "{precision}, {threads} threads");
        }
    }
}

#[test]
fn the_share_of_constraints_is_that_of_the_springs_that_are_too_long() {
    // Of a chain of ten links, three are 1.2 times as long as at rest.
    let scene = weightless("share", H, H).body(chain(10, 1.0, 0.1, [7.0, 0.0]));
    let mut simulation = build(&with_acad(scene, Acad::default(), accurate()));
    let mut x = positions(&simulation);
    for link in [2, 3, 8] {
        x[link + 1..].iter_mut().for_each(|x| x[0] += 0.02);
    }
    set(&mut simulation, &x, &[[0.0; 3]; 11]);
    run(&mut simulation, 1);
    near("share", simulation.report().solver.active_fraction, 0.3, 1e-15);
}
