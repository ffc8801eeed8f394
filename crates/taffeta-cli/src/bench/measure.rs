//! Times a scene and sets it beside the machine's limits.

use super::Args;
use crate::console::grouped;
use crate::failure::Failure;
use crate::limits::{self, Limits};
use crate::run::{Arithmetic, median, rate};
use serde::Serialize;
use std::time::Instant;
use taffeta::scene::Scene;
use taffeta::{Options, Simulation};

/// Numbers of a node that a sub-step must read and write once: position and velocity in and out, the least any
/// method can move through memory.
const NUMBERS_A_NODE: usize = 12;
/// Operations of a spring with damping: difference (3), square (5), root and quotient (2), stretch and stiffness (3),
/// relative speed along it (8), force (4), to both nodes (6).
const FLOPS_A_SPRING: f64 = 31.0;
/// Time that a bench takes where `--frames` does not say [s], and the fewest frames that it times then.
const BUDGET: (f64, u32) = (3.0, 3);

/// What is timed.
pub struct Bench {
    /// Its name on the command line.
    pub name: &'static str,
    /// Its size: rows and columns, or nodes.
    pub n: Vec<u32>,
    /// The scene.
    pub scene: Scene,
    /// How far nodes start from their places [m].
    pub disturbance: f64,
    /// What the user should know.
    pub note: Option<String>,
}

/// The line that a bench prints.
#[derive(Serialize)]
pub struct Line {
    bench: &'static str,
    backend: &'static str,
    device: String,
    precision: String,
    n: Vec<u32>,
    nodes: usize,
    springs: usize,
    substeps_per_frame: u32,
    frames: usize,
    ms_per_frame: Spread,
    particle_substeps_per_s: f64,
    springs_per_s: f64,
    limits: Shares,
    #[serde(skip_serializing_if = "Option::is_none")]
    note: Option<String>,
}

#[derive(Serialize)]
struct Spread {
    min: f64,
    median: f64,
    max: f64,
}

/// The machine's limits, and the share of each that the median frame used.
#[derive(Serialize)]
struct Shares {
    #[serde(flatten)]
    machine: Limits,
    memory_fraction: f64,
    fma_fraction: f64,
}

/// Runs a bench: one frame to warm up, then the timed ones.
pub fn run(bench: &Bench, args: &Args) -> Result<Line, Failure> {
    crate::memory::check(&bench.scene)?;
    let options = Options {
        threads: args.threads.map(usize::from),
        precision: args.precision.precision(),
        ..Options::default()
    };
    let mut simulation = Simulation::new(&bench.scene, &options)
        .map_err(|error| Failure::Input(format!("bench {}: {error}", bench.name)))?;
    if bench.disturbance > 0.0 {
        simulation.disturb(bench.disturbance, 1);
    }
    frame(&mut simulation)?;
    let mut ms = Vec::new();
    let start = Instant::now();
    let enough = |done: u32| match args.frames {
        Some(count) => done >= count,
        None => done >= BUDGET.1 && start.elapsed().as_secs_f64() >= BUDGET.0,
    };
    for done in 0.. {
        if enough(done) {
            break;
        }
        ms.push(frame(&mut simulation)?);
    }
    Ok(line(bench, args, &simulation, &ms))
}

/// One frame; its time [ms].
fn frame(simulation: &mut Simulation) -> Result<f64, Failure> {
    let start = Instant::now();
    simulation.step().map_err(|error| Failure::Work(error.to_string()))?;
    Ok(start.elapsed().as_secs_f64() * 1e3)
}

fn line(bench: &Bench, args: &Args, simulation: &Simulation, ms: &[f64]) -> Line {
    let bodies = simulation.bodies();
    let nodes: usize = bodies.iter().map(|body| body.nodes).sum();
    let springs: usize = bodies.iter().flat_map(|body| &body.springs).map(|(_, count)| count).sum();
    let substeps = bench.scene.time.substeps();
    let spread = Spread {
        min: ms.iter().copied().fold(f64::INFINITY, f64::min),
        median: median(ms),
        max: ms.iter().copied().fold(0.0, f64::max),
    };
    let of_each = |count: usize| rate(count as f64 * f64::from(substeps), spread.median);
    let (particles, springs_per_s) = (of_each(nodes), of_each(springs));
    let number = match args.precision {
        Arithmetic::F32 => size_of::<f32>(),
        Arithmetic::F64 => size_of::<f64>(),
    };
    let machine = limits::measure(simulation.threads());
    let bytes_per_s = particles * (NUMBERS_A_NODE * number) as f64;
    Line {
        bench: bench.name,
        backend: "cpu",
        device: simulation.device(),
        precision: args.precision.precision().to_string(),
        n: bench.n.clone(),
        nodes,
        springs,
        substeps_per_frame: substeps,
        frames: ms.len(),
        ms_per_frame: spread,
        particle_substeps_per_s: particles,
        springs_per_s,
        limits: Shares {
            machine,
            memory_fraction: bytes_per_s * 1e-9 / machine.memory_gb_per_s,
            fma_fraction: springs_per_s * FLOPS_A_SPRING * 1e-9 / machine.fma_gflop_per_s,
        },
        note: bench.note.clone(),
    }
}

impl Line {
    /// For people.
    pub fn table(&self) -> String {
        let n: Vec<String> = self.n.iter().map(u32::to_string).collect();
        let limits = &self.limits;
        let mut lines = vec![
            format!("{} {} on {}, {}", self.bench, n.join("×"), self.device, self.precision),
            format!("  {} nodes, {} springs", grouped(self.nodes), grouped(self.springs)),
            format!(
                "  {:.3} ms a frame of {} sub-steps (median of {}; {:.3} to {:.3})",
                self.ms_per_frame.median,
                self.substeps_per_frame,
                self.frames,
                self.ms_per_frame.min,
                self.ms_per_frame.max
            ),
            format!(
                "  {:.0} M particle-substeps/s, {:.0} M springs/s",
                self.particle_substeps_per_s * 1e-6,
                self.springs_per_s * 1e-6
            ),
            format!(
                "  {:.0} % of {:.1} GB/s (state once in, once out), {:.0} % of {:.0} GFLOP/s",
                limits.memory_fraction * 1e2,
                limits.machine.memory_gb_per_s,
                limits.fma_fraction * 1e2,
                limits.machine.fma_gflop_per_s
            ),
        ];
        lines.extend(self.note.iter().map(|note| format!("  {note}")));
        lines.join("\n")
    }
}
