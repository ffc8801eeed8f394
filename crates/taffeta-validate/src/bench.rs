//! Runs scenes until they rest, and keeps what was found.

use crate::runs::Progress;
use crate::specimen::Case;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::{Path, PathBuf};
use taffeta::taffeta_gpu::Gpu;
use taffeta::{GpuOptions, Options, Precision, Simulation};
use taffeta_io::load_scene;

/// How much is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// Some meshes of each test: for continuous integration.
    Quick,
    /// All of them.
    Whole,
}

/// A number of ours beside one that is expected.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// What is compared, with its unit.
    pub quantity: String,
    /// On which mesh: pattern, size, turn.
    pub mesh: String,
    /// How: solver, backend, precision.
    pub solver: String,
    /// What was found.
    pub ours: f64,
    /// What is expected; none where a row only reports.
    pub expected: Option<f64>,
    /// How far off it is, in the unit of `allowed`.
    pub error: Option<f64>,
    /// How far off it may be.
    pub allowed: Option<f64>,
    /// The unit of `error`: `%`, `points`, or one of SI.
    pub unit: String,
    /// Where the row is in the group's plot: the name of its line, and its place along.
    pub plot: Option<(String, f64)>,
    /// The scene, relative to the report.
    pub scene: String,
    /// What else is to be said.
    pub note: String,
}

impl Row {
    /// Whether it is as near as it must be; a row that only reports passes.
    pub fn passed(&self) -> bool {
        match (self.error, self.allowed) {
            (Some(error), Some(allowed)) => error.abs() <= allowed,
            (None, Some(_)) => false,
            _ => true,
        }
    }

    /// A number of ours without a verdict.
    pub fn new(quantity: impl Into<String>, ours: f64, variant: &Variant) -> Self {
        Self {
            quantity: quantity.into(),
            mesh: variant.mesh.clone(),
            solver: variant.solver.to_string(),
            ours,
            expected: None,
            error: None,
            allowed: None,
            unit: String::new(),
            plot: None,
            scene: format!("scenes/{}.toml", variant.name),
            note: String::new(),
        }
    }

    /// Expects a number, within so many per cent of it.
    pub fn within(self, expected: f64, percent: f64) -> Self {
        let error = 100.0 * (self.ours / expected - 1.0);
        Self {
            expected: Some(expected),
            error: Some(error),
            allowed: Some(percent),
            unit: "%".into(),
            ..self
        }
    }

    /// Expects a number, and may be off by so much in its own unit.
    pub fn near(self, expected: f64, allowed: f64, unit: &str) -> Self {
        let error = self.ours - expected;
        Self {
            expected: Some(expected),
            error: Some(error),
            allowed: Some(allowed),
            unit: unit.into(),
            ..self
        }
    }

    /// Is a point of the group's plot.
    pub fn at(self, line: impl Into<String>, x: f64) -> Self {
        Self { plot: Some((line.into(), x)), ..self }
    }

    /// With a remark.
    pub fn noting(self, note: impl Into<String>) -> Self {
        Self { note: note.into(), ..self }
    }
}

/// How a scene is solved, and where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Solver {
    /// Solved for by nodes, or by short explicit steps.
    pub is_implicit: bool,
    /// On a GPU, or on the CPU.
    pub on_gpu: bool,
    /// In 64 bits; a GPU has 32.
    pub is_double: bool,
}

impl Solver {
    /// Implicit, on the CPU, in 32 bits: what users run.
    pub const IMPLICIT: Self = Self { is_implicit: true, on_gpu: false, is_double: false };
    /// Explicit, on the CPU.
    pub const EXPLICIT: Self = Self { is_implicit: false, on_gpu: false, is_double: false };
    /// Implicit, on a GPU.
    pub const GPU: Self = Self { is_implicit: true, on_gpu: true, is_double: false };
    /// Implicit, on the CPU in 64 bits.
    pub const DOUBLE: Self = Self { is_implicit: true, on_gpu: false, is_double: true };

    /// In a file's name.
    pub fn slug(self) -> &'static str {
        match (self.is_implicit, self.on_gpu, self.is_double) {
            (false, false, _) => "explicit",
            (false, true, _) => "explicit-gpu",
            (true, true, _) => "gpu",
            (true, false, true) => "double",
            (true, false, false) => "implicit",
        }
    }

    /// Damping of stretch and bending [s] that lets a strip come to rest soon: that of explicit steps must be small.
    pub fn damping(self) -> [f64; 2] {
        if self.is_implicit { [1e-4, 1e-2] } else { [1e-6, 1e-6] }
    }

    /// The table of a scene.
    pub fn toml(self) -> &'static str {
        if self.is_implicit {
            "[solver]\nmethod = \"ice\"\nice = { form = \"primal\", tolerance = 1e-5, max_iterations = 1000 }\n"
        } else {
            "[solver]\nmethod = \"springs\"\n"
        }
    }
}

impl std::fmt::Display for Solver {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let form = if self.is_implicit { "implicit" } else { "explicit" };
        let place = if self.on_gpu { "GPU" } else { "CPU" };
        write!(f, "{form}, {place}{}", if self.is_double { ", 64 bits" } else { "" })
    }
}

/// One scene of a test.
#[derive(Clone, Debug)]
pub struct Variant {
    /// Of its files.
    pub name: String,
    /// Its mesh, in words.
    pub mesh: String,
    /// How it is solved.
    pub solver: Solver,
}

