//! Advice as data: what an error or a warning would have the user change. The engine says so in plain words; a front end
//! names its own setting beside them: a flag, a key of a file, a component.

use serde::{Deserialize, Serialize};
use std::fmt;

/// One thing to change.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Scene};
/// use taffeta::{Advice, Options, Simulation};
///
/// let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Node(1e-3)).structural(1e6, 0.0);
/// let scene = Scene::new("").time(0.01, 0.01).body(cloth);
/// let simulation = Simulation::new(&scene, &Options::default())?;
/// let [warning] = simulation.warnings() else { panic!("one warning") };
/// let [Advice::LongestStep(step), Advice::SolveByNodes] = warning.advice[..] else { panic!("{warning}") };
/// assert!(step <= simulation.largest_stable_step_folded());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Advice {
    /// Run on the CPU instead of a GPU: [`Options::gpu`](crate::Options::gpu) `None`.
    Cpu,
    /// Compute in 32 bits: [`Precision::F32`](crate::Precision::F32).
    SinglePrecision,
    /// Take sub-steps of at most so long [s]: [`Time::max_step`](crate::scene::Time::max_step).
    LongestStep(f64),
    /// Solve springs by nodes: [`Method::Ice`](crate::scene::Method::Ice) in the form
    /// [`ConstraintForm::Primal`](crate::scene::ConstraintForm::Primal).
    SolveByNodes,
    /// Leave springs explicit: [`Method::Springs`](crate::scene::Method::Springs).
    ExplicitSprings,
    /// Keep the volume in the form [`VolumeForm::Corrected`](crate::scene::VolumeForm::Corrected).
    CorrectedVolume,
    /// Make it a soft body: [`Kind::Soft`](crate::scene::Kind::Soft).
    SoftBody,
    /// Make it a cloth: [`Kind::Cloth`](crate::scene::Kind::Cloth).
    Cloth,
    /// Close the holes of a mesh from a file: [`Body::fill_holes`](crate::scene::Body::fill_holes).
    FillHoles,
    /// Blow with the same force on every node: [`World::wind_force`](crate::scene::World::wind_force) in place of
    /// [`World::air`](crate::scene::World::air).
    EvenWind,
}

/// What the user should know, and what to change.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Scene};
/// use taffeta::{Advice, Options, Simulation};
///
/// // A front end that does what it is advised to.
/// let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2)).structural(1e4, 0.0);
/// let mut scene = Scene::new("").time(0.01, 0.01).body(cloth);
/// let simulation = Simulation::new(&scene, &Options::default())?;
/// let warning = &simulation.warnings()[0];
/// assert!(warning.message.starts_with("the step of 1.000e-2 s is longer than the largest stable step"));
/// if let Some(&Advice::LongestStep(step)) = warning.advice.first() {
///     scene.time.max_step = Some(step);
/// }
/// assert!(Simulation::new(&scene, &Options::default())?.warnings().is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Warning {
    /// In words.
    pub message: String,
    /// The settings among what to change, the best first.
    pub advice: Vec<Advice>,
}

impl Warning {
    pub(crate) fn new(message: impl Into<String>, advice: impl Into<Vec<Advice>>) -> Self {
        Self { message: message.into(), advice: advice.into() }
    }
}

impl Warning {
    /// The same advice after what it is for.
    pub(crate) fn after(self, what: String) -> Self {
        Self { message: format!("{what}; {}", self.message), ..self }
    }
}

impl From<String> for Warning {
    fn from(message: String) -> Self {
        Self::new(message, [])
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

/// Two digits, never above.
pub(crate) fn round_down(value: f64) -> f64 {
    if !(value.is_finite() && value > 0.0) {
        return value;
    }
    let unit = 10_f64.powf(value.log10().floor() - 1.0);
    // A hair of slack: 3.9e-3 has two digits already, though it is stored as a little less.
    let text = format!("{:.1e}", (value / unit * (1.0 + 1e-12)).floor() * unit);
    text.parse().unwrap_or(value)
}

/// The device cannot run the scene.
///
/// ```
/// use taffeta::{Advice, BuildError, Refusal};
///
/// // A program that opens devices itself, and found none.
/// let error = BuildError::from(Refusal::new("no GPU was found; the CPU would do", [Advice::Cpu]));
/// assert_eq!(error.to_string(), "no GPU was found; the CPU would do");
/// assert_eq!(error.advice(), [Advice::Cpu]);
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}")]
#[non_exhaustive]
pub struct Refusal {
    /// Why, and what would do.
    pub message: String,
    /// The settings among what would do, the best first.
    pub advice: Vec<Advice>,
}

impl Refusal {
    /// A refusal with advice.
    pub fn new(message: impl Into<String>, advice: impl Into<Vec<Advice>>) -> Self {
        Self { message: message.into(), advice: advice.into() }
    }
}

impl From<String> for Refusal {
    fn from(message: String) -> Self {
        Self::new(message, [])
    }
}

impl From<&str> for Refusal {
    fn from(message: &str) -> Self {
        Self::new(message, [])
    }
}
