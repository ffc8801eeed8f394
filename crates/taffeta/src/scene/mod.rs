//! What the user describes: plain types with sensible defaults, and a check that nothing in them is impossible.
//!
//! The same types are built in Rust and read from TOML (by `taffeta-io`); the format is described by their JSON
//! Schema. SI units, y up, right-handed.

mod air;
mod attach;
mod body;
mod collider;
mod error;
mod force;
mod friction;
mod identity;
mod layers;
mod material;
mod memory;
mod mesh;
mod motion;
mod presets;
mod self_collision;
mod sheet;
mod sleep;
mod solver;
mod surface;
mod unusual;
mod validate;
mod volume;
mod world;

pub use air::{Air, Gust};
pub use attach::{Closing, Seam, SeamSide, Tethers};
pub use body::*;
pub use collider::{Bar, Collider, Cuboid, Heightfield, Plane, Poses, Shape, Sphere};
pub use error::SceneError;
pub use force::{Force, ScaleKey, Torque};
pub use friction::Friction;
pub(crate) use identity::identity_hash;
pub use identity::{difference, identity};
pub use layers::{LayerMask, Layers};
pub use material::{Fabric, FabricDamping, Material, RestCurvature, WarpWeft, Zone};
pub use memory::MemoryNeeded;
pub use mesh::{Chain, Cube, Cylinder, Grid, Icosphere, Mesh, Torus, UvSphere};
pub use motion::{Keyframe, Rotation};
pub use presets::{PRESETS, Preset};
pub use self_collision::*;
pub use sheet::{Disc, Pattern, Sheet};
pub use sleep::Sleep;
pub use solver::{Acad, ConstraintForm, Ice, Method, Solver, Xpbd};
pub use surface::{Polygons, Surface, Uvs};
pub(crate) use validate::{LARGEST_LENGTH, Path, Side, check_motion, check_rotation, check_shape, plain};
pub use volume::{Volume, VolumeForm, VolumeKey, VolumeWeights};
pub use world::{Time, World};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A whole scene: bodies, colliders, forces, and how to run them.
///
/// ```
/// use taffeta::scene::{Body, Collider, Mass, Mesh, Scene};
///
/// let cloth = Body::cloth("cloth", Mesh::grid(32, 32, [2.0, 2.0])).with_mass(Mass::Area(0.2)).at([0.0, 0.6, 0.0]);
/// let scene = Scene::new("over a ball")
///     .time(1.0 / 60.0, 5e-4)
///     .body(cloth.structural(200.0, 0.1))
///     .collider(Collider::sphere([0.0; 3], 0.5).friction(0.3));
/// scene.validate()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Scene {
    /// A line for people.
    pub title: String,
    /// Frames and steps.
    pub time: Time,
    /// Gravity, drag and wind.
    pub world: World,
    /// How springs are solved.
    pub solver: Solver,
    /// When bodies at rest fall asleep; without it none does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sleep: Option<Sleep>,
    /// Cloth and soft bodies.
    #[serde(rename = "body")]
    pub bodies: Vec<Body>,
    /// What bodies rest on and are pushed by.
    #[serde(rename = "collider")]
    pub colliders: Vec<Collider>,
    /// Point loads and torques.
    #[serde(rename = "force")]
    pub forces: Vec<Force>,
    /// Nodes sewn to nodes.
    #[serde(rename = "seam", skip_serializing_if = "Vec::is_empty")]
    pub seams: Vec<Seam>,
    /// Friction of pairs of bodies, and of bodies and colliders.
    #[serde(rename = "friction", skip_serializing_if = "Vec::is_empty")]
    pub frictions: Vec<Friction>,
}

impl Scene {
    /// An empty scene with earth's gravity, 60 frames a second.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), ..Self::default() }
    }

    /// Adds a body.
    pub fn body(mut self, body: Body) -> Self {
        self.bodies.push(body);
        self
    }

    /// Adds a collider.
    pub fn collider(mut self, collider: Collider) -> Self {
        self.colliders.push(collider);
        self
    }

    /// Adds a point load or torque.
    pub fn force(mut self, force: Force) -> Self {
        self.forces.push(force);
        self
    }

    /// Adds a seam.
    pub fn seam(mut self, seam: Seam) -> Self {
        self.seams.push(seam);
        self
    }

    /// Sets the friction of two bodies, or of a body and a collider, by their names.
    pub fn friction_between(mut self, one: impl Into<String>, other: impl Into<String>, value: f64) -> Self {
        self.frictions.push(Friction { between: [one.into(), other.into()], value });
        self
    }

    /// Sets how springs are solved.
    pub fn method(mut self, method: Method) -> Self {
        self.solver.method = method;
        self
    }

    /// Sets the frame length [s] and the longest sub-step [s].
    pub fn time(mut self, dt: f64, max_step: f64) -> Self {
        self.time.dt = dt;
        self.time.max_step = Some(max_step);
        self
    }
}
