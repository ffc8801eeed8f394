//! The benches on grids.

use super::measure::Bench;
use taffeta::scene::{Body, Collider, Mass, Mesh, Scene, Select};

/// One frame [s] and its longest sub-step [s]: 34 sub-steps.
pub const FRAME: (f64, f64) = (1.0 / 30.0, 1e-3);
/// Between neighbours [m].
const SPACING: f64 = 0.01;
/// Of each node [kg].
const NODE_MASS: f64 = 1e-3;
/// Of each spring [N/m]: its largest stable step is about twice [`FRAME`]'s.
const STIFFNESS: f64 = 60.0;
/// Of each spring [kg/s].
const DAMPING: f64 = 0.01;

fn sheet(rows: u32, cols: u32) -> Body {
    let size = [f64::from(cols - 1) * SPACING, f64::from(rows - 1) * SPACING];
    Body::cloth("sheet", Mesh::grid(rows, cols, size))
        .with_mass(Mass::Node(NODE_MASS))
        .structural(STIFFNESS, DAMPING)
        .shear(STIFFNESS, DAMPING)
        .bend(STIFFNESS, DAMPING)
}

/// A level sheet held at two corners, all nodes out of their places at the start.
pub fn grid(rows: u32, cols: u32) -> Bench {
    let sheet = sheet(rows, cols).pin(Select::nodes([0, cols - 1]));
    let scene = Scene::new("bench grid").body(sheet).time(FRAME.0, FRAME.1);
    Bench { disturbance: 0.1 * SPACING, ..Bench::new("grid", vec![rows, cols], scene) }
}

/// A sheet that falls on a ball of a third of its width.
pub fn drape(rows: u32, cols: u32) -> Bench {
    let radius = f64::from(rows.min(cols)) * SPACING / 3.0;
    let ball = Collider::sphere([0.0; 3], radius).offset(0.5 * SPACING);
    let sheet = sheet(rows, cols).at([0.0, radius + SPACING, 0.0]);
    let scene = Scene::new("bench drape").body(sheet).collider(ball).time(FRAME.0, FRAME.1);
    Bench::new("drape", vec![rows, cols], scene)
}
