//! Poses that a mesh goes through: those of the scene, and those that sub-steps can tell apart.

use crate::contact::collider_mesh::triangle::between;
use crate::scene::LARGEST_LENGTH;
use crate::scene::{Poses, SceneError};
use crate::topology::{Surface, measure};

/// Places of all nodes [m].
type Pose = Vec<[f64; 3]>;

/// When a mesh is in which pose.
#[derive(Clone, Copy, Debug)]
pub struct Timing {
    /// Time between poses, and when it is in the first [s].
    interval: f64,
    start: f64,
    /// When it stands still, counted in poses.
    end: f64,
}

/// By how much of the time between poses a sub-step may be longer: that much is rounding of what was meant to be as long.
const SLACK: f64 = 1e-6;

impl Timing {
    /// Of a mesh that keeps its shape.
    pub const STILL: Self = Self { interval: 1.0, start: 0.0, end: 0.0 };

    /// A time [s] counted in poses.
    pub fn in_poses(&self, t: f64) -> f64 {
        ((t - self.start) / self.interval).clamp(0.0, self.end)
    }

    /// Poses of which a sub-step of at most `step` [s] sees no more than two on end. Where they come faster, those are taken
    /// in which the mesh is every `step`: a sub-step knows the mesh at its two ends anyway. The last of them then lies
    /// beyond the end, where the way to it would lead.
    pub fn fit(given: Vec<Pose>, poses: &Poses, step: f64) -> (Vec<Pose>, Self) {
        let Poses { interval, start, .. } = *poses;
        let last = given.len() as f64 - 1.0;
        if given.len() == 1 || step <= interval * (1.0 + SLACK) {
            return (given, Self { interval, start, end: last });
        }
        let (ratio, to) = (step / interval, &given[given.len() - 1]);
        let mut end = last / ratio;
        let whole = (end + SLACK).floor();
        let rest = end - whole;
        let mut kept: Vec<Pose> = (0..=whole as usize).map(|i| at(&given, i as f64 * ratio)).collect();
        let from = kept.len() - 1;
        if rest > SLACK || whole == 0.0 {
            kept.push(mixed(&kept[from], to, 1.0 / rest));
        } else {
            kept[from].clone_from(to);
            end = whole;
        }
        (kept, Self { interval: step, start, end })
    }
}

/// The shape at a time counted in poses.
pub fn at(poses: &[Pose], time: f64) -> Pose {
    let pose = (time.floor() as usize).min(poses.len() - 1);
    let next = (pose + 1).min(poses.len() - 1);
    mixed(&poses[pose], &poses[next], time - pose as f64)
}

fn mixed(from: &Pose, to: &Pose, fraction: f64) -> Pose {
    from.iter().zip(to).map(|(from, to)| between(*from, *to, fraction)).collect()
}

/// Share of the mesh's volume that a pose may have turned over: a mesh may be laid flat.
const FLAT: f64 = 1e-3;

/// The nodes in each pose that the scene gives of a mesh, which has an inside or not.
pub fn given(poses: &Poses, surface: &Surface, solid: bool) -> Result<Vec<Pose>, SceneError> {
    let refuse = |message: String| Err(SceneError::new("poses", message));
    if poses.nodes.is_empty() {
        return refuse("has none; one or more would do".to_owned());
    }
    let volume = measure::volume(&surface.nodes, &surface.triangles);
    for (i, pose) in poses.nodes.iter().enumerate() {
        if pose.len() != surface.nodes.len() {
            let (have, want) = (pose.len(), surface.nodes.len());
            return refuse(format!("pose {i} has {have} nodes, the mesh {want}; as many would do"));
        }
        if let Some(node) = pose.iter().position(|x| x.iter().any(|x| !x.is_finite())) {
            return refuse(format!(
                "node {node} of pose {i} is at {:?}; finite numbers would do",
                pose[node]
            ));
        }
        if let Some(node) = pose.iter().position(|x| x.iter().any(|x| x.abs() > LARGEST_LENGTH)) {
            let x = pose[node];
            return refuse(format!(
                "node {node} of pose {i} is at {x:?} m; within ±{LARGEST_LENGTH} m would do"
            ));
        }
        let turned = measure::volume(pose, &surface.triangles);
        if solid && turned < -FLAT * volume {
            return refuse(format!(
                "pose {i} turns the mesh inside out: it has a volume of {turned:e} m³, the mesh of {volume:e} m³; one with its \
                 faces outward would do"
            ));
        }
    }
    Ok(poses.nodes.iter().map(|pose| pose.to_vec()).collect())
}
