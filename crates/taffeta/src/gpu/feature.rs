//! What a feature is to the GPU's executor: buffers, parameters of sub-steps, and kernels with the passes that they carry out.

use crate::assembly::Assembly;
use crate::backend::{FrameInput, SolverState};
use crate::cpu::CpuBackend;
use crate::extensions::Extensions;
use crate::gpu::kernels::{Name, Overrides};
use crate::gpu::layout::{Four, Substep};
use crate::gpu::schedule::Fused;
use crate::plan;
use crate::report::FrameSums;
use crate::step::Stage;
use std::any::Any;
use std::ops::Range;
use taffeta_gpu::{Bindable, Counts, DispatchList, Gpu, GpuError};

/// One command of a sub-step.
pub enum Command<'f> {
    /// A kernel.
    Dispatch(Dispatch<'f>),
    /// The states before and after change places.
    SwapStates,
    /// What follows is timed by another name.
    Label(&'static str),
}

/// A kernel to run.
pub struct Dispatch<'f> {
    /// Which.
    pub name: Name,
    /// Which part of a feature's buffers it sees, where they are cut up.
    pub part: usize,
    /// How many workgroups.
    pub groups: Groups<'f>,
}

/// Workgroups of a dispatch.
pub enum Groups<'f> {
    /// So many.
    Linear(usize),
    /// So many along two sides, and an offset into a uniform of the feature's own.
    Plane([u32; 2], Option<u32>),
    /// As many as a kernel has counted.
    Counted(&'f Counts, usize),
}

impl Command<'_> {
    /// A kernel in `groups` workgroups.
    pub fn run(name: Name, groups: usize) -> Self {
        Self::run_part(name, 0, groups)
    }

    /// The same on a part of a feature's buffers.
    pub fn run_part(name: Name, part: usize, groups: usize) -> Self {
        Self::Dispatch(Dispatch { name, part, groups: Groups::Linear(groups) })
    }
}

/// The sub-steps that are handed over, and what they are about.
pub struct Upload<'u> {
    /// The device.
    pub gpu: &'u Gpu,
    /// The scene.
    pub assembly: &'u Assembly,
    /// Sub-steps.
    pub substeps: &'u [plan::Substep<f32>],
    /// What the user does in the frame.
    pub input: &'u FrameInput,
    /// The places of the partition.
    pub places: Range<usize>,
    /// Whether the frame ends with them.
    pub last: bool,
}

/// Where nodes are between two frames.
pub struct Seen<'s> {
    /// The device.
    pub gpu: &'s Gpu,
    /// The scene.
    pub assembly: &'s Assembly,
    /// The time [s] before a frame; none after one.
    pub time: Option<f64>,
    /// Positions [m] of all places of the scene.
    pub position: &'s [Four],
    /// What features have found there, for those after them.
    pub found: Extensions,
}

/// A feature on the GPU, of one partition of the scene.
pub trait Feature: Any + Send + Sync {
    /// Its buffers by their names in the shaders. Where they are cut into parts, those of one part.
    fn buffers(&self, part: usize) -> Vec<(&'static str, &dyn Bindable)>;

    /// Fixes numbers of kernels.
    fn overrides(&self, _gpu: &Gpu, _overrides: &mut Overrides) {}

    /// What its kernels carry out. `from` is the first stage that the GPU does.
    fn kernels<'f>(&'f self, _features: &'f Features, _from: Stage) -> Vec<Fused<'f>> {
        Vec::new()
    }

    /// Takes the parameters of sub-steps to the device, and fills in its part of their records. Returns whether any of its
    /// buffers is another one than before.
    fn upload(&mut self, _upload: &Upload<'_>, _records: &mut [Substep]) -> Result<bool, GpuError> {
        Ok(false)
    }

    /// Bytes that a sub-step takes beside its record.
    fn bytes(&self, _assembly: &Assembly) -> usize {
        0
    }

    /// Numbers that are to hold at the end of a sub-step, one after the other over all features.
    fn targets(&self, _substep: &plan::Substep<f32>) -> Vec<f32> {
        Vec::new()
    }

    /// Takes over what the CPU has found before the first stage that the GPU does.
    fn adopt_state(&self, _gpu: &Gpu, _cpu: &mut CpuBackend<f32>, _substep: &plan::Substep<f32>) {}

    /// A frame begins: what is counted over it starts again.
    fn start_frame(&mut self, _gpu: &Gpu) {}

    /// Has what it has measured copied to where the host reads it.
    fn copy(&self, _list: &mut DispatchList) {}

    /// Adds what it has measured; waits for it.
    fn measure(&self, _gpu: &Gpu, _sums: &mut FrameSums) -> Result<(), GpuError> {
        Ok(())
    }

    /// Something was put elsewhere by hand.
    fn relocate(&mut self) {}

    /// Whether it is to see where nodes are before the next frame, or after the last.
    fn looks(&self, _before: bool) -> bool {
        false
    }

    /// Sees where nodes are, if it looks. Returns whether any of its buffers is another one than before.
    fn see(&mut self, _seen: &mut Seen<'_>) -> Result<bool, GpuError> {
        Ok(false)
    }

    /// Dispatches of a sub-step, where they are many.
    fn dispatches(&self) -> usize {
        0
    }

    /// Writes down all that a sub-step may need, for frames that are not repeated.
    fn write_all(&mut self) {}

    /// Whether a frame may find more than there is room for, or need more than is written down, so that it is repeated with more.
    fn may_repeat(&self) -> bool {
        false
    }

    /// Buffers whose contents last from one frame to the next, beside the state.
    fn lasting(&self) -> Vec<&dyn Bindable> {
        Vec::new()
    }

    /// Whether the last frame needed more; waits for it.
    fn is_short(&mut self, _gpu: &Gpu) -> Result<bool, GpuError> {
        Ok(false)
    }

    /// How much of a node's way it has taken at most in a sub-step of the last frame, relative to an edge. Frames in which that is much
    /// are repeated in shorter sub-steps.
    fn taken(&self) -> f64 {
        0.0
    }

    /// Sub-steps are `by` times as long from now on as the last one was: a power of two.
    fn rescale(&mut self, _gpu: &Gpu, _by: f32) -> Result<(), GpuError> {
        Ok(())
    }

    /// Has room for what that frame needed, as far as it came, and writes down more. The state is that before it.
    fn grow(&mut self, _gpu: &Gpu) -> Result<(), GpuError> {
        Ok(())
    }

    /// Adds what it knows from one sub-step to the next; waits for it.
    fn save(&self, _gpu: &Gpu, _state: &mut SolverState) {}

    /// Takes back what [`Self::save`] gave. Returns whether any of its buffers is another one than before.
    fn load(&mut self, _gpu: &Gpu, _state: &SolverState) -> bool {
        false
    }
}

/// The features of a partition.
#[derive(Default)]
pub struct Features(Vec<Box<dyn Feature>>);

impl Features {
    /// In the order in which they act.
    pub fn new(all: Vec<Box<dyn Feature>>) -> Self {
        Self(all)
    }

    /// A feature by its type, where the partition has it.
    pub fn get<F: Feature>(&self) -> Option<&F> {
        self.0.iter().find_map(|feature| (&**feature as &dyn Any).downcast_ref())
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = &dyn Feature> {
        self.0.iter().map(|feature| &**feature)
    }

    /// All of them, to change them between frames.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Box<dyn Feature>> {
        self.0.iter_mut()
    }
}
