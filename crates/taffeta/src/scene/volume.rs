use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What keeps, or changes, the volume of a soft body.
///
/// ```
/// use taffeta::scene::{Body, Icosphere, Mass, Mesh, Volume};
///
/// // A balloon under 500 Pa.
/// let ball = Mesh::Icosphere(Icosphere { radius: 0.15, subdivisions: 3 });
/// let balloon = Body::soft("balloon", ball).with_mass(Mass::Area(0.3)).structural(100.0, 0.05);
/// let balloon = Body { volume: Some(Volume { pressure: Some(500.0), ..Volume::default() }), ..balloon };
/// assert!(balloon.volume.unwrap().is_pressure());
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Volume {
    /// How the volume is kept.
    pub form: VolumeForm,
    /// The volume to keep, times that at rest; 1 where nothing says otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<f64>,
    /// Instead of a volume to keep: pressure inside above that outside [Pa], below 0 for suction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<f64>,
    /// How the target, or the pressure, changes: linear between keys, from `target` or `pressure` at t = 0 on.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub motion: Vec<VolumeKey>,
    /// Where the body gives way to keep its volume; everywhere, if nothing says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weights: Option<VolumeWeights>,
}

/// How a volume is kept.
///
/// ```
/// use taffeta::scene::{Body, Cube, Mesh, VolumeForm};
///
/// let cube = Mesh::Cube(Cube { size: 0.2, divisions: 4 });
/// let jelly = Body::soft("jelly", cube).keep_volume(VolumeForm::Projected);
/// assert_eq!(jelly.volume.unwrap().form.name(), "projected");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum VolumeForm {
    /// By forces along the gradient of the volume.
    #[default]
    Corrected,
    /// By the same forces, and after contact by moving nodes.
    Projected,
    /// As the programs of Va, Choi and Hong 2023 do it, to compare with: it loses volume.
    #[cfg(feature = "paper-forms")]
    PaperShader,
    /// As Va, Choi and Hong 2023 print it, to compare with: it diverges.
    #[cfg(feature = "paper-forms")]
    Printed,
    /// Not at all.
    None,
}

impl VolumeForm {
    /// Its name in scenes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Corrected => "corrected",
            Self::Projected => "projected",
            #[cfg(feature = "paper-forms")]
            Self::PaperShader => "paper-shader",
            #[cfg(feature = "paper-forms")]
            Self::Printed => "printed",
            Self::None => "none",
        }
    }
}

/// The target, or the pressure, at a time.
///
/// ```
/// use taffeta::scene::{Volume, VolumeKey};
///
/// // Breathes in: within two seconds to 1.25 times its volume at rest.
/// let key = |t, target| VolumeKey { t, target: Some(target), pressure: None };
/// let lung = Volume { motion: vec![key(0.0, 1.0), key(2.0, 1.25)], ..Volume::default() };
/// assert!(!lung.is_pressure());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VolumeKey {
    /// Time [s].
    pub t: f64,
    /// The volume to keep, times that at rest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<f64>,
    /// Pressure [Pa].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pressure: Option<f64>,
}

/// A ball in which a body gives way: fully at its centre, not at all from its radius on.
///
/// ```
/// use taffeta::scene::{Volume, VolumeWeights};
///
/// // Only nodes within 10 cm of the origin give way.
/// let weights = VolumeWeights { center: [0.0; 3], radius: 0.1 };
/// let volume = Volume { weights: Some(weights), ..Volume::default() };
/// assert_eq!(volume.weights.unwrap().radius, 0.1);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VolumeWeights {
    /// Centre in the scene's coordinates, at the start [m].
    pub center: [f64; 3],
    /// Radius [m].
    pub radius: f64,
}

impl Volume {
    /// Whether it is a pressure that is given.
    pub fn is_pressure(&self) -> bool {
        self.pressure.is_some() || self.motion.iter().any(|key| key.pressure.is_some())
    }
}
