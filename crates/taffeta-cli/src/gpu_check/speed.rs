//! How fast a scene runs: batches of frames with no waiting within a batch.

use super::jobs::Job;
use crate::bench::kernels;
use crate::run::median;
use serde::Serialize;
use std::time::Instant;
use taffeta::scene::Scene;
use taffeta::taffeta_gpu::Gpu;
use taffeta::{GpuKernels, GpuOptions, Options, Simulation};

/// Bytes that a sub-step reads and writes for each node: position and velocity, four numbers each, in and out.
const NODE_BYTES: f64 = 64.0;
/// Time of a batch, about [s], and number of batches; where time is short in the second place.
const BATCHES: [(f64, usize); 2] = [(0.1, 7), (0.05, 3)];
/// Most frames a batch: what the driver has in its queue at once.
const MOST_FRAMES: f64 = 256.0;

/// What was measured of one scene with one choice of kernels.
#[derive(Serialize)]
pub struct Speed {
    /// `grid`, `kernels`, `mesh` or `bodies`.
    pub part: &'static str,
    pub kernels: &'static str,
    /// A grid's rows and columns; else bodies, and nodes of each.
    pub n: [u32; 2],
    pub nodes: usize,
    pub springs: usize,
    pub substeps_per_frame: u32,
    pub frames_per_batch: u32,
    pub batches: usize,
    pub ms_per_substep: Spread,
    pub particle_substeps_per_s: f64,
    pub springs_per_s: f64,
    /// At 64 bytes a node and sub-step.
    pub gb_per_s: f64,
    /// Share of the copy bandwidth measured in the same run.
    pub copy_fraction: Option<f64>,
}

/// Of the batches.
#[derive(Clone, Copy, Serialize)]
pub struct Spread {
    pub min: f64,
    pub median: f64,
    pub max: f64,
}

impl Spread {
    fn of(values: &[f64]) -> Self {
        Self {
            min: values.iter().copied().fold(f64::INFINITY, f64::min),
            median: median(values),
            max: values.iter().copied().fold(0.0, f64::max),
        }
    }
}

/// Builds a job's scene on the device and times it; `copy` is the device's copy bandwidth [GB/s].
pub fn measure(job: &Job, gpu: &Gpu, small: bool, copy: Option<f64>) -> Result<Speed, String> {
    let scene = job.scene();
    let mut simulation = build(&scene, gpu, job.kernels)?;
    let (seconds, batches) = BATCHES[usize::from(small)];
    let frames = frames_in(&mut simulation, seconds)?;
    let substeps = scene.time.substeps();
    let per_substep = 1e3 / f64::from(frames * substeps);
    let mut ms = Vec::new();
    for _ in 0..batches {
        ms.push(time(&mut simulation, frames)? * per_substep);
    }
    let ms_per_substep = Spread::of(&ms);
    let bodies = simulation.bodies();
    let nodes = bodies.iter().map(|body| body.nodes).sum();
    let springs = bodies.iter().flat_map(|body| &body.springs).map(|(_, count)| count).sum();
    let rate = |count: usize| count as f64 * 1e3 / ms_per_substep.median;
    let gb_per_s = rate(nodes) * NODE_BYTES * 1e-9;
    Ok(Speed {
        part: job.part,
        kernels: kernels::name(job.kernels),
        n: job.n,
        nodes,
        springs,
        substeps_per_frame: substeps,
        frames_per_batch: frames,
        batches,
        ms_per_substep,
        particle_substeps_per_s: rate(nodes),
        springs_per_s: rate(springs),
        gb_per_s,
        copy_fraction: copy.map(|copy| gb_per_s / copy),
    })
}

/// A scene on the device, out of its places so that springs have something to do.
pub fn build(scene: &Scene, gpu: &Gpu, kernels: GpuKernels) -> Result<Simulation, String> {
    crate::memory::check(scene).map_err(|failure| failure.to_string())?;
    let options = Options { gpu: Some(GpuOptions { kernels, ..gpu.clone().into() }), ..Options::default() };
    let mut simulation = Simulation::new(scene, &options).map_err(|error| error.to_string())?;
    simulation.disturb(super::jobs::DISTURBANCE, 1);
    Ok(simulation)
}

/// Frames that take about `seconds`, found by running some.
pub fn frames_in(simulation: &mut Simulation, seconds: f64) -> Result<u32, String> {
    let fit = |frames: f64, took: f64| (frames * seconds / took).clamp(1.0, MOST_FRAMES).floor();
    time(simulation, 1)?;
    let few = fit(1.0, time(simulation, 1)?);
    // Waiting for a single frame takes a part of its time; among many it does not.
    let frames = if few > 1.0 { fit(few, time(simulation, few as u32)?) } else { few };
    Ok(frames as u32)
}

/// Time of some frames [s].
fn time(simulation: &mut Simulation, frames: u32) -> Result<f64, String> {
    let start = Instant::now();
    simulation.advance(frames).map_err(|error| error.to_string())?;
    Ok(start.elapsed().as_secs_f64())
}
