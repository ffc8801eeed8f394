use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What keeps, or changes, the volume of a soft body.
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
