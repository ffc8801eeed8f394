use crate::scene::{Body, Select};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Nodes sewn to nodes: of two bodies, or of one. The pairs are listed, or the nodes of two selections in their order, or
/// each node with the nearest one within reach.
///
/// ```
/// use taffeta::scene::{Seam, SeamSide, Select};
///
/// // The right edge of a grid of 21 columns is sewn to the left edge of another one, and tears at 5 N.
/// let sides = [SeamSide::new("left", Select::cols(20, 20)), SeamSide::new("right", Select::cols(0, 0))];
/// let [from, to] = sides;
/// let seam = Seam { break_force: Some(5.0), ..Seam::new(from, to).closing(0.0, 0.5, 0.0) };
/// assert_eq!(seam.close.end, 0.5);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Seam {
    /// One side.
    pub from: SeamSide,
    /// The other side.
    pub to: SeamSide,
    /// Pairs of vertices, one of each side; instead of selections.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pairs: Option<Vec<[u32; 2]>>,
    /// Each node of `from` is sewn to the nearest one of `to` that is not farther than this at the start [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reach: Option<f64>,
    /// Distance of sewn nodes once the seam is closed [m].
    #[serde(default)]
    pub length: f64,
    /// When it closes.
    #[serde(default)]
    pub close: Closing,
    /// Stiffness of each pair [N/m]; without it seams do not give way.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub k: Option<f64>,
    /// Force at which a pair breaks for good [N]; without it none does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub break_force: Option<f64>,
}

/// One side of a seam.
///
/// ```
/// use taffeta::scene::{SeamSide, Select};
///
/// let edge = SeamSide::new("sleeve", Select { boundary: Some(true), ..Select::default() });
/// assert_eq!(edge.body, "sleeve");
/// // Any node of the body.
/// assert!(SeamSide::body("sleeve").select.is_none());
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SeamSide {
    /// Name of the body.
    pub body: String,
    /// Which of its nodes; with `reach`, all where it is not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub select: Option<Select>,
}

/// When a seam closes: the length of each pair goes from the distance at the start to that of the seam, at an even speed.
///
/// ```
/// use taffeta::scene::{Closing, Seam};
///
/// // Two nodes that are drawn together in the first half second.
/// let seam = Seam { close: Closing { start: 0.0, end: 0.5 }, ..Seam::pairs("front", "back", [[0, 0], [1, 1]]) };
/// assert_eq!(seam.pairs, Some(vec![[0, 0], [1, 1]]));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Closing {
    /// When it begins [s].
    pub start: f64,
    /// When it is closed [s].
    pub end: f64,
}

impl Default for Closing {
    fn default() -> Self {
        Self { start: 0.0, end: 0.5 }
    }
}

/// How far free nodes may go from held ones of their body: by as much as the way along the surface at rest.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Select};
///
/// // However weak its springs are, the curtain gets no more than 5 % longer.
/// let curtain = Body::cloth("curtain", Mesh::grid(30, 20, [1.0, 1.5]))
///     .with_mass(Mass::Area(0.2))
///     .structural(5.0, 0.01)
///     .pin(Select::rows(0, 0))
///     .tether(0.05);
/// assert_eq!(curtain.tethers.unwrap().slack, 0.05);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Tethers {
    /// Share of that way that they may go farther.
    pub slack: f64,
}

impl Body {
    /// Keeps free nodes as near to held ones as the way along the surface is long, and a share `slack` of it more.
    pub fn tether(mut self, slack: f64) -> Self {
        self.tethers = Some(Tethers { slack });
        self
    }
}

impl SeamSide {
    /// Chosen nodes of a body.
    pub fn new(body: impl Into<String>, select: Select) -> Self {
        Self { body: body.into(), select: Some(select) }
    }

    /// A body as a whole.
    pub fn body(body: impl Into<String>) -> Self {
        Self { body: body.into(), select: None }
    }
}

impl Seam {
    /// Sews the nodes of two selections in their order.
    pub fn new(from: SeamSide, to: SeamSide) -> Self {
        Self { from, to, ..Self::default() }
    }

    /// Sews listed vertices of two bodies.
    pub fn pairs(from: impl Into<String>, to: impl Into<String>, pairs: impl Into<Vec<[u32; 2]>>) -> Self {
        let pairs = Some(pairs.into());
        Self { pairs, ..Self::new(SeamSide::body(from), SeamSide::body(to)) }
    }

    /// Whether it makes one point of the nodes of each pair for good, once it is closed.
    pub(crate) fn makes_points(&self) -> bool {
        self.length == 0.0 && self.k.is_none() && self.break_force.is_none()
    }

    /// The bodies of both sides.
    pub(crate) fn bodies(&self) -> [&str; 2] {
        [&self.from.body, &self.to.body]
    }

    /// Sets when it closes [s], and at which length [m].
    pub fn closing(mut self, start: f64, end: f64, length: f64) -> Self {
        (self.close, self.length) = (Closing { start, end }, length);
        self
    }
}
