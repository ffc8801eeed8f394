//! How to run on a GPU.

use crate::assembly::Assembly;
use crate::gpu::bodies::Bodies;
use crate::gpu::feature::Feature;
use crate::step::Stage;
use std::fmt::Debug;
use std::sync::Arc;
use taffeta_gpu::{Gpu, GpuError, Shader};

/// Which of our kernels move the particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GpuKernels {
    /// Several sub-steps at once where that pays.
    #[default]
    Best,
    /// Each sub-step on its own.
    Plain,
    /// Two sub-steps at once on tiles of grids in the memory of workgroups.
    Tiled,
}

/// Kernels of another crate in place of ours: they do what these do from springs to contact, constraints and volumes among
/// it.
pub trait ParticleKernels: Debug + Send + Sync {
    /// Their shaders, which may import ours.
    fn shaders(&self) -> &'static [Shader];

    /// Says why they cannot run a scene from some stage on.
    fn check(&self, gpu: &Gpu, from: Stage, assembly: &Assembly) -> Result<(), String>;

    /// Takes what they need of some bodies to the device.
    fn feature(&self, gpu: &Gpu, bodies: &Bodies<'_>) -> Result<Box<dyn Feature>, GpuError>;
}

/// How to run on a GPU.
///
/// ```no_run
/// use taffeta::scene::Scene;
/// use taffeta::taffeta_gpu::{Choice, Gpu};
/// use taffeta::{GpuOptions, Options, Simulation};
///
/// # let scene = Scene::new("");
/// let gpu = Gpu::open(&Choice::from_env())?;
/// let options = Options { gpu: Some(GpuOptions::from(gpu)), ..Options::default() };
/// let simulation = Simulation::new(&scene, &options)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct GpuOptions {
    /// The device.
    pub gpu: Gpu,
    /// The first stage that it does; those before it are done on the CPU, step by step, to find where the two differ.
    pub from: Stage,
    /// Kernels, where others than the best are to be compared with them.
    #[doc(hidden)]
    pub kernels: GpuKernels,
    /// Kernels in place of these.
    #[doc(hidden)]
    pub particles: Option<Arc<dyn ParticleKernels>>,
}

impl From<Gpu> for GpuOptions {
    fn from(gpu: Gpu) -> Self {
        Self { gpu, from: Stage::default(), kernels: GpuKernels::default(), particles: None }
    }
}
