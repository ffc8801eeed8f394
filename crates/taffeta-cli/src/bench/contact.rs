//! The bench on nodes that touch each other: S2's demo in any size.

use super::measure::Bench;
use super::scenes::FRAME;
use taffeta::scene::{Body, Collider, ContactForm, Mass, Mesh, Scene, Select, SelfCollision};

/// Between neighbours [m].
const SPACING: f64 = 0.025;
/// Kept between nodes that are no neighbours [m].
const THICKNESS: f64 = 0.03;
/// Of each node [kg].
const NODE_MASS: f64 = 2.5e-4;
/// Stiffness [N/m] and damping [kg/s] of structural, shear and bend springs.
const SPRINGS: [(f64, f64); 3] = [(55.0, 0.015), (25.0, 0.015), (4.0, 0.003)];
/// Force on each node [N], and drag [kg/s].
const WIND: ([f64; 3], f64) = ([0.0, 0.0, 3e-4], 2e-4);
/// Frames in which the cloth comes to lie on the ball and on itself.
const SETTLE: u32 = 60;

/// A sheet of `rows` × `cols`, held at one edge, falls on a ball and on the floor below it.
pub fn bench(rows: u32, cols: u32) -> Bench {
    let side = f64::from(cols.min(rows) - 1) * SPACING;
    let size = [f64::from(cols - 1) * SPACING, f64::from(rows - 1) * SPACING];
    let [structural, shear, bend] = SPRINGS;
    let mut sheet = Body::cloth("sheet", Mesh::grid(rows, cols, size))
        .with_mass(Mass::Node(NODE_MASS))
        .structural(structural.0, structural.1)
        .shear(shear.0, shear.1)
        .bend(bend.0, bend.1)
        .at([0.0, 0.4 * side, 0.0])
        .pin(Select { rows: Some([0, 0]), ..Select::default() });
    sheet.self_collision =
        Some(SelfCollision { form: ContactForm::Nodes, thickness: THICKNESS, ..SelfCollision::default() });
    let ball = Collider::sphere([0.0, 0.18 * side, 0.05 * side], 0.18 * side).offset(0.02).friction(0.3);
    let floor = Collider::plane([0.0, -0.05 * side, 0.0], [0.0, 1.0, 0.0]).offset(0.02).friction(0.5);
    let mut scene =
        Scene::new("bench contact").body(sheet).collider(ball).collider(floor).time(FRAME.0, FRAME.1);
    (scene.world.wind_force, scene.world.drag) = WIND;
    Bench { settle: SETTLE, ..Bench::new("contact", vec![rows, cols], scene) }
}
