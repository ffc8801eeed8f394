//! On what a run computes.

use super::choice::{self, Work};
use super::plan::{Plan, Record};
use super::{Args, Backend};
use crate::failure::Failure;
use crate::gpu;
use taffeta::scene::Scene;
use taffeta::taffeta_gpu::Gpu;
use taffeta::{GpuOptions, Options, Precision, Simulation, Stage};
use taffeta_io::Loaded;

/// Nodes for each thread of the CPU at least, where the user does not say.
const NODES_A_THREAD: u64 = 4096;

/// What a run computes on.
pub struct Device {
    /// `None`: the CPU.
    gpu: Option<GpuOptions>,
    /// Why, where the program has chosen.
    pub why: Option<String>,
}

/// Refuses what cannot go together, before anything is read.
pub fn refuse(args: &Args) -> Result<(), Failure> {
    if args.gpu_from.is_some() && args.backend != Backend::Gpu {
        return Err(Failure::Input("--gpu-from is for --backend gpu".into()));
    }
    match args.precision {
        Some(precision) => refuse_precision(args, precision.precision()),
        None => Ok(()),
    }
}

fn refuse_precision(args: &Args, precision: Precision) -> Result<(), Failure> {
    if args.backend != Backend::Gpu || precision == Precision::F32 {
        return Ok(());
    }
    Err(Failure::Input(
        "--backend gpu computes in 32 bits, not with --precision f64; --precision f32 or --backend cpu would do"
            .into(),
    ))
}

impl Device {
    /// What the user asked for, else what the run that goes on computed on, else what is faster.
    pub fn new(args: &Args, plan: &Plan, scene: &Scene) -> Result<Self, Failure> {
        // A run that goes on may have been in 64 bits.
        refuse_precision(args, plan.precision)?;
        match (args.backend, &plan.earlier) {
            (Backend::Cpu, _) => Ok(Self { gpu: None, why: None }),
            (Backend::Gpu, _) => {
                let gpu = gpu::open().map_err(|error| Failure::Input(format!("--backend gpu: {error}")))?;
                let from = args.gpu_from.unwrap_or_default();
                Ok(Self { gpu: Some(GpuOptions { from, ..gpu.into() }), why: None })
            }
            (Backend::Auto, Some(earlier)) => Ok(Self::kept(&earlier.run, plan.precision)),
            (Backend::Auto, None) => Ok(Self::faster(&work(args, plan, scene))),
        }
    }

    fn cpu(why: String) -> Self {
        Self { gpu: None, why: Some(format!("cpu: {why}")) }
    }

    fn on(gpu: Gpu, why: &str) -> Self {
        Self { gpu: Some(gpu.into()), why: Some(format!("gpu: {why}")) }
    }

    /// What a run that goes on has computed on, if it is there.
    fn kept(earlier: &Record, precision: Precision) -> Self {
        if earlier.backend != "gpu" {
            return Self::cpu("as until now".to_owned());
        }
        if precision == Precision::F64 {
            return Self::cpu("a GPU computes in f32".to_owned());
        }
        match gpu::open() {
            Ok(gpu) if gpu.info().is_software() && !earlier.device.contains(&gpu.info().name) => {
                Self::cpu(choice::only_software(gpu.info()))
            }
            Ok(gpu) => Self::on(gpu, "as until now"),
            Err(error) => Self::cpu(error.to_string()),
        }
    }

    fn faster(work: &Work) -> Self {
        if let Some(why) = work.needs_no_gpu() {
            return Self::cpu(why);
        }
        let gpu = match gpu::open() {
            Ok(gpu) => gpu,
            Err(error) => return Self::cpu(error.to_string()),
        };
        let cost = || gpu::cost(&gpu).map_err(|error| error.to_string());
        let verdict = choice::choose(work, gpu.info(), cost);
        if verdict.gpu { Self::on(gpu, &verdict.why) } else { Self::cpu(verdict.why) }
    }

    /// The scene on this device. Where the program has chosen a GPU, and the scene does not fit it, on the CPU.
    pub fn build(&mut self, args: &Args, plan: &Plan, loaded: &Loaded) -> Result<Simulation, Failure> {
        let options = |gpu| Options {
            threads: args.threads.map(usize::from),
            precision: plan.precision,
            gpu,
        };
        let built = Simulation::new(&loaded.scene, &options(self.gpu.clone()));
        let error = match built {
            Ok(simulation) => return Ok(simulation),
            Err(error) => error,
        };
        if self.gpu.is_none() || args.backend == Backend::Gpu {
            return Err(loaded.source.locate(&error).into());
        }
        *self = Self::cpu(format!("the GPU does not take it: {}", error.message));
        Simulation::new(&loaded.scene, &options(None)).map_err(|error| loaded.source.locate(&error).into())
    }

    /// What the user should know of the device.
    pub fn notes(&self) -> Vec<String> {
        let Some(options) = &self.gpu else { return Vec::new() };
        let from = (options.from != Stage::default())
            .then(|| format!("stages before {} are done on the CPU, step by step", options.from.name()));
        gpu::software_note(options.gpu.info()).into_iter().chain(from).collect()
    }
}

fn work(args: &Args, plan: &Plan, scene: &Scene) -> Work {
    let nodes = scene.bodies.iter().fold(0_u64, |sum, body| sum.saturating_add(body.mesh.nodes()));
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let useful = || all.min(usize::try_from(nodes / NODES_A_THREAD).unwrap_or(all)).max(1);
    Work {
        nodes,
        substeps: scene.time.substeps(),
        threads: args.threads.map_or_else(useful, usize::from),
        precision: plan.precision,
    }
}
