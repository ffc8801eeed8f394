use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Air around all bodies: lift and drag on each of their triangles, on both sides alike.
///
/// ```
/// use taffeta::scene::{Air, Scene};
///
/// // A breeze of 3 m/s along x.
/// let air = Air { velocity: [3.0, 0.0, 0.0], ..Air::default() };
/// assert!(air.moves());
/// let mut scene = Scene::new("in the wind");
/// scene.world.air = Some(air);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Air {
    /// Velocity of the air [m/s].
    pub velocity: [f64; 3],
    /// Density [kg/m³].
    pub density: f64,
    /// Drag coefficient of a triangle that stands across the flow.
    pub drag: f64,
    /// Lift coefficient: lift is greatest at 45° to the flow, with half of it.
    pub lift: f64,
    /// Gusts beside the velocity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gust: Option<Gust>,
}

impl Default for Air {
    /// Air at rest at 15 °C and sea level; drag of a square plate.
    fn default() -> Self {
        Self { velocity: [0.0; 3], density: 1.225, drag: 1.2, lift: 1.0, gust: None }
    }
}

/// A field of gusts that drifts with the air.
///
/// ```
/// use taffeta::scene::{Air, Gust};
///
/// // Gusts of 1.5 m/s that are half a metre large and last two seconds.
/// let gust = Gust { speed: 1.5, length: 0.5, period: 2.0, ..Gust::default() };
/// let air = Air { velocity: [4.0, 0.0, 0.0], gust: Some(gust), ..Air::default() };
/// assert!(air.moves());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Gust {
    /// Root mean square of the gusts' velocity [m/s].
    pub speed: f64,
    /// Size of a gust [m]: two lengths away there is another.
    pub length: f64,
    /// Life of a gust [s]: two periods later there is another.
    pub period: f64,
    /// Another seed, other gusts.
    pub seed: u64,
}

impl Default for Gust {
    fn default() -> Self {
        Self { speed: 1.0, length: 1.0, period: 1.0, seed: 1 }
    }
}

impl Air {
    /// Whether it moves, and so may add energy.
    pub fn moves(&self) -> bool {
        self.velocity != [0.0; 3] || self.is_gusty()
    }

    /// Whether it has gusts.
    pub(crate) fn is_gusty(&self) -> bool {
        self.gust.is_some_and(|gust| gust.speed > 0.0)
    }
}
