//! The parameters of each sub-step of a frame, in the backend's numbers.

use crate::build::Assembly;
use crate::contact::colliders::moving::ColliderNow;
use crate::elements::aero::aero::AirNow;
use crate::motion::keyframes::{Track, scale_at};
use crate::motion::pins::Motion;
use crate::real::Real;

/// The parameters of a sub-step.
pub struct Substep<T> {
    /// Length [s].
    pub h: T,
    /// Gravity [m/s²].
    pub gravity: [f64; 3],
    /// Force of the wind on each node [N].
    pub wind_force: [f64; 3],
    /// Linear drag [kg/s].
    pub drag: f64,
    /// Motion of each track.
    pub motions: Vec<Motion<T>>,
    /// Colliders at its end.
    pub colliders: Vec<ColliderNow<T>>,
    /// Scale of each load at its start.
    pub scales: Vec<T>,
    /// Target volume of each body of [`Assembly::volumes`] at its end [m³], or its pressure [Pa].
    pub goals: Vec<T>,
    /// The air at its start, if there is any.
    pub air: Option<AirNow<T>>,
    /// Fraction of its closing of each material of [`Assembly::attachments`] at its end.
    pub closing: Vec<T>,
    /// Fraction of the frame at its end, and its rate [1/s].
    pub frame_fraction: (T, T),
}

impl<T: Real> Substep<T> {
    /// No sub-step: between frames.
    pub fn at_rest() -> Self {
        Self {
            h: T::ZERO,
            gravity: [0.0; 3],
            wind_force: [0.0; 3],
            drag: 0.0,
            motions: Vec::new(),
            colliders: Vec::new(),
            scales: Vec::new(),
            goals: Vec::new(),
            air: None,
            closing: Vec::new(),
            frame_fraction: (T::ZERO, T::ZERO),
        }
    }
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
                gravity: assembly.world.gravity,
                wind_force: assembly.world.wind_force,
                drag: assembly.world.drag,
                motions: assembly.tracks.iter().map(|track| motion(track, t, h)).collect(),
                colliders: {
                    let mut meshes = 0;
                    assembly.colliders.iter().map(|collider| collider.at(t, h, &mut meshes)).collect()
                },
                scales: assembly.loads.iter().map(|load| T::from_f64(scale_at(&load.scale, t))).collect(),
                goals: assembly.volumes().map(|(_, kept)| T::from_f64(kept.goal(t + h))).collect(),
                air: assembly.world.air.as_ref().map(|air| AirNow::new(air, t, h)),
                closing: assembly
                    .attachments
                    .materials
                    .iter()
                    .map(|material| T::from_f64(material.closed_fraction(t + h)))
                    .collect(),
                frame_fraction: (T::from_f64((offset + h) / time.dt), T::from_f64(1.0 / time.dt)),
            }
        })
        .collect()
}

/// The motion of a track over a sub-step from `t` on, of `h` seconds.
fn motion<T: Real>(track: &Track, t: f64, h: f64) -> Motion<T> {
    Motion::new(&track.pose(t), &track.pose(t + h), h)
}