/// What a job does.
pub type Work = dyn Fn(&Bench<'_>) -> Result<Vec<Row>, String> + Send + Sync;

/// A piece of work: a few scenes that depend on each other.
pub struct Job {
    /// What is done, in a line.
    pub title: String,
    /// Whether it is left out where there is no GPU.
    pub needs_gpu: bool,
    /// Does it.
    pub run: Box<Work>,
}

impl Job {
    /// A job by its title.
    pub fn new(
        title: impl Into<String>,
        run: impl Fn(&Bench<'_>) -> Result<Vec<Row>, String> + Send + Sync + 'static,
    ) -> Self {
        Self { title: title.into(), needs_gpu: false, run: Box::new(run) }
    }

    /// One that runs on what a case says.
    pub fn of(
        case: Case,
        run: impl Fn(&Bench<'_>) -> Result<Vec<Row>, String> + Send + Sync + 'static,
    ) -> Self {
        let title = format!("{}, {}", case.variant("").mesh, case.solver);
        Self { needs_gpu: case.solver.on_gpu, ..Self::new(title, run) }
    }
}

/// Where scenes are written and run.
pub struct Bench<'a> {
    /// The folder of the report.
    pub folder: &'a Path,
    /// The GPU, where there is one.
    pub gpu: Option<&'a Gpu>,
    /// Who is asked whether to go on.
    pub progress: &'a dyn Progress,
}

/// What a job says when the user stops it.
pub const STOPPED: &str = "stopped";

/// A scene that runs.
pub struct Running<'a> {
    /// The simulation.
    pub simulation: Simulation,
    bench: &'a Bench<'a>,
    file: PathBuf,
}

/// When a scene is at rest, or given up.
#[derive(Clone, Copy, Debug)]
pub struct Rest {
    /// How far nodes may still move in a window [m].
    pub moves: f64,
    /// The window [s].
    pub window: f64,
    /// Longest time [s].
    pub longest: f64,
}

impl Bench<'_> {
    /// Writes a mesh beside the scenes, for `mesh.file`.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn write(&self, file: &str, text: &str) -> Result<(), String> {
        let path = self.folder.join("scenes").join(file);
        fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))
    }

    /// Writes a scene and starts it. Where it is explicit, its sub-steps are half as long as the longest stable ones.
    ///
    /// # Errors
    /// Where it cannot be written, is refused, or there is no GPU for it.
    pub fn start(&self, variant: &Variant, scene: &str) -> Result<Running<'_>, String> {
        if variant.solver.is_implicit {
            return self.run(variant, scene);
        }
        let longest = self.run(variant, scene)?.simulation.largest_stable_step_folded();
        let stepped = scene.replacen("[time]\n", &format!("[time]\nmax_step = {:?}\n", 0.5 * longest), 1);
        self.run(variant, &stepped)
    }

    /// Writes a scene and starts it as it is.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub fn run(&self, variant: &Variant, scene: &str) -> Result<Running<'_>, String> {
        let file = format!("{}.toml", variant.name);
        self.write(&file, scene)?;
        let path = self.folder.join("scenes").join(file);
        let loaded = load_scene(&path, &[]).map_err(|error| error.to_string())?;
        let precision = if variant.solver.is_double { Precision::F64 } else { Precision::F32 };
        let mut options =
            Options { threads: Some(1), precision, find_largest_steps: true, ..Options::default() };
        if variant.solver.on_gpu {
            let gpu = self.gpu.ok_or("there is no GPU to run it on")?;
            options.gpu = Some(GpuOptions::from(gpu.clone()));
        }
        let simulation = Simulation::new(&loaded.scene, &options)
            .map_err(|error| loaded.source.explain_build(&error).to_string())?;
        Ok(Running { simulation, bench: self, file: path })
    }
}

impl Running<'_> {
    /// Positions of all vertices [m].
    pub fn positions(&self) -> Vec<[f64; 3]> {
        let mut all = Vec::new();
        self.simulation.positions_f64(&mut all);
        all
    }

    /// Runs a frame.
    ///
    /// # Errors
    /// Where it diverges, or the user stops.
    pub fn step(&mut self) -> Result<(), String> {
        if self.bench.progress.is_stopped() {
            return Err(STOPPED.into());
        }
        self.simulation.step().map_err(|error| format!("{}: {error}", self.file.display()))?;
        Ok(())
    }

    /// Runs for a time [s].
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn run_for(&mut self, seconds: f64) -> Result<(), String> {
        let frames = (seconds / self.simulation.dt()).round() as u64;
        (0..frames).try_for_each(|_| self.step())
    }

    /// Runs until it rests, and says whether it does.
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn settle(&mut self, rest: Rest) -> Result<bool, String> {
        let frames = (rest.window / self.simulation.dt()).ceil().max(1.0) as u64;
        let mut before = self.positions();
        let mut time = 0.0;
        while time < rest.longest {
            for _ in 0..frames {
                self.step()?;
            }
            time += frames as f64 * self.simulation.dt();
            let now = self.positions();
            let moved = before.iter().zip(&now).map(|(a, b)| distance(*a, *b)).fold(0.0, f64::max);
            if moved <= rest.moves {
                return Ok(true);
            }
            before = now;
        }
        Ok(false)
    }
}

/// Distance of two places [m].
pub fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]) * (a[axis] - b[axis])).sum::<f64>().sqrt()
}

impl std::fmt::Display for Row {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ({}; {}): {:.5}", self.quantity, self.mesh, self.solver, self.ours)?;
        if let Some(expected) = self.expected {
            write!(f, " where {expected:.5} is expected")?;
        }
        if let (Some(error), Some(allowed)) = (self.error, self.allowed) {
            write!(f, "; off by {error:.4} {0}, {allowed} {0} allowed", self.unit)?;
        }
        write!(f, "; {}", self.scene)?;
        if self.note.is_empty() { Ok(()) } else { write!(f, "; {}", self.note) }
    }
}
