//! Still air takes energy, and never gives any.

use super::{AIR, STILL, blown, loose};
use crate::common::state::{any, noise, set, state};
use crate::common::{add, build, run, scale};
use taffeta::scene::{Air, Body, Icosphere, Mass, Mesh};

#[test]
fn still_air_leaves_cloth_at_rest_where_it_is() {
    let mut simulation = build(&blown(loose(6, 7), STILL, 0.01));
    let before = state(&simulation);
    run(&mut simulation, 20);
    assert_eq!(before, state(&simulation));
}

/// Sheets and a ball, of one mass a square metre and of one mass a node.
fn bodies() -> Vec<Body> {
    let ball = Mesh::Icosphere(Icosphere { radius: 0.3, subdivisions: 2 });
    let [grid, sliver] = [Mesh::grid(6, 7, [0.5, 0.4]), Mesh::grid(2, 9, [0.5, 0.01])];
    let masses = [Mass::Area(0.3), Mass::Area(1e-3), Mass::Node(0.01), Mass::Node(1e-6)];
    let all = [ball, grid, sliver].into_iter().flat_map(|mesh| masses.map(|mass| (mesh.clone(), mass)));
    all.map(|(mesh, mass)| Body::cloth("body", mesh).with_mass(mass)).collect()
}

#[test]
fn still_air_only_takes_energy_at_any_step() {
    for body in bodies() {
        for h in [1e-5, 1e-3, 0.02, 1.0, 100.0] {
            let mut simulation = build(&blown(body.clone(), STILL, h));
            let mut random = noise(9);
            let (x, _) = state(&simulation);
            let v: Vec<_> = x.iter().map(|_| scale(any(&mut random), 10.0)).collect();
            let x: Vec<_> = x.iter().map(|x| add(*x, scale(any(&mut random), 0.05))).collect();
            set(&mut simulation, &x, &v);
            simulation.disturb(0.0, 1);
            let mut before = simulation.report().kinetic;
            assert!(before > 0.0);
            for _ in 0..20 {
                run(&mut simulation, 1);
                let now = simulation.report().kinetic;
                assert!(now < before, "{h} s, {:?}: {before} J, then {now} J", body.mesh);
                before = now;
            }
        }
    }
}

#[test]
fn a_triangle_that_is_stopped_is_not_thrown_back() {
    for h in [1e-3, 0.1, 10.0] {
        let mut simulation = build(&blown(loose(2, 2).with_mass(Mass::Area(1e-4)), STILL, h));
        let (x, _) = state(&simulation);
        set(&mut simulation, &x, &[[0.0, -20.0, 0.0]; 4]);
        let mut before = -20.0;
        for _ in 0..50 {
            run(&mut simulation, 1);
            let (_, v) = state(&simulation);
            assert!(v.iter().all(|v| v[1] <= 0.0 && v[1] >= before), "{h} s: {v:?}");
            before = v[0][1];
        }
    }
}

#[test]
fn light_cloth_in_a_gale_is_carried_along_and_no_faster_at_a_long_step() {
    let gale = Air { velocity: [0.0, 25.0, 0.0], ..AIR };
    let mut simulation = build(&blown(loose(8, 9).with_mass(Mass::Area(0.005)), gale, 1.0 / 30.0));
    let mut before = 0.0;
    for _ in 0..300 {
        run(&mut simulation, 1);
        let speed = simulation.report().momentum[1] / (0.005 * 0.2);
        assert!(speed >= before - 1e-12 && speed <= 25.0, "{before} m/s, then {speed}");
        before = speed;
    }
    assert!(before > 24.5, "{before}");
}
