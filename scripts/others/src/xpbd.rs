//! rapier-cloth-core: extended position-based dynamics.

use crate::sheet::{
    Engine, FLOOR, FRAME, FRICTION, GRAVITY, HEIGHT, NODE_MASS, OFFSET, RADIUS, SIZE, Spring,
};
use rapier_cloth_core::{
    Cloth, ClothError, ClothMaterial, Contact, ContactKey, ContactSource, ContactStage, GridBuilder, Solver,
    SolverSettings, Vec3,
};

/// What differs from the scene.
pub const NOTE: &str = "no springs: edges of triangles (one diagonal a cell) keep their lengths and hinges resist bending; 4 steps \
    a frame of 8 iterations and the default material, but for bending, which is as soft as in the crate's demonstration of a \
    sheet on a ball; nodes at the border weigh half; ball and floor are lines of this program, as the crate brings no \
    shapes, and meet nodes; no contact of the cloth with itself";

/// Steps a frame: 1/240 s, as in the crate's examples and measurements.
const STEPS: u32 = 4;

/// Compliance of hinges [1/(N·m)]. With the default of 1e-4 the sheet is a plate that slides off the ball.
const SOFT: f32 = 1e3;

/// The scene in rapier-cloth-core.
pub struct Xpbd {
    cloth: Cloth,
    solver: Solver,
    settings: SolverSettings,
}

impl Xpbd {
    pub fn new(side: usize) -> Result<Self, ClothError> {
        let corner = Vec3::new(-SIZE / 2.0, HEIGHT, -SIZE / 2.0);
        let mesh = GridBuilder::new(side, side).size(SIZE, SIZE).origin(corner).build()?;
        // So that a node inside the sheet weighs what the scene says.
        let cell = SIZE / (side - 1) as f32;
        let material = ClothMaterial {
            surface_density: NODE_MASS / (cell * cell),
            friction: FRICTION,
            contact_radius: OFFSET,
            bend_compliance: SOFT,
            ..ClothMaterial::default()
        };
        let cloth = Cloth::new(mesh, material)?;
        Ok(Self { cloth, solver: Solver::new(), settings: SolverSettings::default() })
    }
}

impl Engine for Xpbd {
    fn frame(&mut self) -> Result<u32, String> {
        let (step, gravity) = (FRAME / STEPS as f32, Vec3::NEG_Y * GRAVITY);
        for _ in 0..STEPS {
            self.solver
                .step_with_contacts(&mut self.cloth, step, gravity, &self.settings, &[], &mut BallAndFloor)
                .map_err(|error| error.to_string())?;
        }
        Ok(STEPS)
    }

    fn positions(&self) -> Vec<[f32; 3]> {
        self.cloth.positions().iter().map(|at| at.to_array()).collect()
    }

    fn springs(&self) -> Vec<Spring> {
        let edges = self.cloth.mesh().edges().iter();
        edges.map(|edge| Spring { ends: edge.vertices, rest: edge.rest_length }).collect()
    }

    fn spring_count(&self) -> Option<usize> {
        None
    }
}

struct BallAndFloor;

impl ContactSource for BallAndFloor {
    fn contacts(
        &mut self,
        _: &[Vec3],
        positions: &[Vec3],
        radius: f32,
        _: ContactStage,
        out: &mut Vec<Contact>,
    ) -> Result<(), ClothError> {
        // Nodes that are near take part, as an iteration may push them in.
        let near = 2.0 * radius;
        for (node, &at) in positions.iter().enumerate() {
            let mut touch = |external: u64, normal: Vec3, point: Vec3| {
                let key = ContactKey { particle: node as u32, external, feature: 0 };
                out.push(Contact { key, normal, point, surface_velocity: Vec3::ZERO, friction: FRICTION });
            };
            if at.length_squared() < (RADIUS + near).powi(2) {
                let normal = at.normalize_or(Vec3::Y);
                touch(0, normal, normal * RADIUS);
            }
            if at.y < FLOOR + near {
                touch(1, Vec3::Y, Vec3::new(at.x, FLOOR, at.z));
            }
        }
        Ok(())
    }
}
