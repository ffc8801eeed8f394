//! What a scene does: its frames in numbers, their times, and the cloth at some moments.

use crate::runs::scenes;
use crate::runs::strip::{Moment, Strip};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};
use std::time::Instant;
use taffeta::diagnostics::FrameReport;
use taffeta::{Options, Simulation};

/// A scene that is run, on the CPU in 32 bits.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The file's name without its ending.
    pub name: &'static str,
    /// What differs from it, as for `--set`.
    pub sets: Vec<String>,
    /// Worker threads; as many as help, where nothing is said.
    pub threads: Option<usize>,
    /// Whether the cloth is drawn.
    pub pictured: bool,
}

/// When the cloth is drawn [s].
const MOMENTS: [f64; 3] = [0.32, 0.64, 4.8];
/// Points of a curve that are kept.
const POINTS: usize = 160;

/// What a run left.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Behaviour {
    /// `cpu, 2 threads, avx512`
    pub device: String,
    /// `f32`
    pub precision: String,
    /// Nodes.
    pub nodes: usize,
    /// Triangles.
    pub triangles: usize,
    /// Springs.
    pub springs: usize,
    /// Length of a frame [s].
    pub dt: f64,
    /// Sub-steps of a frame.
    pub substeps_per_frame: u32,
    /// Frames that were run.
    pub frames: u32,
    /// The frame in which it blew up.
    pub diverged: Option<u32>,
    /// Of a frame in which something is touched, or of all, where nothing is [ms].
    pub ms_per_frame: Times,
    /// Sub-steps a second, by the middle one.
    pub steps_per_s: f64,
    /// Largest l/L of all frames.
    pub max_stretch: f64,
    /// l/L of the last frame.
    pub end_stretch: f64,
    /// Energy at the start [J].
    pub start_energy: f64,
    /// The most energy beyond that [J].
    pub energy_gain: f64,
    /// Iterations of the solver of constraints: mean over frames of the most in a sub-step.
    pub iterations: f64,
    /// Largest residual.
    pub residual: f64,
    /// Mean share of springs that were constraints.
    pub active: f64,
    /// Largest |V − V₀|/V₀ of the body that is off most, where bodies are closed.
    pub max_loss: Option<f64>,
    /// Mean over frames of the same.
    pub mean_loss: Option<f64>,
    /// Some of the frames.
    pub curve: Vec<Point>,
    /// The cloth at some moments: a PNG in base 64.
    pub picture: Option<String>,
}

/// Times of frames.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Times {
    /// Least [ms].
    pub min: f64,
    /// Of the frames the middle one [ms].
    pub median: f64,
    /// Most [ms].
    pub max: f64,
    /// Of how many frames.
    pub frames: usize,
}

/// A frame of a curve, to five digits: more than a plot shows.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Point {
    /// Time [s].
    pub time: f64,
    /// Largest l/L.
    pub stretch: f64,
    /// Volume of all bodies over that at rest.
    pub volume: Option<f64>,
}

/// Runs a scene, or its first `frames`.
///
/// # Errors
/// Where it cannot be loaded; and where it was stopped.
pub fn run(scene: &Scene, frames: Option<u32>, stopped: &dyn Fn() -> bool) -> Result<Behaviour, String> {
    let loaded = scenes::load(scene.name, &scene.sets)?;
    let time = loaded.scene.time.clone();
    let options = Options { threads: scene.threads, ..Options::default() };
    let mut simulation = Simulation::new(&loaded.scene, &options).map_err(|error| error.to_string())?;
    let mut strip = scene.pictured.then(|| Strip::new(&simulation, &loaded.scene));
    let drawn = MOMENTS.map(|seconds| (seconds / time.dt).round() as u32);
    let count = frames.map_or(time.frames, |frames| frames.min(time.frames));
    let (mut reports, mut ms, mut diverged) = (vec![simulation.report().clone()], Vec::new(), None);
    for frame in 1..=count {
        if stopped() {
            return Err("stopped".to_owned());
        }
        let before = strip.is_some().then(|| Moment::now(&simulation));
        let clock = Instant::now();
        let step = simulation.step();
        ms.push(clock.elapsed().as_secs_f64() * 1e3);
        if step.is_err() {
            diverged = Some(frame);
            strip.iter_mut().zip(before).for_each(|(strip, last)| strip.push(last));
            break;
        }
        reports.push(simulation.report().clone());
        if drawn.contains(&frame) || (frame == count && drawn.iter().all(|&moment| moment > count)) {
            strip.iter_mut().for_each(|strip| strip.push(Moment::now(&simulation)));
        }
    }
    let bodies = simulation.bodies();
    let rest: Vec<f64> = bodies.iter().map(|body| body.rest_volume.unwrap_or(f64::NAN)).collect();
    let spread = times(&reports[1..], &ms);
    Ok(Behaviour {
        device: simulation.device(),
        precision: options.precision.to_string(),
        nodes: bodies.iter().map(|body| body.nodes).sum(),
        triangles: bodies.iter().map(|body| body.triangles).sum(),
        springs: bodies.iter().flat_map(|body| &body.springs).map(|(_, count)| count).sum(),
        dt: time.dt,
        substeps_per_frame: time.substeps(),
        frames: reports.len() as u32 - 1,
        diverged,
        ms_per_frame: spread,
        // A scene that blows up at once has no time.
        steps_per_s: if spread.median > 0.0 { f64::from(time.substeps()) * 1e3 / spread.median } else { 0.0 },
        picture: strip.map(|strip| strip.png()).transpose()?.map(|png| STANDARD.encode(png)),
        ..summary(&reports, &rest)
    })
}

