//! How well bodies have kept their volumes.

use crate::summary;
use serde::{Deserialize, Serialize};
use taffeta::Simulation;
use taffeta::diagnostics::FrameReport;
use taffeta::scene::{Scene, VolumeForm};

/// Relative error from which on a volume that should be kept is spoken of.
const WORTH_A_WORD: f64 = 0.01;

/// The volumes of the closed bodies over a run.
#[derive(Clone, Serialize, Deserialize)]
pub struct Volumes {
    /// Of each body; `None` where it is not closed.
    bodies: Vec<Option<Volume>>,
}

#[derive(Clone, Copy, Serialize, Deserialize)]
struct Volume {
    /// [m³]
    rest: f64,
    /// Largest |V − V₀|/V₀, V₀ the volume to keep, else that at rest.
    error: f64,
    /// Frame of that error.
    frame: u32,
}

impl Volumes {
    /// The start of a run.
    pub fn new(simulation: &Simulation) -> Self {
        let volume = |rest| Volume { rest, error: 0.0, frame: 0 };
        let mut volumes =
            Self { bodies: simulation.bodies().iter().map(|body| body.rest_volume.map(volume)).collect() };
        // What a body is to have at once it cannot have before the first step.
        let start = simulation.report();
        volumes.take(start, |_| None);
        volumes
    }

    /// A frame.
    pub fn add(&mut self, report: &FrameReport) {
        self.take(report, |index| report.volume_targets.get(index).copied().flatten());
    }

    fn take(&mut self, report: &FrameReport, target: impl Fn(usize) -> Option<f64>) {
        for (index, (body, volume)) in self.bodies.iter_mut().zip(&report.volumes).enumerate() {
            let (Some(body), Some(volume)) = (body, volume) else { continue };
            let wanted = target(index).unwrap_or(body.rest);
            let error = (volume - wanted).abs() / wanted;
            if error > body.error {
                (body.error, body.frame) = (error, report.frame);
            }
        }
    }

    /// A body's volume, for the summary.
    pub fn summary(&self, index: usize, scene: &Scene, last: &FrameReport) -> Option<summary::Volume> {
        let Volume { rest, error, .. } = self.bodies[index]?;
        let target = last.volume_targets.get(index).copied().flatten();
        let form = target.and_then(|_| Some(scene.bodies[index].volume.as_ref()?.form.name()));
        let end = last.volumes.get(index).copied().flatten()?;
        Some(summary::Volume { rest, end, form, target, max_rel_error: error })
    }

    /// What to say of bodies that had not the volume that they were to keep. Forms of papers are known to lose it.
    pub fn warnings(&self, scene: &Scene) -> Vec<String> {
        let warning = |(body, volume): (&taffeta::scene::Body, &Option<Volume>)| {
            let (kept, Volume { error, frame, .. }) = (body.volume.as_ref()?, (*volume)?);
            let ours = matches!(kept.form, VolumeForm::Corrected | VolumeForm::Projected);
            if !ours || kept.is_pressure() || error <= WORTH_A_WORD {
                return None;
            }
            let changes = if kept.motion.is_empty() {
                ""
            } else {
                ", or its target changes faster than the nodes can follow in a sub-step"
            };
            Some(format!(
                "body `{}` was off its target volume by {:.2} % in frame {frame}: most likely nodes that are held, \
                 or pressed by colliders, leave it no room{changes}",
                body.name,
                error * 1e2
            ))
        };
        scene.bodies.iter().zip(&self.bodies).filter_map(warning).collect()
    }
}
