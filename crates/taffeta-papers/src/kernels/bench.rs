//! The papers' kernels by the clock, beside those of the engine.

use crate::contact::timing;
use crate::kernels::PaperKernels;
use clap::ValueEnum;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde_json::{Value, json};
use std::io::{self, Write};
use std::time::Instant;
use taffeta::scene::{Body, Collider, ConstraintForm, Mass, Mesh, Method, Scene, Select};
use taffeta::taffeta_gpu::{Choice, Gpu};
use taffeta::{GpuKernels, GpuOptions, Options, Simulation};
use taffeta_io::program::Failure;

/// Prints a line of JSON for each set of kernels, on the GPU of TAFFETA_ADAPTER.
#[derive(clap::Args)]
pub struct Args {
    /// What to run
    #[arg(value_enum, default_value_t = What::Grid)]
    what: What,
    /// Side of the sheet in nodes [default: grid: 160, ice: 34]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=65_536))]
    n: Option<u32>,
    /// Rows of the sheet
    #[arg(long, value_name = "R", requires = "cols", conflicts_with = "n",
          value_parser = clap::value_parser!(u32).range(2..=65_536))]
    rows: Option<u32>,
    /// Columns of the sheet
    #[arg(long, value_name = "C", requires = "rows", value_parser = clap::value_parser!(u32).range(2..=65_536))]
    cols: Option<u32>,
    /// Frames to time, after some that are not [default: about three seconds' worth]
    #[arg(long, value_name = "F", value_parser = clap::value_parser!(u32).range(1..))]
    frames: Option<u32>,
    /// Which kernels [default: all that solve it]
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = parser())]
    kernels: Option<Vec<Which>>,
}

/// A scene to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum What {
    /// The disturbed sheet of `taffeta bench grid`, with explicit springs
    Grid,
    /// S1's drop of a sheet on a ball, of `taffeta bench ice`, with implicit constraints
    Ice,
}

/// Kernels to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    /// The engine's.
    Engine,
    /// The engine's, each sub-step on its own, as the papers have them.
    Plain,
    /// A paper's.
    Paper(PaperKernels),
}

/// One measurement.
#[derive(Clone, Copy, Debug)]
pub struct KernelRun {
    /// What is run.
    pub what: What,
    /// Rows and columns.
    pub sides: [u32; 2],
    /// By which kernels.
    pub kernels: Which,
}

/// Of the sheet of `taffeta bench grid`: frame [s], sub-step [s], spacing [m], mass of a node [kg], stiffness [N/m] and
/// damping [kg/s] of a spring.
const GRID: (f64, f64, f64, f64, f64, f64) = (1.0 / 30.0, 1e-3, 0.01, 1e-3, 60.0, 0.01);
/// Of S1's drop: nodes of a side, side [m], step, which is a frame [s], mass of a node, stiffness and damping of a spring.
const DROP: (u32, f64, f64, f64, f64, f64) = (34, 2.0, 0.016, 0.1, 2e4, 0.1);
/// Frames before the sheet lies on the ball, and frames from there on in which it slides over it.
const DROPPED: (u32, u32) = (20, 180);
/// Iterations of S1's solver in each step. S1 does not say how many it has. There are more springs than ways to move, so
/// that no pulls fulfil the equations, and conjugate gradients first approach them and then go away for good: at 34 × 34
/// the drop stays below 3 times the lengths at rest with 10 iterations, with 5 or 20 below 5 times, with 50 it blows up.
const ITERATIONS: u32 = 10;

/// Measures what is asked for.
pub fn run(args: &Args) -> Result<(), Failure> {
    let side = args.n.unwrap_or(if args.what == What::Ice { DROP.0 } else { 160 });
    let sides = args.rows.zip(args.cols).map_or([side; 2], |(rows, cols)| [rows, cols]);
    let all = all().filter(|&kernels| args.what.takes(kernels)).collect();
    let chosen = args.kernels.clone().unwrap_or(all);
    if let Some(odd) = chosen.iter().find(|&&kernels| !args.what.takes(kernels)) {
        let what = if args.what == What::Ice { "has no constraints" } else { "is for `ice`" };
        return Err(Failure::Input(format!("--kernels {} {what}", odd.name())));
    }
    for kernels in chosen {
        let run = KernelRun { what: args.what, sides, kernels };
        let line = run.run(args.frames).map_err(Failure::Input)?;
        writeln!(io::stdout(), "{line}").map_err(|error| Failure::Work(format!("output: {error}")))?;
    }
    Ok(())
}

fn all() -> impl Iterator<Item = Which> + Clone {
    [Which::Engine, Which::Plain].into_iter().chain(PaperKernels::ALL.map(Which::Paper))
}

fn parser() -> impl TypedValueParser<Value = Which> {
    PossibleValuesParser::new(all().map(Which::name))
        .try_map(|text| all().find(|kernels| kernels.name() == text).ok_or("no kernels"))
}

