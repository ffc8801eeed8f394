//! How to run on a GPU.

use crate::gpu::paper::ConstraintProduct;
use crate::step::Stage;
use taffeta_gpu::Gpu;

/// Which kernels move the particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GpuKernels {
    /// Ours, several sub-steps at once where that pays.
    #[default]
    Best,
    /// Ours, each sub-step on its own.
    Plain,
    /// Ours, two sub-steps at once on tiles of grids in the memory of workgroups.
    Tiled,
    /// As Va, Choi and Hong 2021 print it: a thread a node of a grid, 32 × 32 a group. To compare with.
    NodeCentric,
    /// As Va, Choi and Hong 2023 print it: a thread a spring, forces added by compare and swap. To compare with.
    SpringCentric,
    /// As Va, Choi and Hong 2021 print implicit constraints: eleven kernels, conjugate gradients. To compare with.
    Constraints(ConstraintProduct),
}

impl GpuKernels {
    /// Whether they are those of a paper, which do whole sub-steps.
    pub(crate) fn is_of_paper(self) -> bool {
        matches!(self, Self::NodeCentric | Self::SpringCentric | Self::Constraints(_))
    }
}

/// How to run on a GPU.
#[derive(Clone, Debug)]
pub struct GpuOptions {
    /// The device.
    pub gpu: Gpu,
    /// The first stage that it does; those before it are done on the CPU, step by step, to find where the two differ.
    pub from: Stage,
    /// Kernels.
    pub kernels: GpuKernels,
}

impl From<Gpu> for GpuOptions {
    fn from(gpu: Gpu) -> Self {
        Self { gpu, from: Stage::default(), kernels: GpuKernels::default() }
    }
}
