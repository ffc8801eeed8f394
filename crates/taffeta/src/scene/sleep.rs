//! When bodies at rest fall asleep.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// When bodies that rest fall asleep: they stand still then until something touches them, and cost next to nothing.
///
/// A body falls asleep after a time in which none of its nodes was faster than `speed` and nothing that acts on it changed. All that
/// it touches, or is sewn to, must be at rest with it. It wakes where forces, wind, pins or seams of it change, and where a collider
/// that moves or a body that is awake comes near.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Scene, Select, Sleep};
/// use taffeta::{Options, Simulation, glam::DVec3};
///
/// let curtain = Body::cloth("curtain", Mesh::grid(6, 5, [0.4, 0.5])).with_mass(Mass::Area(0.2)).structural(20.0, 0.05);
/// let mut scene = Scene::new("a curtain").time(1.0 / 60.0, 2e-3).body(curtain.pin(Select::rows(0, 0)));
/// scene.world.drag = 0.01;
/// scene.sleep = Some(Sleep::default());
/// let mut simulation = Simulation::new(&scene, &Options::default())?;
/// let curtain = simulation.body("curtain")?;
/// while !simulation.is_asleep(curtain)? {
///     assert!(simulation.step()?.time < 60.0);
/// }
/// simulation.apply_force(curtain, 29, DVec3::Z)?;
/// simulation.step()?;
/// assert!(!simulation.is_asleep(curtain)?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Sleep {
    /// Speed [m/s] that no node of a body at rest exceeds.
    pub speed: f64,
    /// How long a body is at rest before it falls asleep [s].
    pub after: f64,
}

impl Default for Sleep {
    fn default() -> Self {
        Self { speed: 0.02, after: 0.5 }
    }
}
