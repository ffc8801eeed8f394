//! Loads on the GPU: wind, drag, point loads and torques of the scene, forces by the user, and those of elements by node.

use crate::assembly::Assembly;
use crate::cpu::CpuBackend;
use crate::elements::gpu::{ElementTables, Elements};
use crate::elements::load::build::LoadKind;
use crate::elements::load::cpu;
use crate::elements::load::gpu_layout::{FORCE, IS_LOAD, Load, TORQUE};
use crate::gpu::bodies::Bodies;
use crate::gpu::feature::{Command, Feature, Features, Upload};
use crate::gpu::kernels::{Choice, Name};
use crate::gpu::layout::{Four, GROUP, Substep};
use crate::gpu::partition::fill;
use crate::gpu::schedule::Fused;
use crate::plan;
use crate::step::{Op, Stage};
use crate::topology::Csr;
use taffeta_gpu::{Bindable, Buffer, Gpu, GpuError, Shader, shaders};

/// Its shaders.
pub const SHADERS: &[Shader] =
    shaders!("elements/load", ["alone.wgsl", "given.wgsl", "load.wgsl", "stages.wgsl"]);

/// What kernels import, where they have no other choice: of loads, wind and drag alone.
pub const DEFAULTS: &[Shader] = &[("loads", "#import elements/load/alone.wgsl\n")];

/// For kernels that take loads from the buffer in which they were summed up.
pub const GIVEN: &[Choice] = &[("loads", "elements/load/given.wgsl")];

/// Loads on the host.
#[derive(Default)]
pub struct LoadTables {
    pub loads: Vec<Load>,
    pub nodes: Vec<u32>,
    /// Which of the scene's loads they are.
    pub numbers: Vec<usize>,
    /// Loads, then forces of elements, of each place; without rows where there are neither.
    pub by_node: Csr,
}

impl LoadTables {
    /// Those of some bodies with these elements.
    pub fn new(bodies: &Bodies<'_>, elements: &ElementTables) -> Self {
        let mut tables = Self::default();
        for (number, load) in bodies.assembly.loads().iter().enumerate() {
            // A load is on one body.
            if !load.nodes.first().is_some_and(|&node| bodies.has(node)) {
                continue;
            }
            let (kind, vector, about, torque) = match load.kind {
                LoadKind::Force(force) => (FORCE, force, [0.0; 3], 0.0),
                LoadKind::Torque { axis, value, about } => (TORQUE, axis, about, value),
            };
            tables.numbers.push(number);
            tables.loads.push(Load {
                vector: vector.map(|c| c as f32),
                kind,
                about: about.map(|c| c as f32),
                torque: torque as f32,
                first: tables.nodes.len() as u32,
                count: load.nodes.len() as u32,
                factor: 0.0,
                padding: 0,
            });
            tables.nodes.extend(load.nodes.iter().map(|&node| bodies.local(node as usize)));
        }
        // Loads come first in a node's row, in the scene's order.
        let of_load = |(load, number): (&Load, u32)| {
            let range = load.first as usize..(load.first + load.count) as usize;
            tables.nodes[range].iter().map(move |&node| (node, number | IS_LOAD)).collect::<Vec<_>>()
        };
        let mut rows: Vec<(u32, u32)> = tables.loads.iter().zip(0..).flat_map(of_load).collect();
        rows.extend(elements.corners());
        tables.by_node = Csr::new(bodies.len(), rows.into_iter());
        tables
    }
}

/// Loads on the device.
pub struct Loads {
    loads: Buffer<Load>,
    /// As they are on the host.
    described: Vec<Load>,
    numbers: Vec<usize>,
    nodes: Buffer<u32>,
    starts: Buffer<u32>,
    by_node: Buffer<u32>,
    scales: Buffer<f32>,
    input_forces: Buffer<Four>,
    /// How many forces by the user there are in this frame.
    input_count: usize,
    /// Workgroups for one invocation a place.
    groups: usize,
}

