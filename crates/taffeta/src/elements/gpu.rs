//! Elements on the GPU: forces are found element by element; nodes gather them with their loads.

use crate::build::Assembly;
use crate::cpu::CpuBackend;
use crate::diagnostics::FrameSums;
use crate::diagnostics::gpu::{capped, sum_groups};
use crate::elements::aero::cpu::AirPanels;
use crate::elements::cpu;
use crate::elements::hinge::cpu::Hinges;
use crate::gpu::bodies::Bodies;
use crate::gpu::feature::{Command, Feature, Features, Upload};
use crate::gpu::kernels::Name;
use crate::gpu::layout::{Air, Four, GROUP, Hinge, Panel, Substep};
use crate::gpu::schedule::Fused;
use crate::plan;
use crate::step::{Op, Stage};
use taffeta_gpu::{Bindable, Buffer, DispatchList, Gpu, GpuError, ReadBack};

/// Bytes of the array of forces of a body's elements, and what it holds.
pub fn arrays(assembly: &Assembly, body: usize) -> Vec<(u64, &'static str)> {
    let body = &assembly.bodies[body];
    let panels = if assembly.panels.len() > 0 { body.triangles() } else { 0 };
    let forces = body.hinges.len() * 4 + panels;
    vec![((forces * size_of::<Four>()) as u64, "forces of hinges and panels")]
}

/// Elements on the host.
#[derive(Default)]
pub struct ElementTables {
    pub hinges: Vec<Hinge>,
    /// Triangles that air acts on.
    pub panels: Vec<Panel>,
    /// Hinges and panels of the scene before them.
    before: [usize; 2],
}

impl ElementTables {
    /// Those of some bodies.
    pub fn new(bodies: &Bodies<'_>) -> Self {
        let earlier = &bodies.assembly.bodies[..bodies.range.start];
        let all = &bodies.assembly.panels.corners;
        let panels_before = all.iter().filter(|corners| (corners[0] as usize) < bodies.places.start);
        let before = [earlier.iter().map(|body| body.hinges.len()).sum(), panels_before.count()];
        Self { hinges: hinges(bodies), panels: panels(bodies), before }
    }

    /// Where the forces of panels begin among those of elements.
    pub fn first_panel_force(&self) -> usize {
        4 * self.hinges.len()
    }

    /// Whether there are any.
    pub fn is_empty(&self) -> bool {
        self.hinges.is_empty() && self.panels.is_empty()
    }

    /// For each corner of each element, its node and where its force is among those of elements.
    pub fn corners(&self) -> impl Iterator<Item = (u32, u32)> {
        let hinges = self.hinges.iter().flat_map(|hinge| hinge.corners).zip(0..);
        let first = self.first_panel_force() as u32;
        let of_panel = |(panel, force): (&Panel, u32)| [panel.a, panel.b, panel.c].map(|node| (node, force));
        hinges.chain(self.panels.iter().zip(first..).flat_map(of_panel))
    }
}

fn hinges(bodies: &Bodies<'_>) -> Vec<Hinge> {
    let mut hinges = Vec::new();
    for (_, body) in bodies.iter() {
        let first = bodies.local(body.first);
        hinges.extend(body.hinges.iter().zip(&body.hinge_rest).map(|(corners, rest)| Hinge {
            corners: corners.map(|node| node + first),
            rest_angle: rest.angle as f32,
            rest_steepness: rest.steepness as f32,
            k: body.hinge.k as f32,
            damping: body.hinge.d as f32,
        }));
    }
    hinges
}

fn panels(bodies: &Bodies<'_>) -> Vec<Panel> {
    let all = &bodies.assembly.panels;
    let inside = all.corners.iter().zip(&all.lightness).filter(|(corners, _)| bodies.has(corners[0]));
    let panel = |(corners, &lightness): (&[u32; 3], &f64)| {
        let [a, b, c] = corners.map(|node| bodies.local(node as usize));
        Panel { a, b, c, lightness: lightness as f32 }
    };
    inside.map(panel).collect()
}

