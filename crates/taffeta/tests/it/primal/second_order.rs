//! Second order in time: swings keep their height, errors fall with the square of the step, and nothing gains energy.

use super::{accurate, chain, newton, with};
use crate::common::compare::{cloth, compare, compare_for, join_grid, reference, scene};
use crate::common::lists::lumped;
use crate::common::reference::{Obstacle, Reference, Rigid};
use crate::common::state::stiffen;
use crate::common::{build, farthest, positions, run, scale, surface, turned};
use taffeta::scene::{Body, Collider, Ice, Keyframe, Mass, Mesh, Scene, Select};
use taffeta::{InputError, Simulation};

fn second(ice: Ice) -> Ice {
    Ice { order: 2, ..ice }
}

/// A sheet of 7 × 9 nodes, and its list of springs.
fn sheet(scene: &Scene, stiffer: f64) -> (Simulation, Reference) {
    let simulation = build(scene);
    let mut reference = reference(scene, &simulation, vec![0.05; 63]);
    join_grid(&mut reference, 7, 9);
    reference.springs.iter_mut().for_each(|spring| spring.2 *= stiffer);
    (simulation, reference)
}

#[test]
fn sheets_and_chains_move_as_their_systems_do() {
    for newton_steps in [1, 2] {
        for stiffer in [1.0, 1e3] {
            let mut body = cloth(7, 9, [0.8, 0.6]).hinge(0.02, 1e-4).pin(Select::nodes([0]));
            stiffen(&mut body, stiffer);
            let body = body.with_mass(Mass::Area(8.0));
            let scene = with(scene(body), second(accurate(newton_steps)));
            let (simulation, mut reference) = sheet(&scene, stiffer);
            let triangles = surface(&simulation, 0).triangles;
            reference.mass = lumped(&positions(&simulation), &triangles, 8.0);
            reference.hinge(&triangles, [0.02, 1e-4]);
            reference.held.insert(0);
            compare_for(simulation, reference, if stiffer > 1.0 { 1e-3 } else { 0.01 }, 10);
        }
    }
    let scene = with(scene(chain(33, 3.3, 0.05, [2e4, 3.0])), second(accurate(2)));
    let simulation = build(&scene);
    let mut reference = reference(&scene, &simulation, vec![0.05; 34]);
    reference.join((0..33).map(|n| [n, n + 1]), [2e4, 3.0]);
    compare_for(simulation, reference, 0.004, 10);
}

#[test]
fn sheets_with_pins_that_turn_and_shift_move_as_their_systems_do() {
    let axis = scale([1.0, 2.0, -2.0], 1.0 / 3.0);
    let pivot = [0.2, 0.1, 0.0];
    let path = Rigid { until: 0.03, shift: [0.02, 0.01, -0.03], axis, radians: 0.3, pivot };
    let key = Keyframe { translate: path.shift, ..Keyframe::rotate(0.03, axis, 0.3_f64.to_degrees(), pivot) };
    let pinned = [0, 1, 8, 30];
    let mut body = cloth(7, 9, [0.8, 0.6]).pin_moving(Select::nodes(pinned), vec![key]);
    stiffen(&mut body, 1e3);
    let scene = with(scene(body), second(accurate(2)));
    let (simulation, mut reference) = sheet(&scene, 1e3);
    reference.held.extend([0, 1, 8, 30]);
    reference.pins = pinned.map(|n| (n as usize, reference.x[n as usize], path)).to_vec();
    compare(simulation, reference, 5e-4);
}

#[test]
fn sheets_that_land_on_a_ball_and_slide_move_as_their_systems_do() {
    let (at, mut touched) = ([0.0, -0.099, 0.0], 0);
    for (stiffer, friction, allowed) in [(1.0, 0.0, 1e-6), (1.0, 0.4, 2e-5), (200.0, 0.0, 1e-6)] {
        let mut body = cloth(7, 9, [0.8, 0.6]);
        stiffen(&mut body, stiffer);
        let ball = Collider::sphere(at, 0.09).offset(0.01).friction(friction).restitution(0.0);
        let scene = with(scene(body).collider(ball), second(accurate(2)));
        let (mut simulation, mut reference) = sheet(&scene, stiffer);
        let motion = Rigid { until: 1.0, shift: [0.0; 3], axis: [0.0, 1.0, 0.0], radians: 0.0, pivot: at };
        let normal = [0.0, 1.0, 0.0];
        reference.obstacles =
            vec![Obstacle { at, ball: Some(0.1), normal, friction, restitution: 0.0, motion }];
        simulation.disturb(0.004, 7);
        reference.x = positions(&simulation);
        for frame in 1..=20 {
            run(&mut simulation, 1);
            [0.001, 0.001, 0.0005].into_iter().for_each(|h| reference.step(h));
            let apart = farthest(&positions(&simulation), &reference.x);
            assert!(apart < allowed, "{stiffer}, {friction}, frame {frame}: {apart:e} m apart");
            touched += reference.touched;
        }
    }
    assert!(touched > 1, "{touched}");
}

/// A chain let go from an angle, hanging by its first node.
fn swing(links: u32, length: f64, k: f64, degrees: f64) -> Body {
    let body = chain(links, length, 0.3 / f64::from(links), [k, 0.0]).pin(Select::nodes([0]));
    Body { place: turned([0.0, 0.0, 1.0], degrees - 90.0, [0.0; 3]), ..body }
}

