//! Why a scene does not run, and why a run cannot go on.

use super::input::InputError;
use crate::advice::{Advice, Refusal};
use crate::scene::SceneError;
use serde::{Deserialize, Serialize};

/// A run that cannot go on.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Scene, Select};
/// use taffeta::{Advice, Options, Simulation, StepError};
///
/// // Too stiff for its step.
/// let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Node(1e-3)).structural(1e6, 0.0);
/// let scene = Scene::new("bursts").time(0.01, 0.01).body(cloth.pin(Select::nodes([0])));
/// let mut simulation = Simulation::new(&scene, &Options::default())?;
/// simulation.disturb(1e-3, 1);
/// let Err(StepError::Diverged(end)) = (0..100).try_for_each(|_| simulation.step().map(drop)) else {
///     panic!("it held");
/// };
/// assert_eq!(end.body, "cloth");
/// assert!(matches!(end.advice[..], [Advice::LongestStep(_), ..]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[error("{}: body `{body}`, vertex {vertex}: {what}. {cause}", named(.first, .frame))]
#[non_exhaustive]
pub struct Diverged {
    /// The first frame that may have failed; the one before it was good.
    pub first: u32,
    /// The frame after which that was seen. Later than `first` where several were submitted before one was looked at.
    pub frame: u32,
    /// Name of the body.
    pub body: String,
    /// Vertex in the mesh's own order.
    pub vertex: usize,
    /// What was seen.
    pub what: String,
    /// Likely cause, and what to change.
    pub cause: String,
    /// The settings among what to change, the best first.
    pub advice: Vec<Advice>,
}

/// Frames in words.
fn named(first: &u32, last: &u32) -> String {
    if first == last {
        format!("frame {last}")
    } else {
        format!("by frame {last} (frame {} was good)", first - 1)
    }
}

/// Why a scene does not run.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Scene};
/// use taffeta::{BuildError, Options, Simulation};
///
/// let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(-1.0));
/// match Simulation::new(&Scene::new("").body(cloth), &Options::default()) {
///     Err(BuildError::Scene(error)) => assert_eq!(error.path, "body[0].area_density"),
///     Err(error) => panic!("the device does not take it: {error}"),
///     Ok(_) => panic!("it runs"),
/// }
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// The scene cannot be simulated.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The device cannot run it.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The device does not answer any more.
    #[error("{0}")]
    Lost(String),
}

impl BuildError {
    /// The settings among what would do, the best first.
    pub fn advice(&self) -> &[Advice] {
        match self {
            Self::Scene(error) => &error.advice,
            Self::Refused(refusal) => &refusal.advice,
            Self::Lost(_) => &[],
        }
    }
}

/// Why a frame could not be done, or drawn.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Scene, Select};
/// use taffeta::{Advice, Options, Simulation};
///
/// // Too stiff for its step. What the error advises holds.
/// let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2)).structural(1e6, 0.0);
/// let mut scene = Scene::new("bursts").time(0.01, 0.01).body(cloth.pin(Select::nodes([0])));
/// let mut simulation = Simulation::new(&scene, &Options::default())?;
/// simulation.disturb(1e-3, 1);
/// let error = (0..100).find_map(|_| simulation.step().err()).expect("it bursts");
/// let [Advice::LongestStep(step), ..] = *error.advice() else { panic!("{error}") };
/// scene.time.max_step = Some(step);
/// let mut simulation = Simulation::new(&scene, &Options::default())?;
/// simulation.disturb(1e-3, 1);
/// assert_eq!(simulation.advance(10)?.frame, 10);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StepError {
    /// The scene cannot go on.
    #[error(transparent)]
    Diverged(#[from] Diverged),
    /// The frame was stopped on its way ([`crate::Simulation::step_unless`]).
    #[error("frame {frame} was stopped on its way; a snapshot from before it would do to go on")]
    Stopped {
        /// The frame; the one before it was good.
        frame: u32,
    },
    /// The device that computes does not answer any more.
    #[error("frame {frame}: {why}")]
    Lost {
        /// The frame that failed; the one before it was good.
        frame: u32,
        /// What the device said.
        why: String,
    },
    /// What was asked for cannot be: to draw what is not there, or more frames than are counted.
    #[error(transparent)]
    Input(#[from] InputError),
}

impl StepError {
    /// The settings among what to change, the best first.
    pub fn advice(&self) -> &[Advice] {
        match self {
            Self::Diverged(diverged) => &diverged.advice,
            Self::Stopped { .. } | Self::Lost { .. } | Self::Input(_) => &[],
        }
    }
}
