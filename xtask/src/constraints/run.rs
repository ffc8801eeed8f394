//! One run, and the line that is kept of it.

use super::curve::Curve;
use super::experiment::{Experiment, Variant, command};
use crate::lines::Line;
use serde::{Deserialize, Serialize};
use taffeta::diagnostics::FrameReport;
use taffeta::{Options, Simulation};
use taffeta_io::program::processor;
use taffeta_papers::runs::strip::{Moment, Strip};

/// A run in numbers: a line of `runs.jsonl`.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct Run {
    pub experiment: String,
    pub variant: String,
    pub command: String,
    pub nodes: usize,
    pub springs: usize,
    pub frames: u32,
    /// Length of a frame [s].
    pub dt: f64,
    /// The frame in which it blew up.
    pub diverged: Option<u32>,
    /// Largest l/L over all frames and springs, with its frame; and in the last frame.
    pub max_stretch: (f64, u32),
    pub end_stretch: f64,
    /// Energy at the start [J]; the most that it had beyond it, with its frame.
    pub start_energy: f64,
    pub energy_gain: (f64, u32),
    /// Iterations: mean over frames of the most in a sub-step, and the most.
    pub iterations: (f64, u32),
    /// Largest residual by the right side; sub-steps that ended beyond the tolerance.
    pub residual: f64,
    pub capped: u32,
    /// Share of springs that were constraints: mean over frames, and the most.
    pub active: (f64, f64),
    /// The processor in words.
    pub machine: String,
    pub device: String,
    pub commit: String,
}

/// All that is kept of a run.
pub struct Done {
    pub run: Run,
    pub curve: Curve,
    /// Where the cloth is drawn.
    pub strip: Option<Strip>,
}

/// When the cloth is drawn [s].
pub const MOMENTS: [f64; 3] = [0.32, 0.64, 4.8];

/// Runs a variant of an experiment on the CPU in 32 bits.
pub fn run(experiment: &Experiment, variant: &Variant, commit: &str) -> Result<Done, String> {
    let scene = experiment.load(variant)?.scene;
    let time = scene.time.clone();
    let mut simulation = Simulation::new(&scene, &Options::default()).map_err(|error| error.to_string())?;
    let wanted = MOMENTS.map(|seconds| (seconds / time.dt).round() as u32);
    let mut reports = vec![simulation.report().clone()];
    let mut strip = experiment.pictured.then(|| Strip::new(&simulation, &scene));
    let mut diverged = None;
    for frame in 1..=time.frames {
        let before = strip.is_some().then(|| Moment::now(&simulation));
        if simulation.step().is_err() {
            diverged = Some(frame);
            strip.iter_mut().zip(before).for_each(|(strip, last)| strip.push(last));
            break;
        }
        reports.push(simulation.report().clone());
        if wanted.contains(&frame) {
            strip.iter_mut().for_each(|strip| strip.push(Moment::now(&simulation)));
        }
    }
    let bodies = simulation.bodies();
    let run = Run {
        experiment: experiment.name.to_owned(),
        variant: variant.slug.to_owned(),
        command: command(experiment.scene, &variant.sets),
        nodes: bodies.iter().map(|body| body.nodes).sum(),
        springs: bodies.iter().flat_map(|body| &body.springs).map(|(_, count)| count).sum(),
        frames: time.frames,
        dt: time.dt,
        diverged,
        machine: processor(),
        device: simulation.device(),
        commit: commit.to_owned(),
        ..summary(&reports)
    };
    Ok(Done { run, curve: Curve::new(&reports), strip })
}

/// The numbers of all frames, that of the start first.
fn summary(reports: &[FrameReport]) -> Run {
    let start = reports[0].energy();
    let later = &reports[1.min(reports.len() - 1)..];
    let mean = |of: fn(&FrameReport) -> f64| later.iter().map(of).sum::<f64>() / later.len() as f64;
    let active = |report: &FrameReport| report.solver.active_fraction;
    Run {
        max_stretch: most(later, |report| report.max_stretch),
        end_stretch: later[later.len() - 1].max_stretch,
        start_energy: start,
        energy_gain: most(later, |report| report.energy() - start),
        iterations: (
            mean(|report| f64::from(report.solver.iterations)),
            later.iter().map(|report| report.solver.iterations).max().unwrap_or(0),
        ),
        residual: most(later, |report| report.solver.residual).0,
        capped: later.iter().map(|report| report.solver.capped).sum(),
        active: (mean(active), most(later, active).0),
        ..Run::default()
    }
}

/// The largest of a number over frames, and the first frame that has it.
fn most(reports: &[FrameReport], of: impl Fn(&FrameReport) -> f64) -> (f64, u32) {
    let all = reports.iter().map(|report| (of(report), report.frame));
    all.fold((f64::NEG_INFINITY, 0), |most, one| if one.0 > most.0 { one } else { most })
}

impl Run {
    /// What the run was, and how it went.
    pub fn words(&self) -> String {
        let ending = self.diverged.map_or_else(String::new, |frame| format!(", blew up in frame {frame}"));
        let ((stretch, at), (gain, gain_at)) = (self.max_stretch, self.energy_gain);
        format!(
            "{} {}: stretch {stretch:.3} in frame {at}, energy {gain:+.2} J in frame {gain_at}, {:.1} iterations (at most \
             {}){ending}",
            self.experiment, self.variant, self.iterations.0, self.iterations.1
        )
    }
}

impl Line for Run {
    const FILE: &str = "runs.jsonl";
    fn same(&self, other: &Self) -> bool {
        self.experiment == other.experiment && self.variant == other.variant
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_summary_counts_from_the_start_and_names_frames() {
        let report = |frame, max_stretch, kinetic| FrameReport {
            frame,
            max_stretch,
            kinetic,
            ..FrameReport::default()
        };
        let run =
            summary(&[report(0, 9.0, 10.0), report(1, 1.0, 9.0), report(2, 1.5, 12.0), report(3, 1.2, 12.0)]);
        assert_eq!((run.max_stretch, run.end_stretch), ((1.5, 2), 1.2));
        assert_eq!((run.start_energy, run.energy_gain), (10.0, (2.0, 2)));
        // Nothing but the start, where the first frame failed.
        assert_eq!(summary(&[report(0, 1.0, 10.0)]).energy_gain, (0.0, 0));
    }
}
