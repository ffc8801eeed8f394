//! What hangs settles where springs would, whatever settings it has.

use super::alike::{chain, with_ice};
use super::lists::grid_pairs;
use super::reference::Reference;
use super::{V, add, build, near, norm, positions, run, sub, turned};
use taffeta::Simulation;
use taffeta::scene::{Body, Ice, Mass, Mesh, Scene, Select};

pub const G: f64 = 9.81;

/// Runs until nothing moves.
pub fn settle(body: &Body, h: f64, ice: Ice) -> Simulation {
    let mut scene = with_ice(Scene::new("rest").time(50.0 * h, h).body(body.clone()), ice);
    scene.world.drag = 0.2;
    let mut simulation = build(&scene);
    for _ in 0..1000 {
        run(&mut simulation, 1);
        if simulation.report().kinetic < 1e-25 {
            return simulation;
        }
    }
    panic!("h = {h} s: still {:e} J after {} s", simulation.report().kinetic, simulation.report().time);
}

/// Each link of a hanging chain pulls with the weight below it.
pub fn chain_by_its_weight(ways: &[(f64, Ice)]) {
    let (links, mass) = (8, 0.02);
    for k in [50.0, 1e4, 1e6] {
        let mut body = chain(links, 0.8, mass, [k, 0.1]).pin(Select::nodes([0]));
        body.place = turned([0.0, 0.0, 1.0], -90.0, [0.0; 3]);
        for (h, ice) in ways {
            let x = positions(&settle(&body, *h, ice.clone()));
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

/// A sheet that hangs by two corners balances as springs do.
pub fn sheet_in_balance(ways: &[(f64, Ice)]) {
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
    for (h, ice) in ways {
        let left = imbalance(positions(&settle(&body, *h, ice.clone())), &mut springs, mass);
        assert!(left < 1e-8 * mass * G, "h = {h} s: {left:e} N of a node's {} N", mass * G);
    }
}
