//! What hangs settles where its forces balance, by statics worked out apart from the engine.

use crate::common::lists::{edges, grid_pairs, shared_edges};
use crate::common::reference::Reference;
use crate::common::{V, add, build, farthest, near, norm, positions, run, scale, sub, surface, turned};
use taffeta::Simulation;
use taffeta::scene::{Body, Cylinder, Keyframe, Mass, Mesh, Scene, Select, Spring};

const G: f64 = 9.81;

/// Damped by drag, in frames of half a second.
fn settling(body: Body, drag: f64, step: f64) -> Scene {
    let mut scene = Scene::new("statics").time(0.5, step).body(body);
    scene.world.drag = drag;
    scene
}

/// Runs until nothing moves.
fn settle(scene: &Scene) -> Simulation {
    let mut simulation = build(scene);
    for _ in 0..400 {
        run(&mut simulation, 1);
        if simulation.report().kinetic < 1e-26 {
            return simulation;
        }
    }
    panic!("still {:e} J after {} s", simulation.report().kinetic, simulation.report().time);
}

/// Ends of the links of a chain that hangs with the pull `h` [N] to either side, from node 0, in the xy plane.
fn catenary(links: usize, rest: f64, k: f64, weight: f64, h: f64) -> Vec<V> {
    let mut x = vec![[0.0; 3]];
    for link in 0..links {
        // Each half carries the weights between it and the middle.
        let v = weight * ((links - 1) as f64 / 2.0 - link as f64);
        let tension = h.hypot(v);
        let length = rest + tension / k;
        x.push(add(x[link], scale([h, -v, 0.0], length / tension)));
    }
    x
}

#[test]
fn a_chain_hangs_in_its_elastic_catenary() {
    for (links, k, span) in [(20, 400.0, 0.7), (21, 60.0, 1.0), (8, 2000.0, 0.25)] {
        let (mass, rest) = (0.02, 1.0 / f64::from(links));
        // The right end moves inwards to the span within the first half second.
        let ends = [Select::nodes([0]), Select::nodes([links])];
        let [left, right] = ends;
        let body = Body::cloth("chain", Mesh::chain(links, 1.0))
            .at([0.5, 0.0, 0.0])
            .with_mass(Mass::Node(mass))
            .structural(k, 0.0)
            .pin(left)
            .pin_moving(right, vec![Keyframe::translate(0.5, [span - 1.0, 0.0, 0.0])]);
        let simulation = settle(&settling(body, 0.2, 1e-3));
        // The span grows with the pull: halve the range of pulls.
        let (mut low, mut high) = (1e-9, 100.0);
        for _ in 0..200 {
            let h = 0.5 * (low + high);
            let at = catenary(links as usize, rest, k, mass * G, h)[links as usize][0];
            *(if at < span { &mut low } else { &mut high }) = h;
        }
        let expected = catenary(links as usize, rest, k, mass * G, low);
        let apart = farthest(&positions(&simulation), &expected);
        assert!(apart < 1e-9, "{links} links: {apart:e} m");
    }
}

#[test]
fn each_spring_of_a_hanging_strip_stretches_by_the_weights_below_over_k() {
    let (n, mass, k) = (25, 0.02, 300.0);
    for cols in [1, 6] {
        let mut body = Body::cloth("strip", Mesh::grid(n, cols, [0.2 * f64::from(cols - 1), 1.2]));
        body = body.with_mass(Mass::Node(mass)).structural(k, 0.1).pin(Select::rows(0, 0));
        body.place = turned([1.0, 0.0, 0.0], 90.0, [0.0; 3]);
        let simulation = settle(&settling(body, 0.15, 1e-3));
        let x = positions(&simulation);
        let mut longest = 0.0_f64;
        for col in 0..cols as usize {
            for row in 0..n as usize - 1 {
                let [upper, lower] = [row, row + 1].map(|r| x[r * cols as usize + col]);
                let below = f64::from(n) - 1.0 - row as f64;
                near("length", upper[1] - lower[1], 0.05 + mass * G * below / k, 1e-11);
                longest = longest.max((upper[1] - lower[1]) / 0.05);
            }
        }
        near("largest stretch", simulation.report().max_stretch, longest, 1e-12);
    }
}

/// The largest force [N] left on a free node by springs and weight as the reference has them.
fn imbalance(simulation: &Simulation, mut springs: Reference, mass: f64) -> f64 {
    springs.x = positions(simulation);
    let weight = [0.0, -mass * G, 0.0];
    let free = (0..springs.x.len()).filter(|n| !springs.held.contains(n));
    let forces = springs.forces();
    free.map(|n| norm(add(forces[n], weight))).fold(0.0, f64::max)
}

