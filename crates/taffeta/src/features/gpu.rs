//! The features of a scene on the GPU, in the order in which they act, the rows that compare them with the CPU, and which
//! bodies go to the device together.

use crate::advice::{Advice, Refusal};
use crate::attachments::gpu::{self as attachments, AttachmentTables, Attachments};
use crate::build::Assembly;
use crate::contact::collider_mesh::gpu::{self as collider_mesh, ColliderMeshes, Words};
use crate::contact::colliders::gpu::{self as colliders, Colliders};
use crate::contact::nodes::gpu::{self as nodes, NodeContact, SelfCollisionTables};
use crate::diagnostics::gpu::{self as diagnostics, Measures};
use crate::elements::KINDS;
use crate::elements::aero::gpu::AirOfSubsteps;
use crate::elements::gpu::{self as elements, ElementTables, Elements};
use crate::elements::load::gpu::{self as loads, LoadTables, Loads};
use crate::elements::spring::gpu::{self as springs, SpringTables, Springs};
use crate::features::on_cpu;
use crate::features::refusals;
use crate::gpu::backend::GpuBackend;
use crate::gpu::bodies::Bodies;
use crate::gpu::boundary::Boundary;
use crate::gpu::feature::{Feature, Features};
use crate::gpu::kernels::{self, Kernels};
use crate::gpu::layout::Four;
use crate::gpu::options::{GpuKernels, GpuOptions};
use crate::gpu::parity::{Row, drawn, formulas};
use crate::gpu::partition::{Partition, Start};
use crate::motion::gpu::{self as motion, Pins, pins};
use crate::motion::gpu_layout::Pin;
use crate::scene::Method;
use crate::solvers::dual::gpu::{self as dual_kernels, Dual};
use crate::solvers::dual::gpu_tables::{self as dual, ConstraintTables};
use crate::solvers::explicit::gpu::{self as explicit, Particles};
use crate::solvers::explicit::patches::{self, Patches};
use crate::solvers::implicit::gpu::{self as implicit_kernels, Implicit};
use crate::solvers::implicit::gpu_tables::{self as implicit, Levelled};
use crate::step::{Marks, Parts, Stage};
use crate::volume::gpu::{self as volume, VolumeTables, Volumes};
use std::ops::Range;
use taffeta_gpu::{GpuError, Shaders};

/// Everything that some bodies need on the device, on the host.
#[derive(Default)]
pub struct Tables {
    /// Position [m] and inverse mass [1/kg], velocity [m/s] and mass [kg], by place.
    pub position: Vec<Four>,
    pub velocity: Vec<Four>,
    pub springs: SpringTables,
    pub elements: ElementTables,
    pub loads: LoadTables,
    pub pins: Vec<Pin>,
    pub volumes: VolumeTables,
    /// Springs that are constraints, or may become some.
    pub constraints: ConstraintTables,
    /// Springs that are solved for by nodes.
    pub levelled: Levelled,
    pub attachments: AttachmentTables,
    pub self_collision: SelfCollisionTables,
}

impl Tables {
    /// Those of some bodies.
    pub fn new(bodies: &Bodies<'_>) -> Result<Self, String> {
        let [position, velocity] = bodies.state();
        let (elements, volumes) = (ElementTables::new(bodies), VolumeTables::new(bodies));
        Ok(Self {
            position,
            velocity,
            springs: SpringTables::new(bodies)?,
            loads: LoadTables::new(bodies, &elements),
            pins: pins(bodies),
            constraints: ConstraintTables::new(bodies)?,
            levelled: Levelled::new(bodies, &elements)?,
            attachments: AttachmentTables::new(bodies, volumes.numbers.len()),
            self_collision: SelfCollisionTables::new(bodies)?,
            elements,
            volumes,
        })
    }

    /// What the bodies have.
    fn parts(&self) -> Parts {
        Parts {
            elements: self.elements.any_explicit(),
            solved: !self.constraints.is_empty() || !self.levelled.is_empty(),
            volumes: !self.volumes.groups.is_empty(),
            restored: self.volumes.restores(),
            attachments: !self.attachments.lists.is_empty(),
            self_contact: !self.self_collision.surfaces.is_empty(),
        }
    }

    /// Number of places.
    pub fn len(&self) -> usize {
        self.position.len()
    }
}

