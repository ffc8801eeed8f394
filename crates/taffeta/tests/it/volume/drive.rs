//! Pressures, targets that change, and weights.

use super::{ball, enclosed, error, ring};
use crate::common::{V, add, build, cross, dot, norm, positions, run, sub, surface, weightless};
use taffeta::scene::{Body, Cube, Icosphere, Mass, Mesh, Volume, VolumeForm, VolumeKey, VolumeWeights};

/// The gradient of a body's volume by each node's place [m²], found from the motion of nodes of 1 kg in one step of 1 s
/// under 1 Pa: x' − x = h² w p g. With the places, from which it was found.
pub fn gradients(mesh: Mesh, shift: V) -> (Vec<V>, Vec<V>, Vec<[u32; 3]>) {
    let mut body = Body::soft("gas", mesh).with_mass(Mass::Node(1.0)).at(shift);
    body.volume = Some(Volume { pressure: Some(1.0), ..Volume::default() });
    let mut simulation = build(&weightless("gradient", 1.0, 1.0).body(body));
    let before = positions(&simulation);
    run(&mut simulation, 1);
    let moved = positions(&simulation).iter().zip(&before).map(|(&a, &b)| sub(a, b)).collect();
    (moved, before, surface(&simulation, 0).triangles)
}

#[test]
fn gradients_are_those_of_finite_differences_and_add_up() {
    let meshes = [
        ball(2, VolumeForm::None).mesh,
        ring(VolumeForm::None).mesh,
        Mesh::Cube(Cube { size: 1.0, divisions: 3 }),
    ];
    for mesh in meshes {
        let (gradient, x, triangles) = gradients(mesh, [0.3, -0.2, 0.1]);
        check_gradients(&gradient, &x, &triangles);
    }
}

/// Against differences of V, which is of third degree in all places and so of first in each: exact but for rounding.
pub fn check_gradients(gradient: &[V], x: &[V], triangles: &[[u32; 3]]) {
    let largest = gradient.iter().map(|&g| norm(g)).fold(0.0, f64::max);
    let step = 0.1;
    for node in 0..x.len() {
        for axis in 0..3 {
            let moved = |by: f64| {
                let mut y = x.to_vec();
                y[node][axis] += by;
                enclosed(&y, triangles)
            };
            let slope = (moved(step) - moved(-step)) / (2.0 * step);
            let apart = (slope - gradient[node][axis]).abs();
            assert!(apart < 1e-8 * largest, "node {node}, axis {axis}: {slope} {}", gradient[node][axis]);
        }
    }
    let sum = gradient.iter().copied().fold([0.0; 3], add);
    assert!(norm(sum) < 1e-12 * largest * x.len() as f64, "{sum:?}");
    let three: f64 = gradient.iter().zip(x).map(|(&g, &x)| dot(g, x)).sum();
    let volume = enclosed(x, triangles);
    assert!((three / 3.0 / volume - 1.0).abs() < 1e-12, "{three} {volume}");
}

#[test]
fn a_pressure_pushes_each_face_of_a_cube_with_its_area() {
    let (moved, x, _) = gradients(Mesh::Cube(Cube { size: 2.0, divisions: 4 }), [0.0; 3]);
    for axis in 0..3 {
        let on_face = |side: f64| -> V {
            let there = x.iter().zip(&moved).filter(|(x, _)| (x[axis] - side).abs() < 1e-9);
            there.map(|(_, &g)| g).fold([0.0; 3], add)
        };
        for side in [-1.0, 1.0] {
            assert!((on_face(side)[axis] - side * 4.0).abs() < 1e-12, "{axis} {side}");
        }
    }
}

#[test]
fn a_ball_under_pressure_comes_to_rest_where_springs_balance_it() {
    // All nodes of an icosahedron move alike: p dV/dr = 30 k (l − L) dl/dr, with V = ν r³ and l = c r.
    let (radius, k): (f64, f64) = (0.5, 200.0);
    let c = 1.0 / (0.4 * std::f64::consts::PI).sin();
    let nu = 5.0 / 12.0 * (3.0 + 5.0_f64.sqrt()) * c.powi(3);
    for pressure in [50.0, 150.0, -40.0] {
        let mesh = Mesh::Icosphere(Icosphere { radius, subdivisions: 0 });
        let mut body = Body::soft("ball", mesh).with_mass(Mass::Node(0.1)).structural(k, 1.0);
        body.volume = Some(Volume { pressure: Some(pressure), ..Volume::default() });
        let mut simulation = build(&weightless("balance", 0.01, 0.002).body(body.at([3.0, 0.0, 1.0])));
        run(&mut simulation, 600);
        // 3 p ν r² − 30 k c² (r − R) = 0: the smaller root.
        let (a, b) = (3.0 * pressure * nu, 30.0 * k * c * c);
        let r = (b - (b * b - 4.0 * a * b * radius).sqrt()) / (2.0 * a);
        let volume = simulation.report().volumes[0].unwrap();
        assert!((volume / (nu * r.powi(3)) - 1.0).abs() < 1e-9, "{pressure} Pa: {volume}, r = {r}");
        assert!((r / radius - 1.0) / pressure > 4e-4, "it gives way: {r}");
        assert!(simulation.report().kinetic < 1e-12);
    }
}