#[test]
fn hanging_sheets_balance_with_every_combination_of_springs() {
    let (rows, cols, mass) = (9, 7, 0.01);
    for kinds in 0..4 {
        for pins in [Select::rows(0, 0), Select::nodes([0, 6])] {
            let spring = |k| Some(Spring { k, d: 0.02 });
            let mut body =
                Body::cloth("sheet", Mesh::grid(rows, cols, [0.6, 0.9])).with_mass(Mass::Node(mass));
            body.springs.structural = spring(90.0);
            body.springs.shear = if kinds & 1 > 0 { spring(40.0) } else { None };
            body.springs.bend = if kinds & 2 > 0 { spring(25.0) } else { None };
            body.place = turned([1.0, 0.1, 0.0], 80.0, [0.0; 3]);
            let start = build(&settling(body.clone(), 0.05, 1e-3));
            let simulation = settle(&settling(body.clone().pin(pins.clone()), 0.05, 1e-3));
            let mut springs = Reference::new(positions(&start), vec![mass; 63]);
            for (down, across, k) in [
                (0, 1, body.springs.structural),
                (1, 0, body.springs.structural),
                (1, 1, body.springs.shear),
                (0, 2, body.springs.bend),
                (2, 0, body.springs.bend),
            ] {
                if let Some(Spring { k, .. }) = k {
                    springs.join(grid_pairs(9, 7, down, across), [k, 0.0]);
                }
            }
            springs.held.extend(if pins.rows.is_some() { (0..7).collect() } else { vec![0, 6] });
            let left = imbalance(&simulation, springs, mass);
            assert!(left < 1e-9 * mass * G, "springs {kinds}: {left:e} N of a node's {} N", mass * G);
        }
    }
}

#[test]
fn a_hanging_tube_balances_with_bend_springs_and_hinges() {
    let tube = Cylinder { radius: 0.2, height: 0.8, segments: 10, rings: 6, capped: false };
    let mut body = Body::cloth("tube", Mesh::Cylinder(tube)).with_mass(Mass::Node(0.01));
    body = body.structural(120.0, 0.02).bend(40.0, 0.01).hinge(0.01, 1e-4);
    let start = build(&settling(body.clone(), 0.05, 5e-4));
    let (x, triangles) = (positions(&start), surface(&start, 0).triangles);
    let top = x.iter().map(|x| x[1]).fold(f64::MIN, f64::max);
    // Three nodes of the upper rim hold it, so that it is bent as well as stretched.
    let rim: Vec<u32> = (0..70).filter(|&n| x[n as usize][1] > top - 1e-9).step_by(4).collect();
    let simulation = settle(&settling(body.pin(Select::nodes(rim.clone())), 0.05, 5e-4));
    let mut springs = Reference::new(x, vec![0.01; 70]);
    springs.join(edges(&triangles), [120.0, 0.0]);
    springs.join(shared_edges(&triangles).into_iter().map(|[_, _, c, d]| [c, d]), [40.0, 0.0]);
    springs.hinge(&triangles, [0.01, 0.0]);
    springs.held.extend(rim.into_iter().map(|n| n as usize));
    let left = imbalance(&simulation, springs, 0.01);
    assert!(left < 1e-8 * 0.01 * G, "{left:e} N");
    assert!(simulation.report().energy_of("hinges") > 1e-6, "bent");
}

#[test]
fn the_pull_on_the_pins_is_the_weight() {
    // What the reference's springs pull down at the held nodes, at rest.
    let body =
        Body::cloth("sheet", Mesh::grid(6, 6, [0.5, 0.5])).with_mass(Mass::Node(0.02)).structural(80.0, 0.02);
    let start = build(&settling(body.clone(), 0.1, 1e-3));
    let simulation = settle(&settling(body.pin(Select::nodes([0, 5, 35])), 0.1, 1e-3));
    let mut springs = Reference::new(positions(&start), vec![0.02; 36]);
    springs.join(grid_pairs(6, 6, 0, 1).into_iter().chain(grid_pairs(6, 6, 1, 0)), [80.0, 0.0]);
    springs.x = positions(&simulation);
    let pull = [0, 5, 35].into_iter().fold([0.0; 3], |sum, n| add(sum, springs.forces()[n]));
    let weight = [0.0, -33.0 * 0.02 * G, 0.0];
    assert!(norm(sub(pull, weight)) < 1e-8, "{pull:?}");
}