/// What the CPU has found of so many hinges and panels behind others: forces on corners of hinges, then on those of panels [N].
pub fn found_on_cpu(
    cpu: &mut CpuBackend<f32>,
    before: [usize; 2],
    [hinges, panels]: [usize; 2],
) -> Vec<Four> {
    let Some(elements) = cpu.feature::<cpu::Elements<f32>>() else { return Vec::new() };
    let mut all: Vec<[f32; 3]> = Vec::new();
    if let Some(set) = elements.set::<Hinges<f32>>() {
        all.extend(set.forces()[before[0]..][..hinges].as_flattened());
    }
    if let Some(set) = elements.set::<AirPanels<f32>>() {
        all.extend(&set.forces()[before[1]..][..panels]);
    }
    all.into_iter().map(|[x, y, z]| [x, y, z, 0.0]).collect()
}

/// Elements on the device.
pub struct Elements {
    hinges: Buffer<Hinge>,
    panels: Buffer<Panel>,
    /// Force on each corner of each hinge, then on all corners of each panel [N].
    forces: Buffer<Four>,
    first_panel_force: u32,
    /// Hinges and panels of the scene before them.
    before: [usize; 2],
    /// By workgroup [J].
    hinge_sums: Buffer<f32>,
    read_hinge_sums: ReadBack<f32>,
}

impl Elements {
    /// Takes tables to the device.
    pub fn new(gpu: &Gpu, tables: &ElementTables) -> Result<Self, GpuError> {
        let sums = sum_groups(tables.hinges.len());
        Ok(Self {
            hinges: gpu.buffer_from("hinges", &tables.hinges)?,
            panels: gpu.buffer_from("panels", &tables.panels)?,
            forces: gpu
                .buffer("forces of hinges and panels", tables.first_panel_force() + tables.panels.len())?,
            first_panel_force: tables.first_panel_force() as u32,
            before: tables.before,
            hinge_sums: gpu.buffer("sums over hinges", sums)?,
            read_hinge_sums: gpu.read_back("sums over hinges", sums)?,
        })
    }

    /// Whether there are any.
    pub fn any(&self) -> bool {
        self.hinges.len() + self.panels.len() > 0
    }

    /// Number of hinges and of panels.
    fn counts(&self) -> [usize; 2] {
        [self.hinges.len(), self.panels.len()]
    }
}

impl Feature for Elements {
    fn buffers(&self, _: usize) -> Vec<(&'static str, &dyn Bindable)> {
        vec![
            ("hinges", &self.hinges),
            ("panels", &self.panels),
            ("element_forces", &self.forces),
            ("hinge_sums", &self.hinge_sums),
        ]
    }

    fn kernels<'f>(&'f self, _: &'f Features, _: Stage) -> Vec<Fused<'f>> {
        let [hinges, panels] = self.counts().map(|count| count.div_ceil(GROUP));
        let forces = vec![
            Command::run(Name::new("bend_hinges"), hinges),
            Command::run(Name::new("blow_on_panels"), panels),
        ];
        let sums = vec![Command::run(Name::new("measure_hinges"), self.hinge_sums.len())];
        vec![Fused::new(&[Op::Elements], forces), Fused::new(&[Op::MeasureTiles], sums)]
    }

    fn upload(&mut self, upload: &Upload<'_>, records: &mut [Substep]) -> Result<bool, GpuError> {
        for (record, substep) in records.iter_mut().zip(upload.substeps) {
            record.air = Air::of(substep.air.as_ref(), self.first_panel_force);
        }
        Ok(false)
    }

    fn take_over(&self, gpu: &Gpu, cpu: &mut CpuBackend<f32>, _: &plan::Substep<f32>) {
        self.forces.write(gpu, 0, &found_on_cpu(cpu, self.before, self.counts()));
    }

    fn copy(&self, list: &mut DispatchList) {
        list.copy(&self.hinge_sums, &self.read_hinge_sums);
    }

    fn measure(&self, gpu: &Gpu, sums: &mut FrameSums) -> Result<(), GpuError> {
        let mut numbers = Vec::new();
        self.read_hinge_sums.take(gpu, &mut numbers)?;
        sums.hinges += numbers.iter().map(|&energy| capped(energy)).sum::<f64>();
        Ok(())
    }
}
