//! One run, and the lines that are kept of all.

use super::curve::Curve;
use super::experiment::{Experiment, Variant};
use crate::lines::Line;
use serde::{Deserialize, Serialize};
use taffeta::diagnostics::FrameReport;
use taffeta::scene::Scene;
use taffeta::{Options, Simulation};
use taffeta_io::program::processor;

/// A run in numbers: a line of `runs.jsonl`.
#[derive(Clone, Serialize, Deserialize)]
pub struct Run {
    pub scene: String,
    pub form: String,
    /// Of the first body's structural springs [N/m].
    pub k: f64,
    pub nodes: usize,
    pub triangles: usize,
    pub springs: usize,
    pub frames: u32,
    /// The frame in which it blew up.
    pub diverged: Option<u32>,
    /// Largest and mean |V − V₀|/V₀ over all frames, of the body that is off most: V₀ is the volume to keep.
    pub max_error: f64,
    pub mean_error: f64,
    /// What was not as the scene wants it: a stand-in.
    pub note: Option<String>,
    /// The processor in words.
    pub machine: String,
    pub device: String,
    pub commit: String,
}

/// Volumes that the bodies are to have after each frame [m³].
pub type Goals = Vec<Vec<f64>>;

/// Runs a variant of an experiment on the CPU in 32 bits. A run that keeps volumes says what they are to be; one that keeps
/// none is compared with these.
pub fn run(
    experiment: &Experiment,
    variant: &Variant,
    goals: &mut Goals,
    commit: &str,
) -> Result<(Curve, Run), String> {
    let mut loaded = experiment.load()?;
    let k = alter(&mut loaded.scene, variant);
    let time = loaded.scene.time.clone();
    let mut simulation =
        Simulation::new(&loaded.scene, &Options::default()).map_err(|error| error.to_string())?;
    let rest: Vec<f64> =
        simulation.bodies().iter().map(|body| body.rest_volume.unwrap_or(f64::INFINITY)).collect();
    let mut curve = Curve::new(variant.form.name());
    let (mut errors, mut diverged) = (Vec::new(), None);
    for frame in 0..time.frames {
        if simulation.step().is_err() {
            diverged = Some(frame + 1);
            break;
        }
        let report = simulation.report();
        if goals.len() == frame as usize {
            let goal = |(target, rest): (&Option<f64>, &f64)| target.unwrap_or(*rest);
            goals.push(report.volume_targets.iter().zip(&rest).map(goal).collect());
        }
        errors.push(largest_error(report, &goals[frame as usize]));
        curve.shares.push(sum(report.volumes.iter().flatten()) / sum(&rest));
    }
    let bodies = simulation.bodies();
    let run = Run {
        scene: experiment.scene.to_owned(),
        form: variant.form.name().to_owned(),
        k,
        nodes: bodies.iter().map(|body| body.nodes).sum(),
        triangles: bodies.iter().map(|body| body.triangles).sum(),
        springs: bodies.iter().flat_map(|body| &body.springs).map(|(_, count)| count).sum(),
        frames: time.frames,
        diverged,
        max_error: errors.iter().copied().fold(0.0, f64::max),
        mean_error: sum(&errors) / errors.len().max(1) as f64,
        note: loaded.notes.first().cloned(),
        machine: processor(),
        device: simulation.device(),
        commit: commit.to_owned(),
    };
    Ok((curve, run))
}

/// Gives all bodies the variant's form and stiffness; returns the first body's stiffness [N/m].
fn alter(scene: &mut Scene, variant: &Variant) -> f64 {
    for body in &mut scene.bodies {
        if let Some(volume) = &mut body.volume {
            volume.form = variant.form;
        }
        if let (Some(springs), Some(k)) = (&mut body.springs.structural, variant.k) {
            springs.k = k;
        }
    }
    scene.bodies.first().and_then(|body| body.springs.structural).map_or(0.0, |springs| springs.k)
}

/// Of the body that is off most.
fn largest_error(report: &FrameReport, goals: &[f64]) -> f64 {
    let error =
        |(volume, goal): (&Option<f64>, &f64)| volume.map_or(0.0, |volume| (volume / goal - 1.0).abs());
    report.volumes.iter().zip(goals).map(error).fold(0.0, f64::max)
}

fn sum<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().sum()
}

impl Run {
    /// What the run was, and how it went.
    pub fn words(&self) -> String {
        let Self { scene, form, k, max_error, .. } = self;
        let ending = self.diverged.map_or_else(String::new, |frame| format!(", blew up in frame {frame}"));
        format!("{scene}, {form}, k = {k}: off by {max_error:.2e} at most{ending}")
    }
}

impl Line for Run {
    const FILE: &str = "runs.jsonl";
    fn same(&self, other: &Self) -> bool {
        self.scene == other.scene && self.form == other.form && self.k == other.k
    }
}