/// The shaders of all features.
pub fn shaders() -> Shaders {
    let all = [
        kernels::SHADERS,
        kernels::DEFAULTS,
        loads::DEFAULTS,
        colliders::DEFAULTS,
        implicit_kernels::DEFAULTS,
        springs::SHADERS,
        elements::SHADERS,
        loads::SHADERS,
        motion::SHADERS,
        explicit::SHADERS,
        colliders::SHADERS,
        collider_mesh::SHADERS,
        volume::SHADERS,
        implicit_kernels::SHADERS,
        dual_kernels::SHADERS,
        attachments::SHADERS,
        nodes::SHADERS,
        diagnostics::SHADERS,
    ];
    let of_kinds = KINDS.iter().map(|kind| kind.shaders);
    Shaders::new(all.into_iter().chain(of_kinds).flatten().copied())
}

/// The rows that compare the kernels of all features with their twins.
pub fn rows() -> Vec<Row> {
    [
        crate::solvers::explicit::parity::ROWS,
        drawn::ROWS,
        crate::volume::parity::ROWS,
        crate::solvers::dual::parity::ROWS,
        crate::solvers::implicit::parity::ROWS,
        crate::attachments::parity::ROWS,
        crate::contact::nodes::parity::ROWS,
        &crate::elements::parity::rows(),
        crate::diagnostics::parity::ROWS,
        formulas::ROWS,
    ]
    .concat()
}

/// A scene on the GPU. The error says what does not fit.
pub fn on_gpu(options: &GpuOptions, assembly: Assembly) -> Result<GpuBackend, Refusal> {
    let gpu = &options.gpu;
    if let Some(other) = &options.particles {
        other.check(gpu, options.from, &assembly)?;
    }
    refusals::refuse_late(options.from, &assembly)?;
    refusals::refuse_loops(gpu, &assembly)?;
    let (meshes, data) = ColliderMeshes::new(&assembly);
    refusals::refuse_large_meshes(gpu, size_of_val::<[Words]>(&data))?;
    let mut partitions = Vec::new();
    for range in ranges(&assembly, gpu.largest_binding())? {
        partitions.push(partition(options, &Bodies::new(&assembly, range), (&meshes, &data))?);
    }
    if options.kernels == GpuKernels::Tiled {
        refusals::refuse_untiled(gpu, &partitions)?;
    }
    let failure_hint = refusals::failure_hint(gpu, &assembly);
    let others = options.particles.iter().flat_map(|other| other.shaders()).copied();
    let kernels = Kernels::new(gpu.clone(), shaders().with(others));
    Ok(GpuBackend::new(options, assembly, partitions, kernels, failure_hint)?)
}

/// A scene, built twice, whose first stages run on the CPU.
pub fn at_boundary(options: &GpuOptions, [a, b]: [Assembly; 2]) -> Result<Boundary, Refusal> {
    Ok(Boundary::new(on_cpu(a, 1)?, on_gpu(options, b)?, options.from))
}

/// Bodies that go together, so that none of their arrays is larger than `limit` bytes; the error names the body that does
/// not fit even alone.
fn ranges(assembly: &Assembly, limit: u64) -> Result<Vec<Range<usize>>, Refusal> {
    let mut ranges: Vec<Range<usize>> = Vec::new();
    let mut taken = 0;
    for (index, body) in assembly.bodies.iter().enumerate() {
        let (bytes, what) = largest_array(assembly, index);
        if bytes > limit {
            let message = format!(
                "body `{}` needs {bytes} bytes in one piece for its {what}, and the GPU gives a kernel {limit} at most; \
                 the CPU or a coarser mesh would do",
                body.name
            );
            return Err(Refusal::new(message, [Advice::Cpu]));
        }
        match ranges.last_mut() {
            Some(last) if taken + bytes <= limit => {
                last.end = index + 1;
                taken += bytes;
            }
            _ => {
                ranges.push(index..index + 1);
                taken = bytes;
            }
        }
    }
    nodes::check_together(assembly, &ranges, limit)?;
    attachments::check_together(assembly, &ranges, limit)?;
    Ok(ranges)
}

/// Bytes of the largest array that a body needs, and what it holds.
fn largest_array(assembly: &Assembly, body: usize) -> (u64, &'static str) {
    let state = (assembly.bodies[body].places() * size_of::<Four>()) as u64;
    let of_features = [
        springs::arrays(assembly, body),
        elements::arrays(assembly, body),
        volume::arrays(assembly, body),
        dual::arrays(assembly, body),
        implicit::arrays(assembly, body),
        nodes::arrays(assembly, body),
    ];
    let all = of_features.into_iter().flatten().chain([(state, "positions")]);
    all.max_by_key(|array| array.0).unwrap_or_default()
}

