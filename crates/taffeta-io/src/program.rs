//! What the programs of this workspace share: how they end, what they say, and that only one works in a folder at a time.

#[cfg(feature = "gpu")]
mod choice;
mod lock;
mod machine;
mod memory;
pub mod pose;
mod words;
mod world;

#[cfg(feature = "gpu")]
pub use choice::{Work, at_once, faster, only_software, too_many};
pub use lock::RunLock;
pub use machine::processor;
pub use memory::{FreeMemory, free_memory, short_of_memory, size};
pub use words::one_line;
pub use world::changed;

use crate::scene::{hint, key_of};
use crate::{LoadError, MeshFormat, Place, SceneSource};
use std::fmt::{self, Display};
use std::io::{self, ErrorKind, Write};
use std::path::Path;
use std::process::ExitCode;
use taffeta::{Advice, BuildError};

/// Why a program does not end well.
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
    pub fn code(&self) -> u8 {
        match self {
            Self::Work(_) => 1,
            Self::Input(_) => 2,
            Self::Interrupted(_) => 130,
        }
    }
}

impl Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input(message) | Self::Work(message) => write!(f, "error: {message}"),
            Self::Interrupted(message) => f.write_str(message),
        }
    }
}

impl From<LoadError> for Failure {
    fn from(error: LoadError) -> Self {
        Self::Input(match &error.place {
            Place::Set(_) => format!("--set {error}"),
            Place::File(file) if MeshFormat::of(Path::new(file)).is_ok() => {
                format!("{error}; `taffeta check {file}` prints a scene for it")
            }
            _ => error.to_string(),
        })
    }
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::Work(error.to_string())
    }
}

/// What the engine says, and how to follow its advice: flags of our programs, keys of the scene.
pub fn advised(message: impl Display, advice: &[Advice]) -> String {
    format!("{message}{}", hint(advice, |one| flag(one).or_else(|| key_of(one))))
}

/// Why a scene was not built, by its line.
pub fn not_built(source: &SceneSource, error: &BuildError) -> Failure {
    let mut located = source.explain_build(error);
    located.message += &hint(error.advice(), flag);
    if matches!(error, BuildError::Lost(_)) { Failure::Work(located.to_string()) } else { located.into() }
}

/// The flag of our programs that follows a piece of advice.
fn flag(advice: &Advice) -> Option<String> {
    match advice {
        Advice::Cpu => Some("--backend cpu".to_owned()),
        Advice::SinglePrecision => Some("--precision f32".to_owned()),
        _ => None,
    }
}

/// The one place that turns endings into exit codes.
pub fn end(result: Result<(), Failure>) -> ExitCode {
    let Err(failure) = result else { return ExitCode::SUCCESS };
    complain(&failure.to_string());
    failure.code().into()
}

/// Writes `text` and a line end to standard output, with escapes for what would steer a terminal. Unlike `println!`, this does not
/// panic when the reader has gone away.
///
/// # Errors
/// Where standard output takes no more, as on a full disk.
pub fn say(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match writeln!(out, "{}", words::lines(text)).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::Work(format!("standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Writes `text` and a line end to standard error, as [`say`] does to standard output.
pub fn complain(text: &str) {
    // Where standard error is closed there is nobody left to tell.
    let _ = writeln!(io::stderr(), "{}", words::lines(text));
}

/// Keeps Vulkan's device selection from complaining on a machine without a desktop: it looks for one in the folder that
/// `XDG_RUNTIME_DIR` names. What it gets is a path with nothing at it, where nobody else can put something. Nothing complains
/// on other systems than Linux.
///
/// # Safety
/// No other thread may be running.
pub unsafe fn expect_no_desktop() {
    let name = "XDG_RUNTIME_DIR";
    if cfg!(target_os = "linux") && std::env::var_os(name).is_none_or(|value| value.is_empty()) {
        // SAFETY: the caller says that this is the only thread.
        unsafe { std::env::set_var(name, "/nonexistent") };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endings_have_the_codes_and_words_that_scripts_rely_on() {
        let words = || "why".to_owned();
        let endings =
            [Failure::Work(words()), Failure::Input(words()), Failure::Interrupted(words())].map(|failure| {
                let said = failure.to_string();
                (failure.code(), said)
            });
        assert_eq!(endings, [(1, "error: why".into()), (2, "error: why".into()), (130, "why".into())]);
        assert!(matches!(Failure::from(io::Error::other("disk")), Failure::Work(said) if said == "disk"));
    }
}
