//! The largest step of springs in air.

use super::blown;
use crate::common::{build, positions, run};
use std::sync::Arc;
use taffeta::Simulation;
use taffeta::scene::{Air, Body, Mass, Mesh, Scene, Select};
use taffeta::topology::Surface;

/// Springs from each corner of the triangle to held nodes above it: so many that the corners' way up and down is the
/// fastest mode.
const ROPES: u32 = 30;

/// A triangle that hangs in a wind straight down, so dense that it takes all of a velocity in a step.
fn hanging(h: f64) -> Scene {
    let corners = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
    let above = (0..3 * ROPES).map(|rope| {
        let [x, _, z] = corners[(rope / ROPES) as usize];
        [x, 1.0, z]
    });
    let nodes: Vec<_> = corners.into_iter().chain(above).collect();
    let links = (0..3 * ROPES).map(|rope| [rope / ROPES, 3 + rope]).collect();
    let surface = Surface { links, ..Surface::of_triangles(nodes, vec![[0, 1, 2]]) };
    let body = Body::cloth("hanging", Mesh::Surface(Arc::new(surface)))
        .with_mass(Mass::Node(1.0))
        .structural(100.0, 0.0)
        .pin(Select::nodes((3..3 + 3 * ROPES).collect::<Vec<u32>>()));
    let wind = Air { velocity: [0.0, -0.01, 0.0], density: 1e9, drag: 1.0, lift: 0.0, gust: None };
    blown(body, wind, h)
}

/// How far below its start the triangle is after 40 steps [m], or above.
fn sag(mut simulation: Simulation) -> f64 {
    run(&mut simulation, 40);
    positions(&simulation)[0][1].abs()
}

#[test]
fn a_spring_in_a_gale_holds_at_the_step_named_for_any_air_and_not_much_above() {
    let windy = hanging(1e-3);
    let limits = build(&windy);
    let (still, named) = (limits.largest_stable_step_folded(), limits.largest_stable_step_in_air().unwrap());
    assert!((still / named / 2.0_f64.sqrt() - 1.0).abs() < 1e-3, "{still} s and {named} s");
    // Springs that pull any way are as stiff as 33 of them, and up and down there are 30: 1.1 is 1.05 times the true limit.
    let beyond = 1.1 * named;
    assert!(sag(build(&hanging(named))) < 1e-3);
    assert!(sag(build(&hanging(beyond))) > 0.02);
    let calm = |mut scene: Scene| {
        scene.world.air = None;
        scene.world.gravity = [0.0, -0.1, 0.0];
        scene
    };
    assert!(sag(build(&calm(hanging(beyond)))) < 1e-3);
    assert_eq!(build(&calm(windy)).largest_stable_step_in_air(), None);
}
