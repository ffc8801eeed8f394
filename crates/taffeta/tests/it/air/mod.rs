//! Lift and drag of triangles, and gusts.

mod bits;
mod energy;
mod frame;
mod oracle;
mod step;
mod triangle;

use crate::common::weightless;
use taffeta::scene::{Air, Body, Gust, Mass, Mesh, Scene};

/// Numbers that all differ.
const AIR: Air = Air { velocity: [3.0, -1.0, 2.0], density: 1.3, drag: 1.1, lift: 0.9, gust: None };

/// The same at rest.
const STILL: Air = Air { velocity: [0.0; 3], ..AIR };

/// The same with gusts smaller than a sheet.
const GUSTY: Air = Air { gust: Some(Gust { speed: 2.0, length: 0.3, period: 0.2, seed: 3 }), ..AIR };

/// A sheet of 0.3 kg/m² without springs.
fn loose(rows: u32, cols: u32) -> Body {
    Body::cloth("sheet", Mesh::grid(rows, cols, [0.5, 0.4])).with_mass(Mass::Area(0.3))
}

/// A body in air without gravity, one step a frame.
fn blown(body: Body, air: Air, h: f64) -> Scene {
    let mut scene = weightless("air", h, h).body(body);
    scene.world.air = Some(air);
    scene
}