impl Loads {
    /// Takes tables to the device, of so many places.
    pub fn new(gpu: &Gpu, tables: &LoadTables, places: usize) -> Result<Self, GpuError> {
        Ok(Self {
            loads: gpu.buffer_from("loads", &tables.loads)?,
            described: tables.loads.clone(),
            numbers: tables.numbers.clone(),
            nodes: gpu.buffer_from("nodes with loads", &tables.nodes)?,
            starts: gpu.buffer_from("rows of loads and elements", &tables.by_node.offsets)?,
            by_node: gpu.buffer_from("loads and elements by node", &tables.by_node.items)?,
            scales: gpu.buffer("scales of loads", 1)?,
            input_forces: gpu.buffer("forces by the user", 1)?,
            input_count: 0,
            groups: places.div_ceil(GROUP),
        })
    }

    /// Whether anything but wind and drag acts on nodes beside springs, so that loads are summed up beforehand.
    pub fn are_given(&self, features: &Features) -> bool {
        let elements = features.get::<Elements>().is_some_and(Elements::any_explicit);
        elements || !self.described.is_empty() || self.input_count > 0
    }

    /// Puts factors of torques that the CPU has found, by the scene's loads.
    fn put_factors(&self, gpu: &Gpu, torques: &[f32], scales: &[f32]) {
        let factor = |(load, &number): (&Load, &usize)| {
            let torque = torques.get(number).copied().unwrap_or(0.0);
            Load { factor: if load.kind == TORQUE { torque } else { scales[number] }, ..*load }
        };
        let loads: Vec<Load> = self.described.iter().zip(&self.numbers).map(factor).collect();
        self.loads.write(gpu, 0, &loads);
    }
}

impl Feature for Loads {
    fn buffers(&self, _: usize) -> Vec<(&'static str, &dyn Bindable)> {
        vec![
            ("loads", &self.loads),
            ("load_nodes", &self.nodes),
            ("node_starts", &self.starts),
            ("node_elements", &self.by_node),
            ("scales", &self.scales),
            ("input_forces", &self.input_forces),
        ]
    }

    fn kernels<'f>(&'f self, features: &'f Features, _: Stage) -> Vec<Fused<'f>> {
        let scale = vec![Command::run(Name::new("scale_loads"), self.loads.len())];
        let sum = || vec![Command::run(Name::new("loads_all"), self.groups)];
        let gathers = features.get::<Elements>().is_some_and(Elements::any_explicit);
        let all: &[Op] = if gathers { &[Op::Loads, Op::Gather] } else { &[Op::Loads] };
        vec![Fused::new(&[Op::Elements], scale), Fused::new(all, sum())]
    }

    fn bytes(&self, _: &Assembly) -> usize {
        self.numbers.len() * size_of::<f32>()
    }

    fn adopt_state(&self, gpu: &Gpu, cpu: &mut CpuBackend<f32>, substep: &plan::Substep<f32>) {
        let torques = cpu.feature::<cpu::Loads<f32>>().map_or(&[][..], |loads| loads.torques());
        self.put_factors(gpu, torques, substep.scales());
    }

    fn upload(&mut self, upload: &Upload<'_>, records: &mut [Substep]) -> Result<bool, GpuError> {
        let first = upload.places.start as u32;
        let inside = upload.input.forces.iter().filter(|(node, _)| upload.places.contains(&(*node as usize)));
        let four = |&(node, force): &(u32, [f64; 3])| {
            let [x, y, z] = force.map(|c| c as f32);
            [x, y, z, f32::from_bits(node - first)]
        };
        let forces: Vec<Four> = inside.map(four).collect();
        self.input_count = forces.len();
        let mut scales = Vec::new();
        for (record, substep) in records.iter_mut().zip(upload.substeps) {
            record.wind = substep.wind_force.map(|c| c as f32);
            record.drag = substep.drag as f32;
            record.first_scale = scales.len() as u32;
            record.input_forces = forces.len() as u32;
            scales.extend(self.numbers.iter().map(|&load| substep.scales()[load]));
        }
        let new = fill(upload.gpu, "scales of loads", &mut self.scales, &scales)?;
        Ok(fill(upload.gpu, "forces by the user", &mut self.input_forces, &forces)? | new)
    }
}