/// Times of those frames in which something is touched, or of all.
fn times(reports: &[FrameReport], ms: &[f64]) -> Times {
    let touching = reports.iter().zip(ms).filter(|(report, _)| report.contacts > 0);
    let mut chosen: Vec<f64> = touching.map(|(_, &ms)| ms).collect();
    if chosen.is_empty() {
        chosen = ms[..reports.len()].to_vec();
    }
    chosen.sort_by(f64::total_cmp);
    let Some((&min, &max)) = chosen.first().zip(chosen.last()) else { return Times::default() };
    Times { min, median: chosen[chosen.len() / 2], max, frames: chosen.len() }
}

/// The numbers of all frames, that of the start first.
fn summary(reports: &[FrameReport], rest: &[f64]) -> Behaviour {
    let start = reports[0].energy();
    let later = &reports[1.min(reports.len() - 1)..];
    let mean = |of: &dyn Fn(&FrameReport) -> f64| later.iter().map(of).sum::<f64>() / later.len() as f64;
    let most = |of: &dyn Fn(&FrameReport) -> f64| later.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
    let closed = rest.iter().any(|volume| volume.is_finite());
    let loss = |report: &FrameReport| loss(report, rest);
    let whole: f64 = rest.iter().filter(|volume| volume.is_finite()).sum();
    let volume = |report: &FrameReport| report.volumes.iter().flatten().sum::<f64>() / whole;
    let point = |report: &FrameReport| Point {
        time: five_digits(report.time),
        stretch: five_digits(report.max_stretch),
        volume: Some(volume(report)).filter(|v| closed && v.is_finite()).map(five_digits),
    };
    Behaviour {
        max_stretch: most(&|report| report.max_stretch),
        end_stretch: later[later.len() - 1].max_stretch,
        start_energy: start,
        energy_gain: most(&|report| report.energy() - start),
        iterations: mean(&|report| f64::from(report.solver.iterations)),
        residual: most(&|report| report.solver.residual),
        active: mean(&|report| report.solver.active_fraction),
        max_loss: closed.then(|| most(&loss)),
        mean_loss: closed.then(|| mean(&loss)),
        curve: thinned(reports).map(point).collect(),
        ..Behaviour::default()
    }
}

/// How far the volume of the body that is off most is from what it is to be, or was at rest.
fn loss(report: &FrameReport, rest: &[f64]) -> f64 {
    let goals = report.volume_targets.iter().zip(rest).map(|(target, rest)| target.unwrap_or(*rest));
    let off = report
        .volumes
        .iter()
        .zip(goals)
        .filter_map(|(volume, goal)| Some((volume.as_ref()? / goal - 1.0).abs()));
    off.fold(0.0, f64::max)
}

fn five_digits(x: f64) -> f64 {
    format!("{x:.4e}").parse().unwrap_or(x)
}

/// So many of them that a curve looks the same; the last is among them.
fn thinned(reports: &[FrameReport]) -> impl Iterator<Item = &FrameReport> {
    let every = reports.len().div_ceil(POINTS);
    reports.iter().rev().step_by(every).collect::<Vec<_>>().into_iter().rev()
}

impl Behaviour {
    /// The bytes of its picture.
    pub fn png(&self) -> Option<Vec<u8>> {
        STANDARD.decode(self.picture.as_ref()?).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(name: &'static str, sets: &[&str]) -> Scene {
        Scene {
            name,
            sets: sets.iter().map(|&set| set.to_owned()).collect(),
            threads: Some(1),
            pictured: true,
        }
    }

    #[test]
    fn springs_of_figure_15_blow_up_and_the_last_good_frame_is_drawn() {
        let done = run(&scene("s1_fig15", &["solver.method=springs"]), None, &|| false).unwrap_or_default();
        assert_eq!(done.springs, 5826);
        assert!(done.diverged.is_some_and(|frame| (20..60).contains(&frame)), "{:?}", done.diverged);
        assert_eq!(done.frames + 1, done.diverged.unwrap_or(0));
        assert!(done.png().is_some_and(|png| png.starts_with(b"\x89PNG")));
        assert!(done.max_loss.is_none() && done.energy_gain > 0.0);
    }

    #[test]
    fn a_ball_without_its_constraint_loses_volume_and_one_with_it_does_not() {
        let loss = |form: &str| {
            let sets = [
                format!("body.sphere.volume.form={form}"),
                "body.sphere.mesh.icosphere.subdivisions=2".to_owned(),
            ];
            let scene = Scene { name: "fall_sphere", sets: sets.to_vec(), threads: Some(1), pictured: false };
            let done = run(&scene, Some(60), &|| false).unwrap_or_default();
            assert_eq!((done.frames, done.curve.len()), (60, 61));
            done.max_loss.unwrap_or(f64::NAN)
        };
        assert!(loss("none") > 0.1 && loss("corrected") < 1e-3, "{} {}", loss("none"), loss("corrected"));
    }

    #[test]
    fn what_is_stopped_leaves_nothing() {
        let stopped = run(&scene("s1_fig15", &[]), None, &|| true);
        assert_eq!(stopped.err().as_deref(), Some("stopped"));
    }
}
