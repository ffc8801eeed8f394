use crate::scene::{Body, Select};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

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
    /// Between triangles: parts of the body that keep another distance, by name. Where some overlap, the last by name counts.
    #[serde(rename = "zone", skip_serializing_if = "BTreeMap::is_empty")]
    pub zones: BTreeMap<String, ContactZone>,
}

/// A part of a body that keeps another distance than the rest.
///
/// ```
/// use taffeta::scene::{ContactZone, Select, SelfCollision};
///
/// let padding = ContactZone { select: Select::rows(0, 5), thickness: 0.012 };
/// let jacket = SelfCollision { thickness: 0.003, zones: [("shoulders".into(), padding)].into(), ..SelfCollision::default() };
/// # assert_eq!(jacket.zones["shoulders"].thickness, 0.012);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactZone {
    /// Which nodes: a triangle is of the zone when all of its corners are.
    pub select: Select,
    /// Distance that is kept [m]; between two zones it is the mean of both.
    pub thickness: f64,
}

impl SelfCollision {
    /// The largest distance that a part keeps [m], and the zone that does if it is not the whole body.
    pub(crate) fn thickest(&self) -> (f64, Option<&String>) {
        let zones = self.zones.iter().map(|(name, zone)| (zone.thickness, Some(name)));
        zones.fold((self.thickness, None), |most, one| if one.0 > most.0 { one } else { most })
    }

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
            zones: BTreeMap::new(),
        }
    }
}
