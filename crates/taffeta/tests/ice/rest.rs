//! What hangs by constraints settles where springs would, whatever the step and however few iterations it gets.

use super::common::lists::grid_pairs;
use super::common::reference::Reference;
use super::common::{V, add, build, near, norm, positions, run, sub, turned};
use super::{accurate, chain, with_ice};
use taffeta::Simulation;
use taffeta::scene::{Body, Ice, Mass, Mesh, Scene, Select};

const G: f64 = 9.81;

/// Runs until nothing moves.
fn settle(body: &Body, h: f64, ice: Ice) -> Simulation {
    let mut scene = with_ice(Scene::new("rest").time(100.0 * h, h).body(body.clone()), ice);
    scene.world.drag = 0.2;
    let mut simulation = build(&scene);
    for _ in 0..500 {
        run(&mut simulation, 1);
        if simulation.report().kinetic < 1e-25 {
            return simulation;
        }
    }
    panic!("h = {h} s: still {:e} J after {} s", simulation.report().kinetic, simulation.report().time);
}

/// Settings that must not matter.
fn ways() -> [(f64, Ice); 4] {
    let few = |max_iterations| Ice { max_iterations, ..accurate() };
    [(0.004, accurate()), (0.016, accurate()), (0.004, few(6)), (0.016, few(6))]
}

#[test]
fn each_link_of_a_hanging_chain_pulls_with_the_weight_below() {
    let (links, mass) = (8, 0.02);
    for k in [50.0, 1e4, 1e6] {
        let mut body = chain(links, 0.8, mass, [k, 0.1]).pin(Select::nodes([0]));
        body.place = turned([0.0, 0.0, 1.0], -90.0, [0.0; 3]);
        for (h, ice) in ways() {
            let x = positions(&settle(&body, h, ice));
            for link in 0..links as usize {
                let stretch = norm(sub(x[link + 1], x[link])) - 0.1;
                let below = f64::from(links) - link as f64;
                near("pull", k * stretch, mass * G * below, 1e-15 * k + 1e-9 * mass * G);
            }
        }
    }
}

/// The largest force [N] left on a free node by springs and weight as the reference has them.
fn imbalance(places: Vec<V>, springs: &mut Reference, mass: f64) -> f64 {
    springs.x = places;
    let forces = springs.forces();
    let free = (0..springs.x.len()).filter(|n| !springs.held.contains(n));
    free.map(|n| norm(add(forces[n], [0.0, -mass * G, 0.0]))).fold(0.0, f64::max)
}

#[test]
fn a_sheet_that_hangs_by_two_corners_balances_as_springs_do() {
    let (mass, k) = (0.01, 300.0);
    let mut body =
        Body::cloth("sheet", Mesh::grid(9, 7, [0.6, 0.8])).with_mass(Mass::Node(mass)).structural(k, 0.1);
    body = body.shear(k, 0.1).bend(k, 0.1);
    body.place = turned([1.0, 0.1, 0.0], 80.0, [0.0; 3]);
    let mut springs =
        Reference::new(positions(&build(&Scene::new("start").body(body.clone()))), vec![mass; 63]);
    for (down, across) in [(0, 1), (1, 0), (1, 1), (0, 2), (2, 0)] {
        springs.join(grid_pairs(9, 7, down, across), [k, 0.0]);
    }
    springs.held.extend([0, 6]);
    let body = body.pin(Select::nodes([0, 6]));
    for (h, ice) in ways() {
        let left = imbalance(positions(&settle(&body, h, ice)), &mut springs, mass);
        assert!(left < 1e-8 * mass * G, "h = {h} s: {left:e} N of a node's {} N", mass * G);
    }
}
