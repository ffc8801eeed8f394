use crate::scene::Select;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Nodes sewn to nodes: of two bodies, or of one. The pairs are listed, or the nodes of two selections in their order, or
/// each node with the nearest one within reach.
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Tethers {
    /// Share of that way that they may go farther.
    pub slack: f64,
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

    /// Sets when it closes [s], and at which length [m].
    pub fn closing(mut self, start: f64, end: f64, length: f64) -> Self {
        (self.close, self.length) = (Closing { start, end }, length);
        self
    }
}
