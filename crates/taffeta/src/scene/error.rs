//! What is wrong with a scene.

use crate::advice::Advice;

/// What is wrong with a scene, and where.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Scene};
///
/// let chain = Body::cloth("chain", Mesh::chain(3, 1.0)).with_mass(Mass::Node(0.1));
/// let error = Scene::new("").time(0.01, -1.0).body(chain).validate().unwrap_err();
/// assert_eq!(error.to_string(), "time.max_step: is -1 s, more than 0 would do");
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{path}: {message}")]
#[non_exhaustive]
pub struct SceneError {
    /// Place in the scene, as keys and indices: `body[0].springs.structural.k`.
    pub path: String,
    /// What it was and what would do.
    pub message: String,
    /// The settings among what would do that stand elsewhere or have few choices.
    pub advice: Vec<Advice>,
}

impl SceneError {
    /// An error at `path`.
    pub fn new(path: impl Into<String>, message: impl Into<String>) -> Self {
        Self { path: path.into(), message: message.into(), advice: Vec::new() }
    }

    /// With a setting that would do.
    pub fn advise(mut self, advice: Advice) -> Self {
        self.advice.push(advice);
        self
    }
}
