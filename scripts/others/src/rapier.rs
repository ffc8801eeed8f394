//! Rapier's soft body: particles and springs, solved with its rigid bodies.

use crate::sheet::{Engine, FLOOR, FRAME, FRICTION, HEIGHT, NODE_MASS, OFFSET, RADIUS, SIZE, Spring};
use rapier3d::prelude::*;

/// What differs from the scene.
pub const NOTE: &str = "springs as in the scene (structural, shear, bend), but of 100 Hz with a damping ratio of 1, as in Rapier's \
    own test of a cloth that drapes, in place of 200 N/m; its default solver: 4 steps a frame, and up to 4 more while the \
    cloth hits something fast, of 1 + 3 iterations each; triangles meet ball and floor, not nodes alone; no contact of the \
    cloth with itself; never asleep";

/// Of all springs [Hz]: that of each with the mass at its ends, for which Rapier finds the stiffness. At its default of 30 Hz
/// springs of the 64 × 64 sheet end half as long again.
const SOFTNESS: f32 = 100.0;

/// The scene in Rapier.
pub struct Rapier {
    world: PhysicsWorld,
    cloth: SoftBodyHandle,
}

impl Rapier {
    pub fn new(side: usize) -> Self {
        let mut world = PhysicsWorld::new();
        world.integration_parameters.dt = FRAME;
        let still = |collider: ColliderBuilder| collider.friction(FRICTION).restitution(0.0);
        world.insert(RigidBodyBuilder::fixed(), still(ColliderBuilder::ball(RADIUS)));
        let floor = RigidBodyBuilder::fixed().translation(Vector::new(0.0, FLOOR, 0.0));
        world.insert(floor, still(ColliderBuilder::cuboid(50.0, 0.5, 50.0).translation(Vector::Y * -0.5)));
        let (corner, cell) = (SIZE / 2.0, SIZE / (side - 1) as f32);
        let origin = Vector::new(-corner, HEIGHT, -corner);
        let cloth = SoftBodyBuilder::cloth(origin, Vector::Z * cell, Vector::X * cell, side, side)
            .particle_mass(NODE_MASS)
            .particle_radius(OFFSET)
            .surface_collider(still(ColliderBuilder::ball(OFFSET)))
            .softness(SpringCoefficients::new(SOFTNESS, 1.0))
            .can_sleep(false);
        let cloth = world.insert_soft_body(cloth);
        Self { world, cloth }
    }

    fn body(&self) -> &SoftBody {
        &self.world.soft_bodies[self.cloth]
    }
}

impl Engine for Rapier {
    fn frame(&mut self) -> Result<u32, String> {
        // Rapier decides on the further steps of a frame at the end of the one before.
        let more = self.world.bodies[self.body().root_body()].additional_solver_iterations();
        self.world.step();
        Ok((self.world.integration_parameters.num_solver_iterations + more) as u32)
    }

    fn positions(&self) -> Vec<[f32; 3]> {
        self.body().particle_positions().map(|at| at.to_array()).collect()
    }

    fn springs(&self) -> Vec<Spring> {
        let spring = |edge: &SoftBodyEdge| Spring { ends: edge.vertices, rest: edge.rest_length };
        self.body().edges().iter().map(spring).collect()
    }

    fn spring_count(&self) -> Option<usize> {
        Some(self.body().edges().len())
    }
}
