//! Ways of solving springs.

use serde::{Deserialize, Serialize};
use taffeta::scene::{ConstraintForm, Ice, Method, Solver};

/// A way of solving springs.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Way {
    /// Explicit springs.
    #[default]
    Springs,
    /// Springs as constraints, with the solver's settings as they are by default.
    Dual,
    /// Springs as constraints, with as many iterations as the tolerance asks for.
    DualSolved,
    /// Springs solved for by nodes, by default as well.
    Primal,
}

/// Iterations that are as many as are needed.
const MANY: u32 = 5000;

impl Way {
    /// All, in the order of tables.
    pub const ALL: [Self; 4] = [Self::Springs, Self::Dual, Self::DualSolved, Self::Primal];

    /// In tables and plots.
    pub fn label(self) -> &'static str {
        match self {
            Self::Springs => "springs",
            Self::Dual => "dual",
            Self::DualSolved => "dual, solved",
            Self::Primal => "primal",
        }
    }

    /// The settings of a scene.
    pub fn solver(self) -> Solver {
        let ice = |form, max_iterations| Ice { form, max_iterations, ..Ice::default() };
        let by_default = Ice::default().max_iterations;
        let (method, ice) = match self {
            Self::Springs => (Method::Springs, Ice::default()),
            Self::Dual => (Method::Ice, ice(ConstraintForm::Compliant, by_default)),
            Self::DualSolved => (Method::Ice, ice(ConstraintForm::Compliant, MANY)),
            Self::Primal => (Method::Ice, ice(ConstraintForm::Primal, by_default)),
        };
        Solver { method, ice, ..Solver::default() }
    }
}
