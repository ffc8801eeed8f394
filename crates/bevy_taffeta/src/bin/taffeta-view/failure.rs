//! The one place that turns endings into exit codes, those of the program `taffeta`.

use std::fmt;
use std::process::ExitCode;

/// Why the program does not end well.
#[derive(Debug)]
pub enum Failure {
    /// Bad input or usage.
    Input(String),
    /// The work failed: diverged, disk full.
    Work(String),
    /// The user stopped it.
    Interrupted(String),
}

impl Failure {
    /// The exit code, as scripts rely on it.
    pub fn code(&self) -> ExitCode {
        match self {
            Self::Work(_) => ExitCode::from(1),
            Self::Input(_) => ExitCode::from(2),
            Self::Interrupted(_) => ExitCode::from(130),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input(message) | Self::Work(message) => write!(f, "error: {message}"),
            Self::Interrupted(message) => f.write_str(message),
        }
    }
}

impl From<taffeta_io::LoadError> for Failure {
    fn from(error: taffeta_io::LoadError) -> Self {
        Self::Input(error.to_string())
    }
}
