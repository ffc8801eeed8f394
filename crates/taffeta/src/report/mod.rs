//! What a frame was in numbers: what users read, and the sums that backends make it of.

pub(crate) mod sums;

use serde::{Deserialize, Serialize};
use std::borrow::Cow;
pub(crate) use sums::{FrameSums, PairSums, StateSums};

/// One frame in numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameReport {
    /// Frame number; 0 is the start.
    pub frame: u32,
    /// Time [s].
    pub time: f64,
    /// ½ Σ m v² [J].
    pub kinetic: f64,
    /// −Σ m g·x [J].
    pub gravitational: f64,
    /// ½ Σ k (l − L)² over all springs [J].
    pub springs: f64,
    /// Energy of other elements that the scene has, kind by kind.
    pub elements: Vec<ElementEnergy>,
    /// Σ m v [kg·m/s].
    pub momentum: [f64; 3],
    /// Σ m x × v [kg·m²/s], about the origin.
    pub angular_momentum: [f64; 3],
    /// Largest l/L over all springs; 1 without springs.
    pub max_stretch: f64,
    /// Nodes that touched a collider in the frame's last sub-step.
    pub contacts: u64,
    /// Volume of each body [m³], where it is closed.
    pub volumes: Vec<Option<f64>>,
    /// Volume that each body is to have at this time [m³], where it keeps one.
    pub volume_targets: Vec<Option<f64>>,
    /// Pairs of nodes that were nearer than their thickness in the frame's last sub-step.
    pub pairs: u64,
    /// Least distance of such a pair before it was pushed apart, by its thickness.
    pub nearest_pair: Option<f64>,
    /// Times that neighbours were searched for in the frame. It may depend on the number of threads; nothing else does.
    pub pair_searches: u64,
    /// What the solver of constraints did; all zero where there are none.
    pub solver: SolverReport,
    /// Joints of seams and pins that are broken at the end of the frame.
    pub broken: u64,
}

/// Energy of all elements of one kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ElementEnergy {
    /// The kind: `hinges`.
    pub kind: Cow<'static, str>,
    /// Energy [J].
    pub energy: f64,
}

impl ElementEnergy {
    /// Of a kind, in joules.
    pub(crate) fn new(kind: &'static str, energy: f64) -> Self {
        Self { kind: kind.into(), energy }
    }
}

/// What the solver of constraints did in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SolverReport {
    /// Most iterations of a sub-step.
    pub iterations: u32,
    /// Largest residual of a sub-step: relative to the right side; of the form "primal", the error in the norm of the energy,
    /// relative to what the sub-step gives.
    pub residual: f64,
    /// Largest share of the springs that were constraints in a sub-step.
    pub active_fraction: f64,
    /// Sub-steps that ended with a residual beyond the tolerance.
    pub capped: u32,
}

impl FrameReport {
    /// Total energy [J].
    pub fn energy(&self) -> f64 {
        self.kinetic + self.gravitational + self.springs + self.energy_of_elements()
    }

    /// Energy of one kind of elements [J]; 0 where the scene has none.
    pub fn energy_of(&self, kind: &str) -> f64 {
        self.elements.iter().find(|one| one.kind == kind).map_or(0.0, |one| one.energy)
    }

    /// Energy of all elements but springs [J].
    pub fn energy_of_elements(&self) -> f64 {
        self.elements.iter().map(|one| one.energy).sum()
    }

    /// Whether every number is finite; a node that is not shows in the sums.
    pub fn is_finite(&self) -> bool {
        let momentum: f64 = self.momentum.iter().sum();
        self.energy().is_finite() && momentum.is_finite() && self.max_stretch.is_finite()
    }
}
