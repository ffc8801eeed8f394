//! Springs that are constraints: all of them (ICE), or those that are too long (ACAD).

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

use crate::common::alike::{chain, with_ice};
use crate::common::state::{any, noise, set, state, stiffen};
use taffeta::scene::{Acad, Ice, Method, Scene, Solver};

/// Iterates until nothing is left but roundings.
fn accurate() -> Ice {
    Ice { tolerance: 1e-13, max_iterations: 20_000, ..Ice::default() }
}

/// The same scene with springs that become constraints.
fn with_acad(mut scene: Scene, acad: Acad, ice: Ice) -> Scene {
    scene.solver = Solver { method: Method::Acad, ice, acad, ..Solver::default() };
    scene
}
