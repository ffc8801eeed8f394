//! Springs that are constraints: all of them (ICE), or those that are too long (ACAD).

#[path = "../common/mod.rs"]
mod common;

mod acad;
mod bits;
mod contact;
mod dual;
mod figure;
mod momentum;
mod oracle;
mod pair;
mod pendulum;
mod refused;
mod rest;
mod sheet;
mod volume;

use common::state::{any, noise, set, state, stiffen};
use taffeta::scene::{Acad, Body, Ice, Mass, Mesh, Method, Scene, Solver};

/// Iterates until nothing is left but roundings.
fn accurate() -> Ice {
    Ice { tolerance: 1e-13, max_iterations: 20_000, ..Ice::default() }
}

/// The same scene with all springs as constraints.
fn with_ice(mut scene: Scene, ice: Ice) -> Scene {
    scene.solver = Solver { method: Method::Ice, ice, ..Solver::default() };
    scene
}

/// The same scene with springs that become constraints.
fn with_acad(mut scene: Scene, acad: Acad, ice: Ice) -> Scene {
    scene.solver = Solver { method: Method::Acad, ice, acad };
    scene
}

/// Nodes in a row with springs between neighbours.
fn chain(links: u32, length: f64, mass: f64, [k, d]: [f64; 2]) -> Body {
    Body::cloth("chain", Mesh::chain(links, length)).with_mass(Mass::Node(mass)).structural(k, d)
}
