//! S2's demo in any size: a sheet held at one edge falls on a ball, on the floor below it and on itself.

use taffeta::scene::{Body, Collider, ContactForm, Mass, Mesh, Scene, Select, SelfCollision};
use taffeta::{Options, Simulation};

/// One frame [s] and its longest sub-step [s]: 34 sub-steps.
const FRAME: (f64, f64) = (1.0 / 30.0, 1e-3);
/// Between neighbours [m].
pub const SPACING: f64 = 0.025;
/// Kept between nodes that are no neighbours [m].
pub const THICKNESS: f64 = 0.03;
/// Of each node [kg].
pub const NODE_MASS: f64 = 2.5e-4;
/// Stiffness [N/m] and damping [kg/s] of structural, shear and bend springs.
pub const SPRINGS: [(f64, f64); 3] = [(55.0, 0.015), (25.0, 0.015), (4.0, 0.003)];
/// Force on each node [N], and drag [kg/s].
pub const WIND: ([f64; 3], f64) = ([0.0, 0.0, 3e-4], 2e-4);
/// Of ball and floor [m].
const OFFSET: f64 = 0.02;
/// Frames in which the cloth comes to lie on the ball and on itself.
const SETTLE: u32 = 60;

/// A square sheet.
pub struct Sheet {
    /// Nodes along an edge.
    pub side: u32,
}

impl Sheet {
    /// Length of an edge [m].
    fn edge(&self) -> f64 {
        f64::from(self.side - 1) * SPACING
    }

    /// Centre and radius of the ball [m].
    fn ball(&self) -> ([f64; 3], f64) {
        let edge = self.edge();
        ([0.0, 0.18 * edge, 0.05 * edge], 0.18 * edge)
    }

    /// Centre of the ball and how near to it nodes come [m].
    pub fn kept_from_ball(&self) -> ([f64; 3], f64) {
        let (center, radius) = self.ball();
        (center, radius + OFFSET)
    }

    /// How low nodes come [m].
    pub fn lowest(&self) -> f64 {
        OFFSET - 0.05 * self.edge()
    }

    /// Sub-steps of a frame.
    pub fn substeps(&self) -> u32 {
        self.scene().time.substeps()
    }

    /// Length of a sub-step that S2's programs take [s].
    pub fn step(&self) -> f64 {
        FRAME.1
    }

    /// Springs of all kinds.
    pub fn springs(&self) -> u32 {
        let n = self.side;
        2 * n * (n - 1) + 2 * (n - 1) * (n - 1) + 2 * n * (n - 2)
    }

    /// The scene.
    pub fn scene(&self) -> Scene {
        let (edge, [structural, shear, bend]) = (self.edge(), SPRINGS);
        let mut sheet = Body::cloth("sheet", Mesh::grid(self.side, self.side, [edge; 2]))
            .with_mass(Mass::Node(NODE_MASS))
            .structural(structural.0, structural.1)
            .shear(shear.0, shear.1)
            .bend(bend.0, bend.1)
            .at([0.0, 0.4 * edge, 0.0])
            .pin(Select { rows: Some([0, 0]), ..Select::default() });
        sheet.self_collision = Some(SelfCollision {
            form: ContactForm::Nodes,
            thickness: THICKNESS,
            ..SelfCollision::default()
        });
        let (center, radius) = self.ball();
        let ball = Collider::sphere(center, radius).offset(OFFSET).friction(0.3);
        let floor = [0.0, self.lowest() - OFFSET, 0.0];
        let floor = Collider::plane(floor, [0.0, 1.0, 0.0]).offset(OFFSET).friction(0.5);
        let mut scene =
            Scene::new("S2's demo").body(sheet).collider(ball).collider(floor).time(FRAME.0, FRAME.1);
        (scene.world.wind_force, scene.world.drag) = WIND;
        scene
    }

    /// The scene where it has settled.
    ///
    /// # Errors
    /// Where it cannot be run.
    pub fn settled(&self, options: &Options) -> Result<Simulation, String> {
        let mut simulation = Simulation::new(&self.scene(), options).map_err(|error| error.to_string())?;
        simulation.advance(SETTLE).map_err(|error| error.to_string())?;
        Ok(simulation)
    }
}
