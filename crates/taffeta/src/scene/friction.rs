//! Friction of a pair.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The friction of two bodies, or of a body and a collider, instead of what follows from both sides.
///
/// ```
/// use taffeta::scene::{Body, Collider, Mass, Mesh, Scene};
///
/// // A cloth that slips off a ball but lies still on the floor.
/// let cloth = Body::cloth("cloth", Mesh::grid(20, 20, [1.0, 1.0])).with_mass(Mass::Area(0.2)).at([0.0, 0.6, 0.0]);
/// let scene = Scene::new("silk")
///     .body(cloth.structural(100.0, 0.05))
///     .collider(Collider::sphere([0.0; 3], 0.4).named("ball"))
///     .collider(Collider::plane([0.0, -0.4, 0.0], [0.0, 1.0, 0.0]).friction(0.6))
///     .friction_between("cloth", "ball", 0.05);
/// scene.validate()?;
/// assert!(scene.friction_between("cloth", "bell", 0.1).validate().is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    /// Names of the two, one of which is a body. A body named twice touches itself.
    pub between: [String; 2],
    /// Coulomb coefficient.
    pub value: f64,
}
