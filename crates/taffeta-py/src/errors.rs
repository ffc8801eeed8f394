//! What can go wrong, and the exceptions of `taffeta._errors` that it becomes.

use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use std::panic::{AssertUnwindSafe, catch_unwind};
use taffeta::{Advice, BuildError, Diverged, InputError, StepError};
use taffeta_io::LoadError;
use taffeta_io::scene::{hint, key_of};

/// What went wrong, before it is an exception.
#[derive(Debug)]
pub enum Failure {
    /// The scene is not one, or cannot be simulated.
    Scene { message: String, place: Option<(String, usize, usize)> },
    /// What was asked of a simulation cannot be.
    Input(String),
    /// A snapshot does not fit.
    Snapshot(String),
    /// No device, or one that does not take the scene or answers no more.
    Device(String),
    /// A body diverged.
    Diverged(Box<Diverged>),
    /// A mistake of ours.
    Internal(String),
    /// An exception that came from Python.
    Python(PyErr),
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

/// What is said, and how to follow the advice in Python.
pub fn advised(message: impl std::fmt::Display, advice: &[Advice]) -> String {
    format!("{message}{}", hint(advice, |one| argument(one).or_else(|| key_of(one))))
}

/// The argument of `Simulation` that follows a piece of advice.
pub fn argument(advice: &Advice) -> Option<String> {
    match advice {
        Advice::Cpu => Some("backend=\"cpu\"".to_owned()),
        Advice::SinglePrecision => Some("precision=\"f32\"".to_owned()),
        _ => None,
    }
}

impl From<BuildError> for Failure {
    fn from(error: BuildError) -> Self {
        match error {
            BuildError::Scene(error) => Self::scene(advised(&error, &error.advice)),
            error => Self::Device(advised(&error, error.advice())),
        }
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
            StepError::Stopped { .. } => Self::Internal(error.to_string()),
            error => Self::Device(error.to_string()),
        }
    }
}

impl From<PyErr> for Failure {
    fn from(error: PyErr) -> Self {
        Self::Python(error)
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        Python::attach(|py| exception(py, failure).unwrap_or_else(|error| error))
    }
}

/// The exception for a failure.
fn exception(py: Python<'_>, failure: Failure) -> PyResult<PyErr> {
    let facts = PyDict::new(py);
    let (class, message) = match failure {
        Failure::Python(error) => return Ok(error),
        Failure::Scene { message, place } => {
            if let Some((file, line, column)) = place {
                facts.set_item("file", file)?;
                facts.set_item("line", line)?;
                facts.set_item("column", column)?;
            }
            ("SceneError", message)
        }
        Failure::Input(message) => ("InputError", message),
        Failure::Snapshot(message) => ("SnapshotError", message),
        Failure::Device(message) => ("DeviceError", message),
        Failure::Internal(message) => ("InternalError", message),
        Failure::Diverged(diverged) => {
            facts.update(
                [("frame", diverged.frame), ("first", diverged.first)].into_py_dict(py)?.as_mapping(),
            )?;
            facts.set_item("body", &diverged.body)?;
            facts.set_item("vertex", diverged.vertex)?;
            facts.set_item("what", &diverged.what)?;
            facts.set_item("cause", &diverged.cause)?;
            ("DivergedError", advised(&diverged, &diverged.advice))
        }
    };
    let class = py.import("taffeta._errors")?.getattr(class)?;
    Ok(PyErr::from_value(class.call((message,), Some(&facts))?))
}

/// Does `work`; a panic in it, which is a mistake of ours, is a failure in words.
pub fn guarded<R>(work: impl FnOnce() -> Result<R, Failure>) -> Result<R, Failure> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let words = panic.downcast_ref::<String>().map(String::as_str);
        let words = words.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no words");
        Err(Failure::Internal(format!("a mistake in taffeta, please report it: {words}")))
    })
}
