//! The ways of solving springs that are compared.

use serde::{Deserialize, Serialize};
use taffeta::scene::{ConstraintForm, Ice, Method as Of, Solver};

/// Iterations that are as many as are needed.
const MANY: u32 = 5000;

/// A way of solving springs.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Explicit springs.
    #[default]
    Springs,
    /// Springs as compliant constraints.
    Dual,
    /// The same with as many iterations as the tolerance asks for.
    DualSolved,
    /// Springs solved for by nodes.
    Primal,
    /// Explicit springs, of which those that are too long become constraints.
    Acad,
    /// The classical method of Runge and Kutta in 32 bits; not of the engine.
    Rk4,
    /// The same in 64 bits.
    Rk4F64,
}

impl Method {
    /// All, in the order of tables.
    pub const ALL: [Self; 7] =
        [Self::Springs, Self::Dual, Self::DualSolved, Self::Primal, Self::Acad, Self::Rk4, Self::Rk4F64];

    /// In names of runs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Springs => "springs",
            Self::Dual => "dual",
            Self::DualSolved => "dual-solved",
            Self::Primal => "primal",
            Self::Acad => "acad",
            Self::Rk4 => "rk4",
            Self::Rk4F64 => "rk4-f64",
        }
    }

    /// In tables and plots.
    pub fn label(self) -> &'static str {
        match self {
            Self::DualSolved => "dual, solved",
            Self::Rk4 => "RK4",
            Self::Rk4F64 => "RK4, 64 bits",
            engine => engine.name(),
        }
    }

    /// Whether the engine has it.
    pub fn of_engine(self) -> bool {
        !matches!(self, Self::Rk4 | Self::Rk4F64)
    }

    /// The settings of a scene.
    pub fn solver(self) -> Solver {
        let (method, form) = match self {
            Self::Dual | Self::DualSolved => (Of::Ice, ConstraintForm::Compliant),
            Self::Primal => (Of::Ice, ConstraintForm::Primal),
            Self::Acad => (Of::Acad, ConstraintForm::Compliant),
            _ => (Of::Springs, ConstraintForm::Compliant),
        };
        let mut ice = Ice { form, ..Ice::default() };
        if self == Self::DualSolved {
            ice.max_iterations = MANY;
        }
        Solver { method, ice, ..Solver::default() }
    }
}