/// What is always known of each body, once for all that are alike.
fn classes(bodies: &Bodies<'_>, parts: &Parts) -> Vec<Marks> {
    let springs = match bodies.assembly.solver.method {
        _ if !parts.solved => Marks::NONE,
        Method::Ice => Marks::IMPLICIT.and(Marks::SOLVED),
        _ => Marks::SOLVED,
    };
    let mut classes: Vec<Marks> = Vec::new();
    for (_, body) in bodies.iter() {
        let keeps = parts.volumes && body.volume.is_some() && body.nodes > 0;
        let class = springs.and(if keeps { Marks::VOLUME } else { Marks::NONE });
        if !classes.contains(&class) {
            classes.push(class);
        }
    }
    classes
}

/// Takes some bodies to the device.
fn partition(
    options: &GpuOptions,
    bodies: &Bodies<'_>,
    meshes: (&ColliderMeshes, &[Words]),
) -> Result<Partition, String> {
    let tables = Tables::new(bodies)?;
    let mut parts = tables.parts();
    if options.particles.is_some() {
        // They do both among all else.
        (parts.solved, parts.volumes, parts.restored) = (false, false, false);
    }
    let forces = forces(&tables, options.from > Stage::Elements);
    let features = features(options, bodies, &tables, &parts, meshes).map_err(|error| error.to_string())?;
    let start = Start {
        places: bodies.places.clone(),
        position: tables.position,
        velocity: tables.velocity,
        forces,
        classes: classes(bodies, &parts),
        parts,
    };
    Partition::new(&options.gpu, start, features).map_err(|error| error.to_string())
}

/// Forces by place and what lies behind them, if any kernel leaves some to another.
fn forces(tables: &Tables, apart: bool) -> Vec<Four> {
    if !tables.volumes.weights.is_empty() {
        return tables.volumes.forces(tables.len());
    }
    let Parts { elements, solved, .. } = tables.parts();
    let waits = apart || elements || solved || !tables.loads.loads.is_empty();
    vec![[0.0; 4]; if waits { tables.len() } else { 0 }]
}

fn features(
    options: &GpuOptions,
    bodies: &Bodies<'_>,
    tables: &Tables,
    parts: &Parts,
    (meshes, data): (&ColliderMeshes, &[Words]),
) -> Result<Features, GpuError> {
    fn boxed(feature: impl Feature) -> Option<Box<dyn Feature>> {
        Some(Box::new(feature))
    }
    let (gpu, assembly, places) = (&options.gpu, bodies.assembly, bodies.len());
    let of_patches = || patches(options, assembly, tables, parts);
    let (particles, solvers) = match &options.particles {
        Some(other) => (Some(other.feature(gpu, bodies)?), [None, None]),
        None => (
            boxed(Particles::new(gpu, of_patches().as_ref(), places)?),
            [
                Implicit::new(gpu, assembly, &tables.levelled, bodies.places.clone())?.and_then(boxed),
                Dual::new(gpu, assembly, &tables.constraints, places)?.and_then(boxed),
            ],
        ),
    };
    let all = [
        boxed(Loads::new(gpu, &tables.loads, places)?),
        boxed(Elements::new(gpu, &tables.elements)?),
        boxed(AirOfSubsteps),
        boxed(Springs::new(gpu, &tables.springs, places)?),
        boxed(Pins::new(gpu, &tables.pins)?),
        particles,
        boxed(Colliders::new(gpu, meshes, data, places)?),
        boxed(Volumes::new(gpu, &tables.volumes)?),
    ];
    let after = [
        Attachments::new(gpu, assembly, &tables.attachments, places)?.and_then(boxed),
        NodeContact::new(gpu, &tables.self_collision)?.and_then(boxed),
        boxed(Measures::new(gpu, places)?),
    ];
    Ok(Features::new(all.into_iter().chain(solvers).chain(after).flatten().collect()))
}

/// How bodies are cut up so that several sub-steps can be taken at once, where that pays.
fn patches(options: &GpuOptions, assembly: &Assembly, tables: &Tables, parts: &Parts) -> Option<Patches> {
    let colliders = &assembly.colliders;
    let room = patches::room(options.gpu.limits());
    match options.kernels {
        _ if colliders.iter().any(|collider| collider.mesh().is_some()) => None,
        GpuKernels::Best => Patches::whole(&tables.springs, parts, room, colliders.len()),
        GpuKernels::Tiled => Patches::rimmed(&tables.springs, parts, room),
        _ => None,
    }
}
