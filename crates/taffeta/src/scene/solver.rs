use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How springs are solved.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Solver {
    /// The method for all springs of the scene.
    pub method: Method,
}

/// The method for springs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Explicit springs, symplectic Euler.
    #[default]
    Springs,
}
