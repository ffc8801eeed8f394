//! What can go wrong, and the `Error` that it becomes.

use crate::object::Object;
use taffeta::{Advice, BuildError, Diverged, InputError, StepError};
use taffeta_io::LoadError;
use taffeta_io::scene::{hint, key_of};
use wasm_bindgen::JsValue;

/// What went wrong, before it is an `Error`.
#[derive(Debug)]
pub enum Failure {
    /// The scene is not one, or cannot be simulated; file, line and column where it was written.
    Scene { message: String, place: Option<(String, usize, usize)> },
    /// What was asked of a simulation cannot be.
    Input(String),
    /// A snapshot does not fit.
    Snapshot(String),
    /// A body diverged.
    Diverged(Box<Diverged>),
    /// A mistake of ours.
    Internal(String),
}

impl Failure {
    /// A scene without a text cannot be: `what` names the place in it.
    pub fn scene(what: impl Into<String>) -> Self {
        Self::Scene { message: what.into(), place: None }
    }

    pub fn input(what: impl Into<String>) -> Self {
        Self::Input(what.into())
    }

    /// Why a scene was not loaded. `written` says whether the user has written the text, so that its lines say something.
    pub fn load(error: LoadError, written: bool) -> Self {
        let (message, place) = error.placed(written);
        Self::Scene { message, place }
    }
}

/// What is said, and how to follow the advice in JavaScript.
pub fn advised(message: impl std::fmt::Display, advice: &[Advice]) -> String {
    format!("{message}{}", hint(advice, |one| option(one).or_else(|| key_of(one))))
}

/// The option of `Simulation` that follows a piece of advice.
pub fn option(advice: &Advice) -> Option<String> {
    match advice {
        Advice::SinglePrecision => Some("precision: \"f32\"".to_owned()),
        _ => None,
    }
}

impl From<BuildError> for Failure {
    fn from(error: BuildError) -> Self {
        Self::scene(advised(&error, error.advice()))
    }
}

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        match error {
            InputError::Snapshot(what) => Self::Snapshot(what),
            error => Self::Input(error.to_string()),
        }
    }
}

impl From<StepError> for Failure {
    fn from(error: StepError) -> Self {
        match error {
            StepError::Diverged(diverged) => Self::Diverged(Box::new(diverged)),
            StepError::Input(error) => error.into(),
            error => Self::Internal(error.to_string()),
        }
    }
}

impl From<Failure> for JsValue {
    fn from(failure: Failure) -> Self {
        let named = |name: &str, message: &str| {
            let error = js_sys::Error::new(message);
            error.set_name(name);
            Object::from(error)
        };
        let error = match failure {
            Failure::Scene { message, place } => {
                let error = named("SceneError", &message);
                match place {
                    Some((file, line, column)) => {
                        error.with("file", file).with("line", line as u32).with("column", column as u32)
                    }
                    None => error,
                }
            }
            Failure::Input(message) => named("InputError", &message),
            Failure::Snapshot(message) => named("SnapshotError", &message),
            Failure::Internal(what) => {
                named("InternalError", &format!("a mistake in taffeta, please report it: {what}"))
            }
            Failure::Diverged(diverged) => named("DivergedError", &advised(&diverged, &diverged.advice))
                .with("frame", diverged.frame)
                .with("first", diverged.first)
                .with("body", diverged.body)
                .with("vertex", diverged.vertex as u32)
                .with("what", diverged.what)
                .with("cause", diverged.cause),
        };
        error.into()
    }
}
