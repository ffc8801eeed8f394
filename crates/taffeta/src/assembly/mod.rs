//! Bodies one after the other, nodes in an order of good locality, springs, masses: by solver index, all in f64. A backend
//! takes it in its own numbers. What features make of the scene they keep in it as extensions, and `features` has the list
//! of them.
//!
//! User order stays outside: [`BodyAssembly::solver_index`] maps the user's indices to the solver's; nothing else does.

pub mod body;
pub mod grid;
pub mod springs;

use crate::assembly::body::{BodyAssembly, mesh_body};
use crate::extensions::Extensions;
use crate::scene::{Body, Mesh, Scene, SceneError, Solver, Time, World};

/// A scene, ready to run.
pub struct Assembly {
    /// Bodies in the scene's order.
    pub bodies: Vec<BodyAssembly>,
    /// Number of places for nodes: each body starts at a multiple of the vector width.
    pub places: usize,
    /// How springs are solved.
    pub solver: Solver,
    /// Gravity, drag, wind.
    pub world: World,
    /// Frames and steps.
    pub time: Time,
    /// What features have made of the scene.
    pub extensions: Extensions,
}

impl Assembly {
    /// Of a scene that has been validated; no bodies yet.
    pub(crate) fn empty(scene: &Scene) -> Self {
        Self {
            bodies: Vec::new(),
            places: 0,
            solver: scene.solver.clone(),
            world: scene.world.clone(),
            time: scene.time.clone(),
            extensions: Extensions::default(),
        }
    }

    /// The number of the body of a node, given by its solver index.
    pub(crate) fn number_of_body(&self, node: u32) -> usize {
        self.bodies.partition_point(|body| body.first <= node as usize) - 1
    }

    /// A body that comes after those that are there.
    pub(crate) fn next_body(&self, index: usize, body: &Body) -> Result<BodyAssembly, SceneError> {
        let mut built = match &body.mesh {
            Mesh::Grid(grid) => grid::build(body, *grid),
            mesh => mesh_body(body, mesh),
        }?;
        built.name = if body.name.is_empty() { format!("body{index}") } else { body.name.clone() };
        built.first = self.places;
        Ok(built)
    }

    /// Adds a body.
    pub(crate) fn push(&mut self, body: BodyAssembly) {
        self.places += body.places();
        self.bodies.push(body);
    }
}

impl SceneError {
    /// The same error, its path taken to be under `parent`.
    pub(crate) fn under(self, parent: &str) -> Self {
        let path = if self.path.is_empty() { parent.to_owned() } else { format!("{parent}.{}", self.path) };
        Self { path, ..self }
    }
}
