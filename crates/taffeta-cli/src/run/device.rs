//! On what a run computes.

use super::args::{Args, Backend};
use super::plan::{Plan, Record};
use crate::console;
use crate::gpu;
use taffeta::scene::Scene;
use taffeta::taffeta_gpu::Gpu;
use taffeta::{GpuOptions, Options, Precision, Simulation, Stage};
use taffeta_io::Loaded;
use taffeta_io::program::{self, Failure, Work, at_once, only_software};

/// What a run computes on.
pub struct Device {
    /// `None`: the CPU.
    pub gpu: Option<GpuOptions>,
    /// Why, where the program has chosen.
    pub why: Option<String>,
}

/// Refuses what cannot go together, before anything is read.
pub fn refuse(args: &Args) -> Result<(), Failure> {
    if args.gpu_from.is_some() && args.backend != Backend::Gpu {
        return Err(Failure::Input("--gpu-from is for --backend gpu".into()));
    }
    match args.precision {
        Some(precision) if args.backend == Backend::Gpu => refuse_precision(precision.precision()),
        _ => Ok(()),
    }
}

/// Refuses what a GPU cannot compute in.
pub fn refuse_precision(precision: Precision) -> Result<(), Failure> {
    if precision == Precision::F32 {
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
        if args.backend == Backend::Gpu {
            // A run that goes on may have been in 64 bits.
            refuse_precision(plan.precision)?;
        }
        if let (Backend::Auto, Some(earlier)) = (args.backend, &plan.earlier) {
            return Ok(Self::kept(&earlier.run, plan.precision));
        }
        let mut device = Self::asked(args.backend, || Work::of(scene, args.threads, plan.precision))?;
        if let (Some(options), Some(from)) = (&mut device.gpu, args.gpu_from) {
            options.from = from;
        }
        Ok(device)
    }

    /// What the user asked for, else what is faster for the `work`.
    pub fn asked(backend: Backend, work: impl FnOnce() -> Work) -> Result<Self, Failure> {
        let gpu = match backend {
            Backend::Auto => return Ok(Self::faster(&work())),
            Backend::Cpu => None,
            Backend::Gpu => {
                Some(gpu::open().map_err(|error| Failure::Input(format!("--backend gpu: {error}")))?)
            }
        };
        Ok(Self { gpu: gpu.map(GpuOptions::from), why: None })
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
                Self::cpu(only_software(gpu.info()))
            }
            Ok(gpu) => Self::on(gpu, "as until now"),
            Err(error) => Self::cpu(error.to_string()),
        }
    }

    /// The GPU where it gains, else the CPU.
    fn faster(work: &Work) -> Self {
        match program::faster(work) {
            Ok((gpu, why)) => Self::on(gpu, &why),
            Err(why) => Self::cpu(why),
        }
    }

    /// The scene on this device. Where the program has chosen a GPU, and the scene does not fit it, on the CPU.
    pub fn build(&mut self, args: &Args, plan: &Plan, loaded: &Loaded) -> Result<Simulation, Failure> {
        let options = |gpu| Options {
            threads: at_once(args.threads),
            precision: plan.precision,
            find_largest_steps: true,
            on_divergence: plan.on_divergence,
            gpu,
            ..Options::default()
        };
        let built = Simulation::new(&loaded.scene, &options(self.gpu.clone()));
        let error = match built {
            Ok(simulation) => return Ok(simulation),
            Err(error) => error,
        };
        if self.gpu.is_none() || args.backend == Backend::Gpu {
            return Err(console::not_built(&loaded.source, &error));
        }
        *self = Self::cpu(format!("the GPU cannot run this scene: {error}"));
        Simulation::new(&loaded.scene, &options(None))
            .map_err(|error| console::not_built(&loaded.source, &error))
    }

    /// What the user should know of the device.
    pub fn notes(&self) -> Vec<String> {
        let Some(options) = &self.gpu else { return Vec::new() };
        let from = (options.from != Stage::default())
            .then(|| format!("stages before {} are done on the CPU, step by step", options.from.name()));
        gpu::software_note(options.gpu.info()).into_iter().chain(from).collect()
    }
}
