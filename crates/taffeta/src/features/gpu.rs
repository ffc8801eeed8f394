//! A scene on the GPU: which bodies go to the device together, and with which features.

use crate::advice::{Advice, Refusal};
use crate::assembly::Assembly;
use crate::contact::collider_mesh::gpu::{ColliderMeshes, Words};
use crate::cpu::team::Team;
use crate::features::{Tables, arrays, check_together, of_gpu, on_cpu, parameters, refusals, shaders};
use crate::gpu::backend::GpuBackend;
use crate::gpu::bodies::Bodies;
use crate::gpu::boundary::Boundary;
use crate::gpu::kernels::Kernels;
use crate::gpu::layout::Four;
use crate::gpu::options::{GpuKernels, GpuOptions};
use crate::gpu::partition::{Partition, Start};
use crate::scene::Method;
use crate::solvers::explicit::patches::{self, Patches};
use crate::step::{Marks, Parts, Stage};
use std::ops::Range;

/// A scene on the GPU. The error says what does not fit.
pub fn on_gpu(options: &GpuOptions, assembly: Assembly) -> Result<GpuBackend, Refusal> {
    let gpu = &options.gpu;
    if let Some(other) = &options.particles {
        other.check(gpu, options.from, &assembly)?;
    }
    refusals::refuse_positions(&assembly)?;
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
    Ok(GpuBackend::new(options, assembly, partitions, kernels, failure_hint, parameters)?)
}

/// A scene, built twice, whose first stages run on the CPU.
pub fn at_boundary(options: &GpuOptions, [a, b]: [Assembly; 2]) -> Result<Boundary, Refusal> {
    Ok(Boundary::new(on_cpu(a, Team::new(1))?, on_gpu(options, b)?, options.from))
}

/// Bodies that go together, so that none of their arrays is larger than `limit` bytes; the error names the body that does
/// not fit even alone.
fn ranges(assembly: &Assembly, limit: u64) -> Result<Vec<Range<usize>>, Refusal> {
    let mut ranges: Vec<Range<usize>> = Vec::new();
    let mut taken = 0;
    for (index, body) in assembly.bodies.iter().enumerate() {
        let (bytes, what) =
            arrays(assembly, index).into_iter().max_by_key(|array| array.0).unwrap_or_default();
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
    check_together(assembly, &ranges, limit)?;
    Ok(ranges)
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
        let keeps = parts.volumes && body.volume().is_some() && body.nodes > 0;
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
        (parts.solved, parts.volumes, parts.restored, parts.held) = (false, false, false, false);
    }
    let forces = forces(&tables, options.from > Stage::Elements);
    let features = of_gpu(options, bodies, &tables, &parts, meshes).map_err(|error| error.to_string())?;
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
    let Parts { elements, solved, held, .. } = tables.parts();
    let waits = apart || elements || solved || held || !tables.loads.loads.is_empty();
    vec![[0.0; 4]; if waits { tables.len() } else { 0 }]
}

/// How bodies are cut up so that several sub-steps can be taken at once, where that pays.
pub fn patches(options: &GpuOptions, assembly: &Assembly, tables: &Tables, parts: &Parts) -> Option<Patches> {
    let colliders = assembly.colliders();
    let room = patches::room(options.gpu.limits());
    match options.kernels {
        _ if colliders.iter().any(|collider| collider.mesh().is_some()) => None,
        GpuKernels::Best => Patches::whole(&tables.springs, parts, room, colliders.len()),
        GpuKernels::Tiled => Patches::rimmed(&tables.springs, parts, room),
        _ => None,
    }
}
