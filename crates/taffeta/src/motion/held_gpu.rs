//! The forces on nodes that pins hold, on the GPU. Kernels that carry out a whole sub-step keep no forces, so that those of a
//! frame's last sub-step are found apart.

use crate::gpu::bodies::Bodies;
use crate::gpu::feature::{Command, Feature, Features, Upload};
use crate::gpu::kernels::Name;
use crate::gpu::layout::{Four, GROUP, Substep};
use crate::gpu::schedule::Fused;
use crate::report::FrameSums;
use crate::step::{Op, Stage};
use std::ops::Range;
use taffeta_gpu::{Bindable, Buffer, DispatchList, Gpu, GpuError, ReadBack};

/// Nodes that pins hold among some bodies.
#[derive(Default)]
pub struct HeldTables {
    /// Their places.
    pub nodes: Vec<u32>,
    /// Which of the scene's they are, and how many those are.
    range: Range<usize>,
    all: usize,
}

impl HeldTables {
    /// Those of some bodies.
    pub fn new(bodies: &Bodies<'_>) -> Self {
        let held = bodies.assembly.held();
        let [start, end] = [bodies.places.start, bodies.places.end]
            .map(|place| held.partition_point(|one| (one.node as usize) < place));
        let nodes = held[start..end].iter().map(|one| bodies.local(one.node as usize)).collect();
        Self { nodes, range: start..end, all: held.len() }
    }
}

/// Keeps the forces of the last sub-step.
pub struct HeldForces {
    nodes: Buffer<u32>,
    forces: Buffer<Four>,
    read_forces: ReadBack<Four>,
    range: Range<usize>,
    all: usize,
    /// Whether they are those of the frame.
    known: bool,
}

impl HeldForces {
    /// Takes tables to the device; `None` where nothing is held.
    pub fn new(gpu: &Gpu, tables: &HeldTables) -> Result<Option<Self>, GpuError> {
        let count = tables.nodes.len();
        if count == 0 {
            return Ok(None);
        }
        Ok(Some(Self {
            nodes: gpu.buffer_from("held nodes", &tables.nodes)?,
            forces: gpu.buffer("forces on held nodes", count)?,
            read_forces: gpu.read_back("forces on held nodes", count)?,
            range: tables.range.clone(),
            all: tables.all,
            known: false,
        }))
    }

    /// Keeps the forces as they are.
    pub fn command<'f>(&self) -> Command<'f> {
        Command::run(Name::new("keep_held_forces"), self.nodes.len().div_ceil(GROUP))
    }
}

impl Feature for HeldForces {
    fn buffers(&self, _: usize) -> Vec<(&'static str, &dyn Bindable)> {
        vec![("held_nodes", &self.nodes), ("held_forces", &self.forces)]
    }

    fn kernels<'f>(&'f self, _: &'f Features, _: Stage) -> Vec<Fused<'f>> {
        vec![Fused { writes_state: true, ..Fused::new(&[Op::HeldForces], vec![self.command()]) }]
    }

    fn upload(&mut self, upload: &Upload<'_>, _: &mut [Substep]) -> Result<bool, GpuError> {
        self.known |= !upload.substeps.is_empty();
        Ok(false)
    }

    fn start_frame(&mut self, _: &Gpu) {
        self.known = false;
    }

    fn copy(&self, list: &mut DispatchList) {
        list.copy(&self.forces, &self.read_forces);
    }

    fn measure(&self, gpu: &Gpu, sums: &mut FrameSums) -> Result<(), GpuError> {
        let mut forces = Vec::new();
        self.read_forces.take(gpu, &mut forces)?;
        if self.known {
            sums.held.resize(self.all, [0.0; 3]);
            for (sum, [x, y, z, _]) in sums.held[self.range.clone()].iter_mut().zip(forces) {
                *sum = [x, y, z].map(f64::from);
            }
        }
        Ok(())
    }
}
