use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A turn about an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rotation {
    /// Direction of the axis; its length does not matter.
    pub axis: [f64; 3],
    /// Angle [°], right-handed.
    pub degrees: f64,
}

/// A pose at a time. Between keyframes the motion is linear; before the first it starts from rest at t = 0;
/// after the last it stays.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Keyframe {
    /// Time [s].
    pub t: f64,
    /// Shift from the start [m].
    #[serde(default)]
    pub translate: [f64; 3],
    /// Turn from the start, about `pivot`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotate: Option<Rotation>,
    /// The point [m] that `rotate` turns about.
    #[serde(default)]
    pub pivot: [f64; 3],
}

impl Keyframe {
    /// A shift by `translate` [m] reached at time `t` [s].
    pub fn translate(t: f64, translate: [f64; 3]) -> Self {
        Self { t, translate, ..Self::default() }
    }

    /// A turn by `degrees` about `axis` through `pivot`, reached at time `t` [s].
    pub fn rotate(t: f64, axis: [f64; 3], degrees: f64, pivot: [f64; 3]) -> Self {
        Self { t, rotate: Some(Rotation { axis, degrees }), pivot, ..Self::default() }
    }
}