impl Which {
    fn name(self) -> &'static str {
        match self {
            Self::Engine => "engine",
            Self::Plain => "plain",
            Self::Paper(kernels) => kernels.name(),
        }
    }

    fn on(self, gpu: Gpu) -> GpuOptions {
        match self {
            Self::Engine => gpu.into(),
            Self::Plain => GpuOptions { kernels: GpuKernels::Plain, ..gpu.into() },
            Self::Paper(kernels) => kernels.on(gpu),
        }
    }
}

impl What {
    fn takes(self, kernels: Which) -> bool {
        match kernels {
            Which::Engine => true,
            Which::Paper(PaperKernels::Constraints(_)) => self == Self::Ice,
            Which::Plain | Which::Paper(_) => self == Self::Grid,
        }
    }
}

impl KernelRun {
    /// The command that does the same.
    pub fn command(&self) -> String {
        let Self { what, sides: [rows, cols], kernels } = self;
        let what = if *what == What::Ice { "ice" } else { "grid" };
        let sides = if rows == cols { format!("--n {rows}") } else { format!("--rows {rows} --cols {cols}") };
        format!("taffeta-papers kernels {what} {sides} --kernels {}", kernels.name())
    }

    fn scene(&self) -> Scene {
        match self.what {
            What::Grid => grid(self.sides),
            What::Ice => drop(self.sides, matches!(self.kernels, Which::Paper(_))),
        }
    }

    /// Times so many frames, or as many as a few seconds allow.
    ///
    /// # Errors
    /// Where there is no GPU, or the kernels do not run the scene on it.
    pub fn run(&self, frames: Option<u32>) -> Result<Value, String> {
        let gpu = Gpu::open(&Choice::from_env()).map_err(|error| error.to_string())?;
        let scene = self.scene();
        let options = Options { gpu: Some(self.kernels.on(gpu)), ..Options::default() };
        let mut simulation = Simulation::new(&scene, &options).map_err(|error| error.to_string())?;
        let advance = |simulation: &mut Simulation, frames: u32| {
            let start = Instant::now();
            simulation.advance(frames).map_err(|error| error.to_string())?;
            Ok::<f64, String>(start.elapsed().as_secs_f64() * 1e3 / f64::from(frames))
        };
        let most = match self.what {
            What::Grid => {
                simulation.disturb(0.1 * GRID.2, 1);
                u32::MAX
            }
            What::Ice => {
                advance(&mut simulation, DROPPED.0)?;
                DROPPED.1
            }
        };
        let timed = timing::of_frames(frames, most, true, |frames| advance(&mut simulation, frames))?;
        Ok(self.line(&simulation, scene.time.substeps(), &timed))
    }

    fn line(&self, simulation: &Simulation, substeps: u32, timed: &timing::Timed) -> Value {
        let springs = simulation.bodies().iter().flat_map(|body| &body.springs);
        let [min, median, max] = timed.spread();
        let solver = simulation.report().solver;
        json!({
            "bench": if self.what == What::Ice { "ice" } else { "grid" },
            "kernels": self.kernels.name(),
            "backend": simulation.backend(),
            "device": simulation.device(),
            "precision": simulation.precision().to_string(),
            "n": self.sides,
            "nodes": simulation.bodies().iter().map(|body| body.nodes).sum::<usize>(),
            "springs": springs.map(|(_, count)| count).sum::<usize>(),
            "substeps_per_frame": substeps,
            "frames": timed.frames,
            "ms_per_frame": {"min": min, "median": median, "max": max},
            "steps_per_s": 1e3 * f64::from(substeps) / median,
            "iterations": solver.iterations,
            "residual": solver.residual,
        })
    }
}

fn sheet([rows, cols]: [u32; 2], spacing: f64, mass: f64, k: f64, damping: f64) -> Body {
    let extent = |nodes: u32| f64::from(nodes - 1) * spacing;
    Body::cloth("sheet", Mesh::grid(rows, cols, [extent(cols), extent(rows)]))
        .with_mass(Mass::Node(mass))
        .structural(k, damping)
        .shear(k, damping)
        .bend(k, damping)
}

/// A level sheet that hangs by two corners.
fn grid(sides: [u32; 2]) -> Scene {
    let (frame, step, spacing, mass, k, damping) = GRID;
    let sheet = sheet(sides, spacing, mass, k, damping).pin(Select::nodes([0, sides[1] - 1]));
    Scene::new("grid").body(sheet).time(frame, step)
}

/// S1's drop (figure 15), by the equations of S1 or by the engine's. Sheets of other sizes have its spacing, mass of a node
/// and step.
fn drop(sides: [u32; 2], printed: bool) -> Scene {
    let (side, extent, step, mass, k, damping) = DROP;
    let ball = Collider::sphere([0.0; 3], 0.5).offset(0.01).friction(0.3);
    let floor = Collider::plane([0.0, -0.5, 0.0], [0.0, 1.0, 0.0]).friction(0.3);
    let falling = sheet(sides, extent / f64::from(side - 1), mass, k, damping).at([0.0, 0.55, 0.0]);
    let mut scene = Scene::new("drop").body(falling).collider(ball).collider(floor).time(step, step);
    scene.solver.method = Method::Ice;
    if printed {
        scene.solver.ice.form = ConstraintForm::Printed;
        scene.solver.ice.max_iterations = ITERATIONS;
    }
    scene
}
