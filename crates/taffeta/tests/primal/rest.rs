//! What hangs settles where springs would, whatever the step, the number of Newton steps, and however few iterations.

use super::common::lists::grid_pairs;
use super::common::reference::Reference;
use super::common::{V, add, build, farthest, near, norm, positions, run, sub, turned};
use super::{accurate, chain, with};
use taffeta::Simulation;
use taffeta::scene::{Body, Ice, Keyframe, Mass, Mesh, Scene, Select};

const G: f64 = 9.81;

/// Runs until nothing moves.
fn settle(body: &Body, h: f64, ice: Ice) -> Simulation {
    let mut scene = with(Scene::new("rest").time(50.0 * h, h).body(body.clone()), ice);
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

/// Settings that must not matter.
fn ways() -> [(f64, Ice); 4] {
    let few = |newton_steps| Ice { max_iterations: 3, ..accurate(newton_steps) };
    [(0.004, accurate(1)), (0.016, accurate(2)), (0.004, few(1)), (0.016, few(1))]
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

#[test]
fn a_sheet_of_structural_springs_hangs_as_long_as_its_weight_makes_it_at_any_step() {
    // 34 rows at a step at which the form by springs is torn apart.
    let (mass, k) = (0.01, 1e5);
    let mut body = Body::cloth("sheet", Mesh::grid(34, 5, [4.0 / 33.0, 1.0])).with_mass(Mass::Node(mass));
    body = body.structural(k, 0.0).pin(Select::rows(0, 0));
    body.place = turned([1.0, 0.0, 0.0], 90.0, [0.0; 3]);
    for h in [0.004, 0.008, 0.016] {
        let x = positions(&settle(&body, h, accurate(1)));
        for (row, col) in (0..33).flat_map(|row| (0..5).map(move |col| (row, col))) {
            let stretch = x[5 * row + col][1] - x[5 * row + col + 5][1] - 1.0 / 33.0;
            near("pull", k * stretch, mass * G * (33.0 - row as f64), 1e-9);
        }
    }
}

/// Lowest point [m] below its ends, 0.8 m apart, of an elastic line of 1 m, 0.5 kg and a stiffness of 40 N.
fn sag() -> f64 {
    // Irvine, "Cable Structures", 1981, equations 2.24 and 2.25, with both ends at one height.
    let (weight, stiff, span) = (0.5 * G, 40.0, 0.8);
    let width = |pull: f64| pull / stiff + 2.0 * pull / weight * (weight / (2.0 * pull)).asinh();
    let [mut low, mut high] = [1e-6, 100.0];
    for _ in 0..200 {
        let pull = 0.5 * (low + high);
        *(if width(pull) < span { &mut low } else { &mut high }) = pull;
    }
    let pull: f64 = low;
    weight / (8.0 * stiff) + pull / weight * ((1.0 + (weight / (2.0 * pull)).powi(2)).sqrt() - 1.0)
}

#[test]
fn chains_of_more_and_more_links_come_to_the_elastic_catenary() {
    let off = [10_u32, 20, 40].map(|links| {
        let n = f64::from(links);
        let ends = vec![Keyframe::translate(0.2, [-0.2, 0.0, 0.0])];
        let body = chain(links, 1.0, 0.5 / n, [40.0 * n, 0.1]).pin(Select::nodes([0]));
        let body = body.pin_moving(Select::nodes([links]), ends);
        let x = positions(&settle(&body, 0.02, accurate(1)));
        near("span", x[links as usize][0] - x[0][0], 0.8, 1e-12);
        x[0][1] - x[links as usize / 2][1] - sag()
    });
    assert!(off[2].abs() < 1e-3, "{off:?}");
    // Masses at nodes are a sum by trapezoids: second order.
    near("order", (off[0] / off[1]).log2(), 2.0, 0.2);
    near("order", (off[1] / off[2]).log2(), 2.0, 0.2);
}

#[test]
fn newton_steps_change_nothing_at_rest() {
    let mut body = chain(30, 1.0, 0.01, [500.0, 0.1]).pin(Select::nodes([0, 30]));
    body.place = turned([0.0, 0.0, 1.0], 10.0, [0.0; 3]);
    let [one, three] = [1, 3].map(|steps| positions(&settle(&body, 0.016, accurate(steps))));
    let apart = farthest(&one, &three);
    assert!(apart < 1e-9, "{apart:e} m");
}
