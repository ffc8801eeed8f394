//! Seams, pins that break, and tethers.

mod bits;
mod breaks;
mod carried;
mod refused;
mod seams;
mod tethers;

use crate::common::V;
use taffeta::scene::{Body, Mass, Mesh, Place, Select};

/// A square panel of 0.5 m with `side` nodes of 1 g a side, in the xz plane about `position`.
fn panel(name: &str, side: u32, position: V) -> Body {
    let body = Body::cloth(name, Mesh::grid(side, side, [0.5, 0.5])).with_mass(Mass::Node(0.001));
    let mut body = body.structural(50.0, 0.005).shear(20.0, 0.005);
    body.place = Place { position, ..Place::default() };
    body
}

/// Two nodes 1 m apart along x that no spring joins, the first at `x`; each of `mass` [kg].
fn two(name: &str, x: V, mass: f64) -> Body {
    let body = Body::cloth(name, Mesh::chain(1, 1.0)).with_mass(Mass::Node(mass));
    body.at([x[0] + 0.5, x[1], x[2]])
}

/// The same, of which only the first is free.
fn bob(name: &str, x: V, mass: f64) -> Body {
    two(name, x, mass).pin(Select::nodes([1]))
}

/// The same, both held.
fn fixed(name: &str, x: V) -> Body {
    two(name, x, 1.0).pin(Select::nodes([0, 1]))
}
