//! Springs that are solved at once by nodes: Newton's steps of backward Euler.

#[path = "../common/mod.rs"]
mod common;

mod bits;
mod contact;
mod energy;
mod forms;
mod iterations;
mod momentum;
mod oracle;
mod reference;
mod rest;
mod sheet;

use common::state::{any, noise};
use taffeta::scene::{Body, ConstraintForm, Ice, Mass, Mesh, Method, Scene, Solver};

/// Settings of the primal form with a number of Newton steps.
fn newton(newton_steps: u32) -> Ice {
    Ice { form: ConstraintForm::Primal, newton_steps, ..Ice::default() }
}

/// Iterates until nothing is left but roundings.
fn accurate(newton_steps: u32) -> Ice {
    Ice { tolerance: 1e-13, max_iterations: 20_000, ..newton(newton_steps) }
}

/// The same scene with all springs solved at once.
fn with(mut scene: Scene, ice: Ice) -> Scene {
    scene.solver = Solver { method: Method::Ice, ice, ..Solver::default() };
    scene
}

/// Nodes in a row with springs between neighbours.
fn chain(links: u32, length: f64, mass: f64, [k, d]: [f64; 2]) -> Body {
    Body::cloth("chain", Mesh::chain(links, length)).with_mass(Mass::Node(mass)).structural(k, d)
}
