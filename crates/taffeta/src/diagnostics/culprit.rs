//! What sets the largest stable step: springs of a kind, elements of a kind or drag, by their stiffness or their damping.

use crate::assembly::springs::SpringKind;
use crate::elements::{bending, hinge, membrane};
use std::fmt;

/// What resists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// Springs of a kind.
    Springs(SpringKind),
    /// Elements of a kind, by its name: `hinges`, `membranes`, `bends`.
    Elements(&'static str),
    /// Drag on nodes.
    Drag,
}

/// How something resists: its stiffness, or its damping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// What.
    pub source: Source,
    /// By damping, or by stiffness.
    pub is_damping: bool,
}

/// What a scene says of a part.
pub(crate) enum Given {
    /// The number itself, in the unit of a mode.
    Itself,
    /// A time [s], times the stiffness.
    Time,
    /// Several numbers.
    Tensor,
}

/// What a scene says of elements of a kind.
pub(crate) fn given(kind: &str, is_damping: bool) -> Given {
    match kind {
        hinge::NAME => Given::Itself,
        _ if is_damping => Given::Time,
        _ => Given::Tensor,
    }
}

/// What sets the largest stable step of a scene, and so what to change for a longer one.
///
/// ```
/// use taffeta::diagnostics::culprit::Source;
/// use taffeta::scene::{Body, Mass, Mesh, Scene};
/// use taffeta::{Options, Simulation};
///
/// let flag = Body::cloth("flag", Mesh::grid(20, 30, [1.5, 1.0])).with_mass(Mass::Area(0.2));
/// let scene = Scene::new("").time(0.01, 1e-4).body(flag.structural(100.0, 0.01).hinge(1e-4, 1e-3));
/// let simulation = Simulation::new(&scene, &Options { find_largest_steps: true, ..Options::default() })?;
/// let culprit = simulation.largest_step_culprit().expect("springs and hinges resist");
/// assert_eq!((culprit.part.source, culprit.part.is_damping), (Source::Elements("hinges"), true));
/// assert_eq!(culprit.to_string(), "the damping d = 1e-3 N·m·s/rad of hinges of body `flag`");
/// // Without it, steps could be much longer.
/// assert!(culprit.without > Some(20.0 * simulation.largest_stable_step_folded()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Culprit {
    /// Name of the body.
    pub body: String,
    /// The vertex, in the mesh's own order, that moves most in the mode that sets the step.
    pub vertex: usize,
    /// What resists most in this mode.
    pub part: Part,
    /// The number that the scene gives, in the unit of [`Self::unit`]; `None` for the stiffness of a fabric, which is several.
    pub value: Option<f64>,
    /// Its fraction of all that resists in this mode, 0 to 1.
    pub share: f64,
    /// Largest stable step [s], however springs are folded, if there were nothing else; only if the scene's step is too long.
    pub alone: Option<f64>,
    /// The same without it; only if the scene's step is too long.
    pub without: Option<f64>,
    /// What to multiply it by so that the scene's step is stable; only if it is too long, and this would do.
    pub factor: Option<f64>,
}

impl Culprit {
    /// The unit of its value.
    pub fn unit(&self) -> &'static str {
        match (self.part.source, self.part.is_damping) {
            (Source::Springs(_), false) => "N/m",
            (Source::Springs(_), true) | (Source::Drag, _) => "kg/s",
            (Source::Elements(hinge::NAME), false) => "N·m/rad",
            (Source::Elements(hinge::NAME), true) => "N·m·s/rad",
            (Source::Elements(_), _) => "s",
        }
    }

    /// How it resists: `stiffness` or `damping`.
    pub fn quantity(&self) -> &'static str {
        if self.part.is_damping { "damping" } else { "stiffness" }
    }

    /// What resists, in words: `structural springs`, `hinges`.
    pub fn name(&self) -> String {
        match self.part.source {
            Source::Springs(kind) => format!("{} springs", kind.name()),
            Source::Elements(kind) => kind.replace('_', " "),
            Source::Drag => "drag".to_owned(),
        }
    }

    /// Without the body.
    fn what(&self) -> String {
        let quantity = self.quantity();
        let value = |letter: &str| {
            self.value.map_or_else(String::new, |value| format!("{letter}{} {}", short(value), self.unit()))
        };
        let letter = if self.part.is_damping { " d = " } else { " k = " };
        match self.part.source {
            Source::Springs(_) | Source::Elements(hinge::NAME) => {
                format!("{quantity}{} of {}", value(letter), self.name())
            }
            Source::Elements(membrane::NAME) => format!("stretch {quantity}{} of the fabric", value(" ")),
            Source::Elements(bending::NAME) => format!("bending {quantity}{} of the fabric", value(" ")),
            Source::Elements(_) => format!("{quantity} of {}", self.name()),
            Source::Drag => format!("drag{}", value(" ")),
        }
    }

    /// What it allows and what would do without it, where the step is too long; else nothing.
    pub(crate) fn words(&self) -> Option<String> {
        let (alone, without) = (self.alone?, self.without?);
        let without = if without.is_finite() { format!("{without:.3e} s") } else { "any step".to_owned() };
        Some(format!("{self} allows {alone:.3e} s alone, and without it {without} would do"))
    }

    /// How to change it, and nothing else, so that the step is stable, where that would do.
    pub(crate) fn remedy(&self) -> Option<String> {
        let factor = self.factor?;
        let down = crate::advice::round_down;
        Some(match self.value {
            Some(value) if down(value * factor) > 0.0 => {
                format!("lower the {} to {}", self.what(), short(down(value * factor)))
            }
            _ => format!("multiply the {} by {}", self.what(), short(down(factor))),
        })
    }
}

impl fmt::Display for Culprit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.part.source {
            Source::Drag => write!(f, "the {} on body `{}`", self.what(), self.body),
            _ => write!(f, "the {} of body `{}`", self.what(), self.body),
        }
    }
}

/// A number of at most three digits, as one writes it.
fn short(value: f64) -> String {
    let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    if (0.01..10_000.0).contains(&rounded.abs()) { format!("{rounded}") } else { format!("{rounded:e}") }
}
