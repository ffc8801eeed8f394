//! Times a scene and sets it beside the machine's limits.

use super::Args;
use super::form::Form;
use super::kernels;
use super::line::{Line, Shares, Solved, Spread};
use crate::console;
use crate::gpu::{self, Copied};
use crate::limits;
use crate::run::{Arithmetic, at_once, median, rate};
use std::time::Instant;
use taffeta::scene::{Method, Scene};
use taffeta::{GpuOptions, Options, Simulation};
use taffeta_io::program::Failure;

/// Numbers of a node that a sub-step must read and write once: position and velocity in and out, the least any
/// method can move through memory.
const NUMBERS_A_NODE: usize = 12;
/// The same on a GPU [byte], where both take four numbers.
const GPU_BYTES_A_NODE: f64 = 64.0;
/// Operations of a spring with damping: difference (3), square (5), root and quotient (2), stretch and stiffness (3),
/// relative speed along it (8), force (4), to both nodes (6).
const FLOPS_A_SPRING: f64 = 31.0;
/// Time that a bench takes where `--frames` does not say [s], and the fewest batches of frames that it times then.
const BUDGET: (f64, u32) = (3.0, 3);
/// Time between two waits for a GPU, about [ms]: so long that the wait does not count.
const BATCH: f64 = 50.0;

/// What is timed.
#[derive(Clone)]
pub struct Bench {
    /// Its name on the command line.
    pub name: &'static str,
    /// Its size: rows and columns, or nodes.
    pub n: Vec<u32>,
    /// Which of its scenes, where it has several.
    pub case: Option<&'static str>,
    /// The scene.
    pub scene: Scene,
    /// Which equations, where that is what is measured.
    pub form: Option<Form>,
    /// Frames before those that are timed.
    pub settle: u32,
    /// Frames after which there is no more to time.
    pub most: u32,
    /// How far nodes start from their places [m].
    pub disturbance: f64,
    /// What the user should know.
    pub notes: Vec<String>,
}

impl Bench {
    /// A scene that is timed from its start on.
    pub fn new(name: &'static str, n: Vec<u32>, scene: Scene) -> Self {
        Self {
            name,
            n,
            case: None,
            scene,
            form: None,
            settle: 0,
            most: u32::MAX,
            disturbance: 0.0,
            notes: Vec::new(),
        }
    }

    /// How springs are solved, where that is what is measured.
    fn method(&self) -> Option<&'static str> {
        let is_measured = ["ice", "flag", "acad", "collider", "xpbd"].contains(&self.name);
        is_measured.then(|| self.scene.solver.method.name())
    }
}

