use crate::scene::Body;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What touches what in a body's contact with itself and others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ContactForm {
    /// Vertices touch triangles, and edges touch edges; what starts apart never passes through.
    #[default]
    Triangles,
    /// Nodes touch nodes: for meshes whose edges are about as long as the thickness.
    Nodes,
}

/// Contact of a body with itself, and with others that have it in the same form.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, SelfCollision};
///
/// let touching = SelfCollision { thickness: 0.01, friction: 0.4, ..SelfCollision::default() };
/// let cloth = Body::cloth("cloth", Mesh::grid(50, 50, [0.5, 0.5])).with_mass(Mass::Area(0.2)).structural(100.0, 0.05);
/// let cloth = Body { self_collision: Some(touching), ..cloth };
/// assert_eq!(cloth.self_collision.unwrap().friction, 0.4);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SelfCollision {
    /// What touches what.
    pub form: ContactForm,
    /// Distance that is kept [m]; between two bodies it is the mean of both.
    pub thickness: f64,
    /// Coulomb coefficient; between two bodies the geometric mean.
    pub friction: f64,
    /// Coefficient of restitution, 0 to 1; between two bodies the larger one. Between triangles it is 0.
    pub restitution: f64,
    /// Between triangles: names of the only other bodies that it touches; empty: all that have contact of this form. Two bodies
    /// touch if each of them may touch the other.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub with: Vec<String>,
    /// Between triangles: names of other bodies that it does not touch.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub without: Vec<String>,
}

impl SelfCollision {
    /// Whether the body may touch another one of this name.
    pub(crate) fn may_touch(&self, other: &String) -> bool {
        (self.with.is_empty() || self.with.contains(other)) && !self.without.contains(other)
    }
}

impl Body {
    /// Has the body collide with itself, and with others that do so, at a distance of `thickness` [m]: its vertices and edges
    /// touch triangles and edges, and what starts apart never passes through.
    pub fn collide(mut self, thickness: f64) -> Self {
        self.self_collision = Some(SelfCollision { thickness, ..SelfCollision::default() });
        self
    }

    /// The same between nodes alone: faster, for meshes whose edges are about as long as the thickness.
    pub fn collide_nodes(mut self, thickness: f64) -> Self {
        let form = ContactForm::Nodes;
        self.self_collision = Some(SelfCollision { form, thickness, ..SelfCollision::default() });
        self
    }
}

impl Default for SelfCollision {
    fn default() -> Self {
        Self {
            form: ContactForm::default(),
            thickness: 0.01,
            friction: 0.2,
            restitution: 0.0,
            with: Vec::new(),
            without: Vec::new(),
        }
    }
}
