//! Single nodes and springs, whose motion symplectic Euler gives in closed form or by a scalar recurrence.

use crate::common::{build, build_as, near, positions, run, weightless};
use taffeta::scene::{Body, Bounds, Force, Keyframe, Mass, Mesh, Scene, Select};
use taffeta::{Precision, Simulation};

/// A node of 1 kg on a link of 1 m and `k` = 100 N/m, its other end held at the origin. Released unstretched under
/// 10 m/s² along the link it swings about m g/k = 0.1 m, as one displaced by −0.1 m does without gravity.
fn oscillator(damping: f64, precision: Precision, h: f64) -> Simulation {
    let mut scene = weightless("oscillator", h, h).body(
        Body::cloth("chain", Mesh::chain(1, 1.0))
            .at([0.5, 0.0, 0.0])
            .with_mass(Mass::Node(1.0))
            .structural(100.0, damping)
            .pin(Select::nodes([0])),
    );
    scene.world.gravity = [10.0, 0.0, 0.0];
    build_as(&scene, precision, 1)
}

/// Displacement from equilibrium [m] and velocity [m/s] of the node, the way round that starts at +0.1 m.
fn swing(simulation: &Simulation) -> [f64; 2] {
    [1.1 - positions(simulation)[1][0], -simulation.report().momentum[0]]
}

#[test]
fn an_oscillator_is_after_1000_steps_where_the_recurrence_has_it() {
    for (damping, u, v) in [(0.0, -0.0836328546, 0.544062873), (2.0, -0.0334828762, 0.1868436927)] {
        let mut simulation = oscillator(damping, Precision::F64, 1e-3);
        run(&mut simulation, 1000);
        let [got_u, got_v] = swing(&simulation);
        near("u", got_u, u, 1e-10);
        near("v", got_v, v, 1e-9);
    }
}

#[test]
fn an_oscillator_follows_the_scalar_recurrence_at_every_step() {
    for damping in [0.0, 2.0, 15.0] {
        let mut simulation = oscillator(damping, Precision::F64, 0.01);
        let (mut u, mut v) = (0.1, 0.0);
        for _ in 0..500 {
            v += 0.01 * (-100.0 * u - damping * v);
            u += 0.01 * v;
            run(&mut simulation, 1);
            let [got_u, got_v] = swing(&simulation);
            near("u", got_u, u, 1e-13);
            near("v", got_v, v, 1e-12);
        }
    }
}

#[test]
fn an_oscillator_in_32_bits_stays_within_a_thousandth_of_its_amplitude() {
    let mut simulation = oscillator(0.0, Precision::F32, 1e-3);
    run(&mut simulation, 1000);
    let [u, v] = swing(&simulation);
    near("u", u, -0.0836328546, 1e-4);
    near("v", v, 0.544062873, 1e-3);
}

#[test]
fn an_undamped_oscillator_keeps_the_energy_that_symplectic_euler_keeps() {
    // The step map leaves ½ m v² + ½ k u² − ½ h k u v unchanged.
    let h = 0.01;
    let mut simulation = oscillator(0.0, Precision::F64, h);
    for _ in 0..2000 {
        run(&mut simulation, 1);
        let [u, v] = swing(&simulation);
        near("shadow energy", 0.5 * v * v + 50.0 * u * u - 50.0 * h * u * v, 0.5, 1e-11);
    }
}

fn loose(drag: f64, mass: f64, h: f64, substeps: u32) -> Scene {
    let body = Body::cloth("loose", Mesh::grid(3, 5, [1.0, 0.5])).with_mass(Mass::Node(mass));
    let mut scene = Scene::new("fall").time(f64::from(substeps) * h, h).body(body);
    scene.world.drag = drag;
    scene
}

#[test]
fn free_fall_drops_what_symplectic_euler_drops() {
    // g h² n (n + 1)/2 with n = 400 steps of 5 ms.
    let mut simulation = build(&loose(0.0, 0.2, 0.005, 8));
    let start = positions(&simulation);
    run(&mut simulation, 50);
    for (from, to) in start.iter().zip(positions(&simulation)) {
        near("drop", from[1] - to[1], 19.66905, 1e-11);
        assert_eq!([from[0], from[2]], [to[0], to[2]]);
    }
    near("momentum", simulation.report().momentum[1], -19.62 * 3.0, 1e-10);
    near("energy gained", simulation.report().energy(), 3.0 * (0.5 * 19.62 * 19.62 - 9.81 * 19.66905), 1e-9);
}