/// Times of frames.
struct Times {
    /// Mean time of a frame of each batch [ms].
    ms: Vec<f64>,
    frames: u32,
    /// Frames of a batch at most.
    batch: u32,
    /// Time of each stage in a frame of its own [s].
    stages: Vec<(&'static str, f64)>,
    /// What the solver for constraints did.
    solved: Option<Solved>,
}

/// Runs a bench: a warm-up, then the timed frames.
pub fn run(bench: &Bench, args: &Args, gpu: Option<&GpuOptions>) -> Result<Line, Failure> {
    let options = Options {
        threads: at_once(args.threads),
        precision: args.precision.precision(),
        gpu: gpu.cloned(),
        ..Options::default()
    };
    let mut simulation = Simulation::new(&bench.scene, &options).map_err(|error| {
        Failure::Input(format!("bench {}: {}", bench.name, console::advised(&error, error.advice())))
    })?;
    if bench.disturbance > 0.0 {
        simulation.disturb(bench.disturbance, 1);
    }
    if bench.settle > 0 {
        advance(&mut simulation, bench.settle)?;
    }
    let times = Times::take(&mut simulation, (args.frames, bench.most), gpu.is_some())?;
    line(bench, args, &simulation, &times, gpu)
}

impl Times {
    /// Times `frames` frames, or as many as the budget allows and up to `most`, after some that are not timed; and the stages of
    /// one.
    fn take(
        simulation: &mut Simulation,
        (frames, most): (Option<u32>, u32),
        gpu: bool,
    ) -> Result<Self, Failure> {
        let mut reports = Vec::new();
        let mut timed = |simulation: &mut Simulation, count| {
            let ms = advance(simulation, count)?;
            reports.push(simulation.report().solver);
            Ok::<f64, Failure>(ms)
        };
        timed(simulation, 1)?;
        // How many frames a GPU should do without the host.
        let batch = if gpu { ((BATCH / timed(simulation, 1)?) as u32).max(1) } else { 1 };
        let mut times = Self { ms: Vec::new(), frames: 0, batch, stages: Vec::new(), solved: None };
        let start = Instant::now();
        loop {
            let left = match frames {
                Some(count) => count - times.frames,
                None if times.frames >= most => 0,
                None if start.elapsed().as_secs_f64() < BUDGET.0 => batch.min(most - times.frames),
                None => batch * BUDGET.1.saturating_sub(times.ms.len() as u32),
            };
            if left == 0 {
                break;
            }
            let count = left.min(batch);
            times.ms.push(timed(simulation, count)?);
            times.frames += count;
        }
        times.solved = Solved::of(&reports);
        if gpu {
            // What the first of several workers does on the CPU is no measure of a stage.
            times.stages = simulation.step_timed().map_err(|error| Failure::Work(error.to_string()))?;
        }
        Ok(times)
    }
}

/// Some frames that do not wait for each other; the time of one [ms].
fn advance(simulation: &mut Simulation, frames: u32) -> Result<f64, Failure> {
    let start = Instant::now();
    simulation.advance(frames).map_err(|error| Failure::Work(error.to_string()))?;
    Ok(start.elapsed().as_secs_f64() * 1e3 / f64::from(frames))
}

/// What was measured, for `args`; with the share of the limits of `gpu`, if that is what was timed.
fn line(
    bench: &Bench,
    args: &Args,
    simulation: &Simulation,
    times: &Times,
    gpu: Option<&GpuOptions>,
) -> Result<Line, Failure> {
    let bodies = simulation.bodies();
    let nodes: usize = bodies.iter().map(|body| body.nodes).sum();
    let springs: usize = bodies.iter().flat_map(|body| &body.springs).map(|(_, count)| count).sum();
    let substeps = bench.scene.time.substeps();
    let spread = Spread {
        min: times.ms.iter().copied().fold(f64::INFINITY, f64::min),
        median: median(&times.ms),
        max: times.ms.iter().copied().fold(0.0, f64::max),
    };
    let of_each = |count: usize| rate(count as f64 * f64::from(substeps), spread.median);
    let (steps, particles, springs_per_s) = (of_each(1), of_each(nodes), of_each(springs));
    let limits = match gpu {
        Some(options) => shares_of_gpu(options, particles)?,
        None => shares_of_cpu(args.precision, simulation.threads(), particles, springs_per_s),
    };
    let software = gpu.and_then(|options| gpu::software_note(options.gpu.info()));
    let notes: Vec<String> = bench.notes.iter().cloned().chain(software).collect();
    Ok(Line {
        bench: bench.name,
        case: bench.case,
        backend: simulation.backend(),
        device: simulation.device(),
        kernels: gpu.map(|options| kernels::name(options.kernels)),
        form: bench.form.map(Form::name),
        method: bench.method(),
        precision: args.precision.precision().to_string(),
        n: bench.n.clone(),
        nodes,
        springs,
        substeps_per_frame: substeps,
        frames: times.frames as usize,
        frames_between_waits: gpu.map(|_| times.batch.min(times.frames)),
        ms_per_frame: spread,
        steps_per_s: steps,
        particle_substeps_per_s: particles,
        springs_per_s,
        solved: times.solved.filter(|_| !matches!(bench.scene.solver.method, Method::Springs | Method::Xpbd)),
        over_springs: None,
        over_sphere: None,
        ms_by_stage: times.stages.iter().map(|&(name, seconds)| (name, seconds * 1e3)).collect(),
        limits,
        note: (!notes.is_empty()).then(|| notes.join("; ")),
    })
}

fn shares_of_cpu(precision: Arithmetic, threads: usize, particles: f64, springs: f64) -> Shares {
    let machine = limits::measure(threads);
    let bytes_per_s = particles * (NUMBERS_A_NODE * precision.precision().bytes()) as f64;
    Shares::Cpu {
        machine,
        memory_fraction: bytes_per_s * 1e-9 / machine.memory_gb_per_s,
        fma_fraction: springs * FLOPS_A_SPRING * 1e-9 / machine.fma_gflop_per_s,
    }
}

fn shares_of_gpu(options: &GpuOptions, particles: f64) -> Result<Shares, Failure> {
    // Small buffers of a software adapter are as telling, and quicker.
    let small = options.gpu.info().is_software();
    let copied = Copied::measure(&options.gpu, small).map_err(|error| Failure::Work(error.to_string()))?;
    let memory_gb_per_s = copied.best();
    let memory_fraction = particles * GPU_BYTES_A_NODE * 1e-9 / memory_gb_per_s;
    Ok(Shares::Gpu { memory_gb_per_s, memory_fraction })
}
