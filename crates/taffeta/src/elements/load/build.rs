//! Point loads and torques by solver index.

use crate::assembly::Assembly;
use crate::assembly::body::BodyAssembly;
use crate::motion::keyframes::scale_at;
use crate::plan::Substep;
use crate::real::Real;
use crate::scene::{Force, ScaleKey, SceneError};
use std::collections::HashMap;

/// A load on some nodes.
#[derive(Clone)]
pub struct Load {
    /// Solver indices, ascending.
    pub nodes: Vec<u32>,
    /// What it is.
    pub kind: LoadKind,
    /// Scale over time.
    pub scale: Vec<ScaleKey>,
}

/// What a load is.
#[derive(Clone, Copy, Debug)]
pub enum LoadKind {
    /// A force on each node [N].
    Force([f64; 3]),
    /// A torque [N·m] about a unit axis through a point, shared by the nodes.
    Torque {
        /// Unit axis.
        axis: [f64; 3],
        /// Moment [N·m].
        value: f64,
        /// Point on the axis [m].
        about: [f64; 3],
    },
}

/// Scale of each load at the start of a sub-step.
pub struct Scales<T>(pub Vec<T>);

/// How much of each load acts in a sub-step.
pub fn parameters<T: Real>(assembly: &Assembly, [t, _]: [f64; 2], substep: &mut Substep<T>) {
    if assembly.loads().is_empty() {
        return;
    }
    let scale = |load: &Load| T::from_f64(scale_at(&load.scale, t));
    substep.extensions.insert(Scales(assembly.loads().iter().map(scale).collect()));
}

impl<T: Real> Substep<T> {
    /// Scale of each load at its start.
    pub fn scales(&self) -> &[T] {
        self.extensions.get::<Scales<T>>().map_or(&[], |scales| &scales.0)
    }
}

impl Load {
    /// Whether its scale changes over a span of time [s].
    pub fn changes_over(&self, span: [f64; 2]) -> bool {
        let [before, after] = span.map(|t| scale_at(&self.scale, t));
        before != after || self.scale.iter().any(|key| span[0] < key.t && key.t < span[1])
    }
}

impl Assembly {
    /// Point loads and torques.
    pub fn loads(&self) -> &[Load] {
        self.extensions.list()
    }
}

/// The loads of a scene; it has been validated.
pub(crate) fn loads(bodies: &[BodyAssembly], forces: &[Force]) -> Result<Vec<Load>, SceneError> {
    let by_name: HashMap<&str, &BodyAssembly> =
        bodies.iter().map(|body| (body.name.as_str(), body)).collect();
    let named = |force: &Force| {
        let there_is_none = || SceneError::new("body", format!("there is no body `{}`", force.body));
        by_name.get(force.body.as_str()).copied().ok_or_else(there_is_none)
    };
    let of = |(index, force)| {
        named(force).and_then(|body| load(body, force)).map_err(|e| e.under(&format!("force[{index}]")))
    };
    forces.iter().enumerate().map(of).collect()
}

fn load(body: &BodyAssembly, force: &Force) -> Result<Load, SceneError> {
    let nodes = body.select_loaded(&force.select)?.into_iter();
    let mut nodes: Vec<u32> = nodes.map(|node| body.solver_index(node as usize) as u32).collect();
    nodes.sort_unstable();
    let kind = match (&force.torque, force.force) {
        (Some(torque), _) => {
            let length = torque.axis.iter().map(|c| c * c).sum::<f64>().sqrt();
            LoadKind::Torque {
                axis: torque.axis.map(|c| c / length),
                value: torque.value,
                about: torque.about,
            }
        }
        (None, force) => LoadKind::Force(force.unwrap_or_default()),
    };
    Ok(Load { nodes, kind, scale: force.motion.clone() })
}
