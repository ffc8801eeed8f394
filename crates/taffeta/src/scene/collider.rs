use super::Keyframe;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Something that bodies cannot enter: exactly one shape, at rest or moved by keyframes.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Collider {
    /// A ball.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sphere: Option<Sphere>,
    /// A half-space.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plane: Option<Plane>,
    /// Distance kept between surface and nodes [m].
    pub offset: f64,
    /// Coulomb coefficient of friction.
    pub friction: f64,
    /// Share of the normal speed that is given back, 0 to 1.
    pub restitution: f64,
    /// Rigid motion.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub motion: Vec<Keyframe>,
}

impl Default for Collider {
    fn default() -> Self {
        Self { sphere: None, plane: None, offset: 0.01, friction: 0.3, restitution: 0.0, motion: Vec::new() }
    }
}

/// A ball.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sphere {
    /// Centre [m].
    #[serde(default)]
    pub center: [f64; 3],
    /// Radius [m].
    pub radius: f64,
}

/// A half-space: everything on the side away from `normal` is solid.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Plane {
    /// A point [m] on the surface.
    #[serde(default)]
    pub point: [f64; 3],
    /// Outward direction; its length does not matter.
    #[serde(default = "up")]
    pub normal: [f64; 3],
}

fn up() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}

/// The one shape of a collider.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// A ball.
    Sphere(Sphere),
    /// A half-space.
    Plane(Plane),
}

impl Collider {
    /// A ball with the default offset, friction and restitution.
    pub fn sphere(center: [f64; 3], radius: f64) -> Self {
        Self { sphere: Some(Sphere { center, radius }), ..Self::default() }
    }

    /// A half-space with the default offset, friction and restitution.
    pub fn plane(point: [f64; 3], normal: [f64; 3]) -> Self {
        Self { plane: Some(Plane { point, normal }), ..Self::default() }
    }

    /// Sets the Coulomb coefficient of friction.
    pub fn friction(mut self, friction: f64) -> Self {
        self.friction = friction;
        self
    }

    /// Sets the share of normal speed that is given back.
    pub fn restitution(mut self, restitution: f64) -> Self {
        self.restitution = restitution;
        self
    }

    /// Sets the distance kept between surface and nodes [m].
    pub fn offset(mut self, offset: f64) -> Self {
        self.offset = offset;
        self
    }

    /// Adds a keyframe.
    pub fn keyframe(mut self, key: Keyframe) -> Self {
        self.motion.push(key);
        self
    }

    /// The shape, if there is exactly one.
    pub fn shape(&self) -> Option<Shape> {
        match (self.sphere, self.plane) {
            (Some(sphere), None) => Some(Shape::Sphere(sphere)),
            (None, Some(plane)) => Some(Shape::Plane(plane)),
            _ => None,
        }
    }
}
