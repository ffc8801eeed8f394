//! What keeps the volume of a body, or what pressure it is under.

use crate::assembly::Assembly;
use crate::plan::Substep;
use crate::real::Real;
use crate::volume::volume::Form;

/// What keeps the volume of a body, or what pressure it is under.
#[derive(Clone, Debug)]
pub struct VolumeConstraint {
    /// How the multiplier is found.
    pub form: Form,
    /// Whether nodes are moved after contact.
    pub projects: bool,
    /// Weight of each node in solver order; `None`: 1.
    pub weights: Option<Vec<f64>>,
    /// Times [s] and volumes to keep [m³], or pressures [Pa].
    pub(crate) keys: Vec<(f64, f64)>,
}

impl VolumeConstraint {
    /// The volume to keep [m³], or the pressure [Pa], at time `t` [s].
    pub fn goal(&self, t: f64) -> f64 {
        let after = self.keys.partition_point(|key| key.0 <= t);
        match (after.checked_sub(1).map(|before| self.keys[before]), self.keys.get(after)) {
            (Some((t0, a)), Some(&(t1, b))) => a + (b - a) * (t - t0) / (t1 - t0),
            (Some((_, goal)), None) | (None, Some(&(_, goal))) => goal,
            (None, None) => 0.0,
        }
    }

    /// The volume to keep [m³] at time `t` [s], if it is one.
    pub fn target(&self, t: f64) -> Option<f64> {
        (self.form != Form::Pressure).then(|| self.goal(t))
    }

    /// Whether that changes over a span of time [s].
    pub fn changes_over(&self, [from, to]: [f64; 2]) -> bool {
        self.goal(from) != self.goal(to) || self.keys.iter().any(|key| from < key.0 && key.0 < to)
    }

    /// Whether it may add energy: by a pressure, or a volume other than that at rest.
    pub fn drives(&self, rest: f64) -> bool {
        self.form == Form::Pressure || self.keys.iter().any(|key| key.1 != rest)
    }
}

/// Target volume of each body of [`Assembly::volumes`] at the end of a sub-step [m³], or its pressure [Pa].
#[derive(Default)]
pub struct Goals<T>(pub Vec<T>);

/// What volumes are to be in a sub-step.
pub fn parameters<T: Real>(assembly: &Assembly, [t, h]: [f64; 2], substep: &mut Substep<T>) {
    if assembly.volumes().next().is_none() {
        return;
    }
    let goals = assembly.volumes().map(|(_, kept)| T::from_f64(kept.goal(t + h)));
    substep.extensions.insert(Goals(goals.collect()));
}

impl<T: Real> Substep<T> {
    /// Target volume of each body of [`Assembly::volumes`] at its end [m³], or its pressure [Pa].
    pub fn goals(&self) -> &[T] {
        self.extensions.get::<Goals<T>>().map_or(&[], |goals| &goals.0)
    }
}