#[test]
fn a_pressure_follows_its_keys() {
    // No springs: the speed is the pressure's integral over time, A/M times that, for a short while.
    let mut body =
        Body::soft("gas", Mesh::Cube(Cube { size: 1.0, divisions: 1 })).with_mass(Mass::Whole(1e3));
    let key = |t, pressure| VolumeKey { t, target: None, pressure: Some(pressure) };
    let motion = vec![key(0.1, 3.0), key(0.2, -1.0)];
    body.volume = Some(Volume { pressure: Some(1.0), motion, ..Volume::default() });
    let mut simulation = build(&weightless("keys", 0.01, 0.0001).body(body));
    let gone = |simulation: &taffeta::Simulation| (2.0 * simulation.report().kinetic).sqrt();
    run(&mut simulation, 10);
    let at_first = gone(&simulation);
    run(&mut simulation, 10);
    // ∫ = 0.2 Pa·s, then 0.1 Pa·s more.
    let ratio = gone(&simulation) / at_first;
    assert!((ratio - 1.5).abs() < 1e-2, "{ratio}");
}

#[test]
fn a_volume_follows_its_keyframes() {
    let key = |t, target| VolumeKey { t, target: Some(target), pressure: None };
    for form in [VolumeForm::Corrected, VolumeForm::Projected] {
        for mut body in [ball(2, form), ring(form)] {
            body.springs.structural = Some(taffeta::scene::Spring { k: 20.0, d: 0.1 });
            let motion = vec![key(0.5, 1.5), key(0.7, 1.5), key(1.2, 0.6)];
            body.volume = Some(Volume { form, motion, ..Volume::default() });
            let mut simulation = build(&weightless("keys", 0.01, 0.001).body(body));
            let rest = simulation.report().volumes[0].unwrap();
            let mut worst = 0.0_f64;
            for _ in 0..140 {
                run(&mut simulation, 1);
                worst = worst.max(error(&simulation).abs());
            }
            assert!(worst < if form == VolumeForm::Projected { 1e-9 } else { 1e-3 }, "{form:?}: {worst:e}");
            let target = simulation.report().volume_targets[0].unwrap();
            assert!((target / rest - 0.6).abs() < 1e-12);
            assert!(simulation.report().springs > 0.1, "the springs have something to say");
        }
    }
}

#[test]
fn outside_of_the_weights_a_body_keeps_its_shape_and_all_of_it_its_momentum() {
    // A bump of 2 % on a ring without springs, off its axes, so that the rigid motion taken away shifts and turns.
    let mut body = ring(VolumeForm::Corrected);
    body.springs.structural = None;
    let weights = VolumeWeights { center: [0.6, 0.15, 0.2], radius: 0.3 };
    let motion = vec![VolumeKey { t: 0.1, target: Some(1.02), pressure: None }];
    body.volume = Some(Volume { motion, weights: Some(weights), ..Volume::default() });
    let mut simulation = build(&weightless("bump", 0.01, 0.001).body(body));
    let before = positions(&simulation);
    run(&mut simulation, 10);
    let after = positions(&simulation);
    assert!(error(&simulation).abs() < 1e-4);
    let report = simulation.report();
    let momenta = norm(report.momentum) + norm(report.angular_momentum);
    assert!(momenta < 1e-12, "{momenta:e}");
    let is_outside = |&n: &usize| norm(sub(before[n], weights.center)) > weights.radius;
    let (outside, inside): (Vec<usize>, Vec<usize>) = (0..before.len()).partition(is_outside);
    assert!(outside.len() > 300 && inside.len() > 20);
    let far = outside[0];
    let apart = |x: &[V], a: usize, b: usize| sub(x[a], x[b]);
    let stretch = |a: usize, b: usize| (norm(apart(&after, a, b)) / norm(apart(&before, a, b)) - 1.0).abs();
    let pairs = outside.iter().flat_map(|&a| outside.iter().step_by(7).map(move |&b| (a, b)));
    let changed = pairs.filter(|(a, b)| a != b).map(|(a, b)| stretch(a, b)).fold(0.0, f64::max);
    let bump = inside.iter().map(|&n| stretch(n, far)).fold(0.0, f64::max);
    let turned = outside[1..].iter().map(|&n| {
        let [was, is] = [&before, &after].map(|x| apart(x, n, far));
        norm(cross(was, is)) / dot(was, was)
    });
    let turned = turned.fold(0.0, f64::max);
    // Nodes that turn without springs go straight on: that is of second order in the angle.
    assert!(bump > 0.01 && turned > 1e-3, "{bump:e} {turned:e}");
    assert!(changed < turned * turned, "{changed:e}, {turned:e}");
}
