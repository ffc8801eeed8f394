//! What each sub-step of a frame is told, in the backend's numbers.

use crate::assembly::Assembly;
use crate::collision::shape::ColliderNow;
use crate::integrate::keyframes::{Pose, scale_at};
use crate::real::Real;

/// A sub-step.
pub struct Substep<T> {
    /// Length [s].
    pub h: T,
    /// Length [s], in f64.
    pub seconds: f64,
    /// Poses of each track at its start and at its end.
    pub poses: Vec<(Pose, Pose)>,
    /// Colliders at its end.
    pub colliders: Vec<ColliderNow<T>>,
    /// Scale of each load at its start.
    pub scales: Vec<T>,
    /// Nodes moved by hand: share of the way, of the frame, before and after.
    pub hand: (f64, f64),
    /// Whether it is the last of its frame, after which contacts are counted.
    pub last: bool,
}

/// The sub-steps of the frame that starts at time `start` [s].
pub fn frame<T: Real>(assembly: &Assembly, start: f64) -> Vec<Substep<T>> {
    let time = &assembly.time;
    let count = time.substeps();
    (0..count)
        .map(|index| {
            let (offset, h) = time.substep(index);
            let t = start + offset;
            Substep {
                h: T::from_f64(h),
                seconds: h,
                poses: assembly.tracks.iter().map(|track| (track.pose(t), track.pose(t + h))).collect(),
                colliders: assembly.colliders.iter().map(|collider| collider.at(t, h)).collect(),
                scales: assembly.loads.iter().map(|load| T::from_f64(scale_at(&load.scale, t))).collect(),
                hand: (offset / time.dt, (offset + h) / time.dt),
                last: index + 1 == count,
            }
        })
        .collect()
}
