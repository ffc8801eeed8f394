use crate::scene::Select;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A load on selected nodes: exactly one of `force` and `torque`.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Force {
    /// Name of the body.
    pub body: String,
    /// Which of its nodes.
    pub select: Select,
    /// Force on each selected node [N].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<[f64; 3]>,
    /// Torque distributed over the selected nodes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque: Option<Torque>,
    /// Scale over time; without it the load is constant.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub motion: Vec<ScaleKey>,
}

/// A torque about a fixed axis, shared as f = τ (a × r)/Σ|a × r|² so that the forces' moments add up to τ.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Torque {
    /// Direction of the axis; its length does not matter.
    pub axis: [f64; 3],
    /// Moment about the axis [N·m].
    pub value: f64,
    /// A point [m] on the axis.
    #[serde(default)]
    pub about: [f64; 3],
}

/// Scale of a load at a time: linear between keys, constant before the first and after the last.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScaleKey {
    /// Time [s].
    pub t: f64,
    /// Factor on the load.
    pub scale: f64,
}