#[test]
fn free_fall_in_32_bits_drops_the_same_within_a_few_roundings_a_step() {
    let mut simulation = build_as(&loose(0.0, 0.2, 0.005, 8), Precision::F32, 2);
    run(&mut simulation, 50);
    // 400 roundings of up to half an ulp of 16 m.
    near("drop", -positions(&simulation)[7][1], 19.66905, 400.0 * 0.5 * 16.0 * f64::from(f32::EPSILON));
}

#[test]
fn drag_brings_a_falling_node_to_its_limit() {
    // v = v∞ (1 − (1 − c h/m)ⁿ), v∞ = −m g/c.
    let mut simulation = build(&loose(0.5, 0.1, 0.005, 10));
    run(&mut simulation, 20);
    let speed = |simulation: &Simulation| simulation.report().momentum[1] / 1.5;
    near("v", speed(&simulation), -1.962 * (1.0 - 0.975_f64.powi(200)), 1e-12);
    near("v", speed(&simulation), -1.94959, 1e-5);
    run(&mut simulation, 300);
    near("limit", speed(&simulation), -1.962, 1e-12);
}

#[test]
fn a_constant_wind_force_brings_nodes_to_the_speed_at_which_drag_balances_it() {
    let mut scene = loose(0.25, 0.1, 0.005, 10);
    scene.world.gravity = [0.0; 3];
    scene.world.wind_force = [0.5, 0.0, -1.0];
    let mut simulation = build(&scene);
    run(&mut simulation, 400);
    let momentum = simulation.report().momentum;
    for (axis, limit) in [2.0, 0.0, -4.0].into_iter().enumerate() {
        near("v", momentum[axis] / 1.5, limit, 1e-11);
    }
}

#[test]
fn a_frame_takes_its_last_step_short() {
    // 34 steps in 1/30 s: 33 of 1 ms and one of 1/3 ms; x gains h v after each.
    let mut simulation =
        build(&Scene { time: Scene::new("").time(1.0 / 30.0, 1e-3).time, ..loose(0.0, 1.0, 1.0, 1) });
    let (mut x, mut v) = (0.0, 0.0);
    for step in 0..68 {
        let h = if step % 34 == 33 { 1.0 / 30.0 - 0.033 } else { 1e-3 };
        v -= h * 9.81;
        x += h * v;
    }
    run(&mut simulation, 2);
    near("drop", positions(&simulation)[0][1], x, 1e-14);
    near("time", simulation.report().time, 2.0 / 30.0, 1e-16);
}

#[test]
fn selections_see_a_body_as_placed_whatever_moves_its_pins_at_the_start() {
    // Row 0 lies at z = −1 and starts 5 m higher; both boxes, and the load's, are about where it was placed.
    let row = Bounds { min: [-9.0, -0.1, -1.1], max: [9.0, 0.1, -0.9] };
    let boxed = || Select { inside: Some(row), ..Select::default() };
    let up = vec![Keyframe::translate(0.0, [0.0, 5.0, 0.0])];
    let body = Body::cloth("sheet", Mesh::grid(3, 3, [2.0, 2.0]))
        .with_mass(Mass::Node(0.1))
        .pin_moving(boxed(), up)
        .pin_moving(boxed(), vec![Keyframe::translate(0.0, [3.0, 0.0, 0.0])]);
    let load = Force { body: "sheet".into(), select: boxed(), force: Some([1.0; 3]), ..Force::default() };
    let simulation = build(&weightless("", 0.01, 0.01).body(body).force(load));
    let places = positions(&simulation);
    assert_eq!(places[..3], [[2.0, 0.0, -1.0], [3.0, 0.0, -1.0], [4.0, 0.0, -1.0]], "the last motion counts");
    assert_eq!(places[3], [-1.0, 0.0, 0.0]);
}