/// Energy above that at rest, by that at the start, in some seconds at 1/60 s, at most and at the end. At the start it is
/// `height` [J] above rest.
fn energy_left(body: Body, ice: Ice, seconds: u32, height: f64) -> [f64; 2] {
    let mut simulation = build(&with(Scene::new("swing").time(1.0 / 60.0, 1.0 / 60.0).body(body), ice));
    let start = simulation.report().energy();
    let lowest = start - height;
    let (mut most, mut now) = (start, start);
    for _ in 0..60 * seconds {
        run(&mut simulation, 1);
        now = simulation.report().energy();
        most = most.max(now);
    }
    [most, now].map(|energy| (energy - lowest) / (start - lowest))
}

#[test]
fn a_pendulum_keeps_its_height_where_first_order_loses_half_of_it() {
    // A node of 0.3 kg 1 m from its pin; at rest its weight stretches the link.
    let (k, weight) = (1e4, 0.3 * 9.81);
    for degrees in [20.0, 30.0] {
        let body = swing(1, 1.0, k, degrees);
        let height = weight * (1.0 - f64::to_radians(degrees).cos()) + 0.5 * weight * weight / k;
        let [most, left] = energy_left(body.clone(), second(newton(1)), 10, height);
        // Amplitude is the root of energy.
        assert!(most < 1.0 + 1e-9 && left.sqrt() > 0.995, "{degrees}: {most}, {left}");
        let [_, left] = energy_left(body, newton(1), 10, height);
        assert!(left.sqrt() < 0.6, "{degrees}: {left}");
    }
}

/// How far a smooth motion is off a fine one after a while [m].
fn off(order: u32, h: f64, fine: &[[f64; 3]]) -> f64 {
    farthest(&after_a_while(order, h), fine)
}

/// A soft sheet that swings by an edge.
fn after_a_while(order: u32, h: f64) -> Vec<[f64; 3]> {
    let mut body = cloth(5, 4, [0.6, 0.8]).with_mass(Mass::Node(0.05)).pin(Select::rows(0, 0));
    body.place = turned([1.0, 0.0, 0.0], 50.0, [0.0; 3]);
    let ice = Ice { order, ..accurate(3) };
    let mut simulation = build(&with(Scene::new("smooth").time(h, h).body(body), ice));
    run(&mut simulation, (0.4 / h).round() as u32);
    positions(&simulation)
}

#[test]
fn errors_fall_with_the_step_at_first_order_and_with_its_square_at_second() {
    let fine = after_a_while(2, 0.4 / 3200.0);
    for (order, least, most) in [(1, 0.8, 1.3), (2, 1.8, 2.3)] {
        let [coarse, middle, small] = [100.0, 200.0, 400.0].map(|steps| off(order, 0.4 / steps, &fine));
        for slope in [(coarse / middle).log2(), (middle / small).log2()] {
            assert!(slope > least && slope < most, "{order}: {coarse:e} {middle:e} {small:e} m");
        }
    }
}

#[test]
fn sheets_that_drop_or_swing_gain_no_energy() {
    let rough = |collider: Collider| collider.friction(0.3).restitution(0.0);
    // In a step in which a node moves about as far as its neighbour is away, energy can rise a little.
    for (k, most) in [(200.0, 1.0), (2e4, 1.01)] {
        let body = Body::cloth("sheet", Mesh::grid(32, 32, [2.0, 2.0])).with_mass(Mass::Node(0.15));
        let body = body.structural(k, 0.1).shear(k, 0.1).bend(k, 0.1).at([0.0, 0.55, 0.0]);
        let scene = Scene::new("drop")
            .time(0.016, 0.016)
            .body(body)
            .collider(rough(Collider::sphere([0.0; 3], 0.5)).offset(0.01))
            .collider(rough(Collider::plane([0.0, -0.5, 0.0], [0.0, 1.0, 0.0])).offset(0.0));
        let mut simulation = build(&with(scene, second(newton(1))));
        let start = simulation.report().energy();
        for frame in 1..=200 {
            run(&mut simulation, 1);
            let now = simulation.report().energy();
            assert!(now <= most * start, "{k} N/m, frame {frame}: {now} J of {start} J");
        }
        assert!(simulation.report().kinetic < 0.2 * start, "{k}: {}", simulation.report().kinetic);
    }
}

#[test]
fn a_restored_run_goes_on_bit_by_bit_and_accelerations_are_part_of_it() {
    let body = cloth(9, 8, [0.7, 0.8]).pin(Select::nodes([0, 7]));
    let floor = Collider::plane([0.0, -0.3, 0.0], [0.0, 1.0, 0.0]);
    for warm_start in [true, false] {
        let ice = Ice { warm_start, ..second(newton(1)) };
        let scene =
            with(Scene::new("bits").time(0.01, 0.004).body(body.clone()).collider(floor.clone()), ice);
        let mut first = build(&scene);
        run(&mut first, 20);
        let snapshot = first.snapshot();
        let mut second = build(&scene);
        assert!(second.restore(&snapshot).is_ok());
        for simulation in [&mut first, &mut second] {
            run(simulation, 20);
        }
        assert_eq!(first.state_hash(), second.state_hash());
        // Of first order there is less to remember.
        let mut plain = build(&with(scene.clone(), Ice { warm_start, ..newton(1) }));
        assert!(matches!(plain.restore(&snapshot), Err(InputError::Snapshot(_))));
    }
}
