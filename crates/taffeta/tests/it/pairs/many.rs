//! Many nodes: what is kept.

use super::{cloud, random, set_velocities, touch, velocities};
use crate::common::{V, add, build_as, cross, norm, positions, run, scale, sub, weightless};
use taffeta::scene::{Collider, Scene, SelfCollision};
use taffeta::{Precision, Simulation};

const MASS: f64 = 0.01;

/// `n` nodes in a cube of `edge` [m], up to `fastest` [m/s] along each axis.
fn gas(
    n: usize,
    (edge, fastest): (f64, f64),
    how: SelfCollision,
    mut scene: Scene,
    precision: Precision,
) -> Simulation {
    let mut number = random(5);
    let x: Vec<V> = (0..n).map(|_| std::array::from_fn(|_| edge * number())).collect();
    let v: Vec<V> = (0..n).map(|_| std::array::from_fn(|_| fastest * (2.0 * number() - 1.0))).collect();
    scene = scene.body(cloud("gas", &x, MASS, how));
    let mut simulation = build_as(&scene, precision, 1);
    set_velocities(&mut simulation, &v);
    simulation
}

/// Momentum [kg·m/s], angular momentum [kg·m²/s] about a place, and kinetic energy [J], of as many nodes.
fn moments(simulation: &Simulation, n: usize, about: V) -> (V, V, f64) {
    let (x, v) = (positions(simulation), velocities(simulation));
    let mut sums = ([0.0; 3], [0.0; 3], 0.0);
    for (&x, &v) in x[..n].iter().zip(&v) {
        let p = scale(v, MASS);
        sums = (add(sums.0, p), add(sums.1, cross(sub(x, about), p)), sums.2 + 0.5 * norm(v) * norm(p));
    }
    sums
}

#[test]
fn a_cloud_keeps_its_momentum_to_rounding() {
    for (precision, most) in [(Precision::F64, 1e-13), (Precision::F32, 2e-5)] {
        for e in [0.0, 0.4, 1.0] {
            let scene = weightless("cloud", 0.004, 0.001);
            let mut simulation = gas(300, (0.5, 2.0), touch(0.1, 0.4, e), scene, precision);
            let (before, ..) = moments(&simulation, 300, [0.0; 3]);
            let mut pairs = 0;
            for _ in 0..15 {
                run(&mut simulation, 1);
                pairs += simulation.report().pairs;
            }
            let (after, ..) = moments(&simulation, 300, [0.0; 3]);
            assert!(pairs > 2000, "{pairs}");
            let off = norm(sub(after, before)) / (300.0 * MASS * 2.0);
            assert!(off < most, "{precision}, e = {e}: {off:e}");
        }
    }
}

#[test]
fn a_cloud_that_bounces_without_friction_keeps_its_angular_momentum() {
    // A turning lattice of nodes that are apart at first: nothing is pushed without an impact.
    let mut number = random(3);
    let x: Vec<V> = (0..216).map(|i| [i % 6, i / 6 % 6, i / 36].map(|k| 0.1 * f64::from(k) - 0.25)).collect();
    let v: Vec<V> = (x.iter())
        .map(|&x| add(cross([0.5, 2.0, -1.0], x), std::array::from_fn(|_| 4.0 * number() - 2.0)))
        .collect();
    let scene = weightless("lattice", 0.004, 0.0005).body(cloud("gas", &x, MASS, touch(0.04, 0.0, 1.0)));
    let mut simulation = build_as(&scene, Precision::F64, 1);
    set_velocities(&mut simulation, &v);
    let (_, before, energy) = moments(&simulation, 216, [0.0; 3]);
    let mut pairs = 0;
    for _ in 0..25 {
        run(&mut simulation, 1);
        pairs += simulation.report().pairs;
    }
    let (_, after, left) = moments(&simulation, 216, [0.0; 3]);
    assert!(pairs > 10, "{pairs}");
    assert!(norm(sub(after, before)) < 1e-12 * norm(before), "{before:?} {after:?}");
    // Where three meet at once some is lost.
    assert!(left <= energy * (1.0 + 1e-12) && left > 0.9 * energy, "{energy} {left}");
}

/// A floor and four walls around a square of `edge` [m].
fn in_box(scene: Scene, edge: f64, e: f64) -> Scene {
    let wall = |point: V, normal: V| Collider::plane(point, normal).offset(0.0).friction(0.0).restitution(e);
    scene
        .collider(wall([0.0; 3], [0.0, 1.0, 0.0]))
        .collider(wall([0.0; 3], [1.0, 0.0, 0.0]))
        .collider(wall([0.0; 3], [0.0, 0.0, 1.0]))
        .collider(wall([edge, 0.0, 0.0], [-1.0, 0.0, 0.0]))
        .collider(wall([0.0, 0.0, edge], [0.0, 0.0, -1.0]))
}

#[test]
fn a_pile_gains_no_energy() {
    for (e, friction) in [(1.0, 0.0), (1.0, 0.5), (0.5, 0.2), (0.0, 0.2), (0.0, 0.0)] {
        let scene = in_box(Scene::new("pile").time(0.02, 0.001), 0.5, e);
        let mut simulation = gas(100, (0.5, 1.0), touch(0.08, friction, e), scene, Precision::F64);
        run(&mut simulation, 1);
        let start = simulation.report().energy();
        // Mean of ten frames each: kinetic and potential energy are half a step apart.
        let mut least = f64::INFINITY;
        for _ in 0..30 {
            let mut mean = 0.0;
            for _ in 0..10 {
                run(&mut simulation, 1);
                mean += 0.1 * simulation.report().energy();
            }
            assert!(mean < least + 1e-3 * start, "e = {e}, μ = {friction}: {least} J to {mean} J");
            least = least.min(mean);
        }
        assert!(least < 0.5 * start, "{start} {least}");
    }
}

#[test]
fn a_thousand_nodes_at_one_place_come_apart_evenly() {
    for (precision, e) in [(Precision::F64, 0.0), (Precision::F64, 1.0), (Precision::F32, 0.0)] {
        let mut number = random(2);
        // Half of them exactly at one place, half within a tenth of the thickness.
        let x: Vec<V> = (0..1000)
            .map(|i| std::array::from_fn(|_| if i < 500 { 0.0 } else { 0.01 * (number() - 0.5) }))
            .collect();
        let scene = weightless("crowd", 0.005, 0.001).body(cloud("crowd", &x, MASS, touch(0.1, 0.3, e)));
        let mut simulation = build_as(&scene, precision, 1);
        run(&mut simulation, 2);
        let (p, l, _) = moments(&simulation, 1000, [0.0; 3]);
        let fastest = velocities(&simulation).into_iter().map(norm).fold(0.0, f64::max);
        let widest = positions(&simulation)[..1000].iter().map(|&x| norm(x)).fold(0.0, f64::max);
        assert!(simulation.report().pairs > 100_000, "{}", simulation.report().pairs);
        assert!(norm(p) < 1e-4 && norm(l) < 1e-3, "{p:?} {l:?}");
        // Two of them part at 0.1 m in 0.02 s; many may add up to a little more.
        assert!(fastest < 10.0 && (0.005..0.2).contains(&widest), "{fastest} {widest}");
    }
}
