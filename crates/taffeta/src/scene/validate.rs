//! Refuses at the door what cannot be simulated, with the place in the scene and what would do.

/// What is wrong with a scene, and where.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{path}: {message}")]
pub struct SceneError {
    /// Place in the scene, as keys and indices: `body[0].springs.structural.k`.
    pub path: String,
    /// What it was and what would do.
    pub message: String,
}

impl SceneError {
    /// An error at `path`.
    pub fn new(path: impl Into<String>, message: impl Into<String>) -> Self {
        Self { path: path.into(), message: message.into() }
    }
}
