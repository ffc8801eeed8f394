//! Poses of a mesh: those of the scene, resampled by sub-steps.

use crate::real::{add, scale, sub};
use crate::scene::LARGEST_LENGTH;
use crate::scene::{Poses, SceneError};
use crate::topology::{Surface, measure};

/// Positions of all nodes [m].
type Pose = Vec<[f64; 3]>;

/// The times of a mesh's poses.
#[derive(Clone, Copy, Debug)]
pub struct Timing {
    /// Time between poses, and that of the first [s].
    interval: f64,
    start: f64,
    /// The end of its motion, counted in poses.
    end: f64,
}

/// Relative tolerance for sub-steps that should be as long as the time between poses.
const SLACK: f64 = 1e-6;

impl Timing {
    /// The times of a rigid mesh.
    pub const STILL: Self = Self { interval: 1.0, start: 0.0, end: 0.0 };

    /// A time [s] counted in poses.
    pub fn in_poses(&self, t: f64) -> f64 {
        ((t - self.start) / self.interval).clamp(0.0, self.end)
    }

    /// Resamples poses so that a sub-step of at most `step` [s] sees at most two consecutive ones. If poses follow
    /// each other faster, they are interpolated every `step`: a sub-step knows the mesh at its two ends only. The
    /// last of them is then beyond the end, by extrapolation.
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
    from.iter().zip(to).map(|(from, to)| add(*from, scale(sub(*to, *from), fraction))).collect()
}

/// Fraction of the mesh's volume by which a pose may be inverted, so that a mesh can be laid flat.
const FLAT: f64 = 1e-3;

/// The nodes in each pose of a mesh of the scene, which has an inside or not.
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
