use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

/// How springs are solved.
///
/// ```
/// use taffeta::scene::{ConstraintForm, Ice, Method, Scene, Solver};
///
/// // Implicit springs solved for velocities: stable at any step.
/// let ice = Ice { form: ConstraintForm::Primal, ..Ice::default() };
/// let solver = Solver { method: Method::Ice, ice, ..Solver::default() };
/// assert!(solver.is_primal());
/// let scene = Scene { solver, ..Scene::new("stiff") };
/// # let _ = scene;
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Solver {
    /// The method for all springs of the scene.
    pub method: Method,
    /// Of the method "ice"; tolerance, iterations and warm start also of "acad".
    pub ice: Ice,
    /// Of the method "acad".
    pub acad: Acad,
    /// Of the method "xpbd".
    pub xpbd: Xpbd,
}

impl Solver {
    /// Whether springs are solved for by nodes.
    pub fn is_primal(&self) -> bool {
        self.method == Method::Ice && self.ice.form == ConstraintForm::Primal
    }

    /// Whether they are, at second order in time.
    pub fn is_second_order(&self) -> bool {
        self.is_primal() && self.ice.order == 2
    }
}

/// The method for springs.
///
/// ```
/// use taffeta::scene::{Method, Scene};
///
/// let scene = Scene::new("stiff cloth at large steps").method(Method::Ice);
/// assert_eq!(scene.solver.method.name(), "ice");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Method {
    /// Explicit springs, symplectic Euler.
    #[default]
    Springs,
    /// Implicit constraint enforcement: every spring is a constraint, as compliant as it is stiff.
    Ice,
    /// Adaptive constraint activation and deactivation: explicit springs, of which those that are too long become
    /// constraints.
    Acad,
    /// Springs as constraints on positions, solved one after the other over several levels: cloth that hardly stretches, in a few
    /// sub-steps a frame.
    Xpbd,
}

impl Method {
    /// Its name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Springs => "springs",
            Self::Ice => "ice",
            Self::Acad => "acad",
            Self::Xpbd => "xpbd",
        }
    }
}

/// Implicit constraint enforcement.
///
/// ```
/// use taffeta::scene::Ice;
///
/// let precise = Ice { tolerance: 1e-6, max_iterations: 500, ..Ice::default() };
/// assert!(precise.tolerance < Ice::default().tolerance);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Ice {
    /// Which equations.
    pub form: ConstraintForm,
    /// Residual at which the solver stops, relative to the right side.
    pub tolerance: f64,
    /// Iterations at which it stops however large the residual is; in the form "primal" in each Newton step.
    pub max_iterations: u32,
    /// Compliance beside that of the material, relative to the diagonal of the system.
    pub epsilon: f64,
    /// Whether the solver starts from the constraint forces of the last sub-step (warm start).
    pub warm_start: bool,
    /// Newton steps in a sub-step, of the form "primal". 0: as many as it needs, one where cloth moves calmly and up to eight where
    /// it folds or turns quickly.
    pub newton_steps: u32,
    /// Order of accuracy in time, of the form "primal": 1, or 2, by which swings hardly lose any height.
    pub order: u32,
}

impl Default for Ice {
    fn default() -> Self {
        Self {
            form: ConstraintForm::Compliant,
            tolerance: 1e-3,
            max_iterations: 200,
            epsilon: 0.0,
            warm_start: true,
            newton_steps: 0,
            order: 1,
        }
    }
}

/// Adaptive constraint activation and deactivation.
///
/// ```
/// use taffeta::scene::{Acad, Method, Scene};
///
/// // Springs become constraints at a stretch of 5 %.
/// let mut scene = Scene::new("").method(Method::Acad);
/// scene.solver.acad = Acad { threshold: 0.05, ..Acad::default() };
/// assert_eq!(scene.solver.acad.threshold, 0.05);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Acad {
    /// A spring longer than (1 + threshold) L becomes a constraint.
    pub threshold: f64,
    /// A constraint shorter than (1 + release) L becomes a spring again.
    pub release: f64,
    /// The length that a constraint aims at is (1 + target) L.
    pub target: f64,
    /// Compliance relative to the diagonal of the system.
    pub epsilon: f64,
    /// Which equations: compliant, or printed where that is built in.
    #[serde(deserialize_with = "acad_form")]
    #[schemars(with = "AcadForm")]
    pub form: ConstraintForm,
}

impl Default for Acad {
    fn default() -> Self {
        Self { threshold: 0.1, release: 0.0, target: 0.0, epsilon: 0.3, form: ConstraintForm::Compliant }
    }
}

/// Springs as constraints on positions.
///
/// ```
/// use taffeta::scene::{Method, Scene, Xpbd};
///
/// // Four sub-steps a frame, for a game.
/// let mut scene = Scene::new("cape").time(1.0 / 60.0, 1.0 / 240.0).method(Method::Xpbd);
/// scene.solver.xpbd = Xpbd { sweeps: 1, ..Xpbd::default() };
/// assert_eq!(scene.solver.xpbd.levels, None);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Xpbd {
    /// Times that all springs act in a sub-step.
    pub sweeps: u32,
    /// Coarser levels, on which nodes some edges apart may not be farther apart than the cloth between them is long. Omitted: as many
    /// as there are. 0: none; then springs alone say how far cloth stretches.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub levels: Option<u32>,
    /// How much longer than at rest those levels let cloth be: 0.05 is 5 %.
    pub stretch_limit: f64,
}

impl Default for Xpbd {
    fn default() -> Self {
        Self { sweeps: 2, levels: None, stretch_limit: 0.0 }
    }
}

/// Equations of constraints.
///
/// ```
/// use taffeta::scene::ConstraintForm;
///
/// assert_eq!(ConstraintForm::Primal.name(), "primal");
/// assert_eq!(ConstraintForm::default(), ConstraintForm::Compliant);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum ConstraintForm {
    /// C = l − L with compliance.
    #[default]
    Compliant = 0,
    /// As Va, Choi and Hong 2021 print them, to compare with: Φ = l² − L², without compliance.
    #[cfg(feature = "paper-forms")]
    Printed = 1,
    /// By nodes: an implicit step of the springs, with their stiffness across; of the method "ice".
    Primal = 2,
}

impl ConstraintForm {
    /// Its name in scenes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Compliant => "compliant",
            #[cfg(feature = "paper-forms")]
            Self::Printed => "printed",
            Self::Primal => "primal",
        }
    }
}

/// The forms that "acad" has.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
enum AcadForm {
    /// C = l − L with compliance.
    Compliant,
    /// As Va, Choi and Hong 2021 print them, to compare with: Φ = l² − L², without compliance.
    #[cfg(feature = "paper-forms")]
    Printed,
}

fn acad_form<'de, D: Deserializer<'de>>(from: D) -> Result<ConstraintForm, D::Error> {
    Ok(match AcadForm::deserialize(from)? {
        AcadForm::Compliant => ConstraintForm::Compliant,
        #[cfg(feature = "paper-forms")]
        AcadForm::Printed => ConstraintForm::Printed,
    })
}
