use crate::scene::Select;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A load on selected nodes: exactly one of `force` and `torque`.
///
/// ```
/// use taffeta::scene::{Force, ScaleKey, Scene, Select};
///
/// // Pulls a corner of the body `cloth` up with 2 N, from nothing to all of it within a second.
/// let pull = Force {
///     body: "cloth".into(),
///     select: Select::nodes([0]),
///     force: Some([0.0, 2.0, 0.0]),
///     motion: vec![ScaleKey { t: 0.0, scale: 0.0 }, ScaleKey { t: 1.0, scale: 1.0 }],
///     ..Force::default()
/// };
/// let scene = Scene::new("pulled").force(pull);
/// # let _ = scene;
/// ```
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
///
/// ```
/// use taffeta::scene::{Force, Select, Torque};
///
/// // Turns the first row of the body `cloth` about the y axis with 0.1 N·m.
/// let turn = Force {
///     body: "cloth".into(),
///     select: Select::rows(0, 0),
///     torque: Some(Torque { axis: [0.0, 1.0, 0.0], value: 0.1, about: [0.0; 3] }),
///     ..Force::default()
/// };
/// # let _ = turn;
/// ```
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
///
/// ```
/// use taffeta::scene::ScaleKey;
///
/// // Full force for a second, then none after another.
/// let fading = [ScaleKey { t: 1.0, scale: 1.0 }, ScaleKey { t: 2.0, scale: 0.0 }];
/// assert!(fading[0].t < fading[1].t);
/// ```
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScaleKey {
    /// Time [s].
    pub t: f64,
    /// Factor on the load.
    pub scale: f64,
}
