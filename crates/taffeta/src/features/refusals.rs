//! What is refused on a GPU, and what may end a run there.

use crate::advice::{Advice, Refusal, Warning};
use crate::assembly::Assembly;
use crate::contact::collider_mesh::surface::MeshShape;
use crate::contact::collider_mesh::tree::WALK_TURNS;
use crate::gpu::partition::Partition;
use crate::solvers::explicit::gpu::Particles;
use crate::solvers::explicit::patches;
use crate::step::Stage;
use std::sync::Arc;
use taffeta_gpu::Gpu;

/// Refuses more colliders than the loops of a software adapter come to the end of.
pub fn refuse_loops(gpu: &Gpu, assembly: &Assembly) -> Result<(), Refusal> {
    let colliders = assembly.colliders().len();
    let turns = patches::collider_turns(colliders, meshes(assembly).count());
    if !gpu.info().is_software() || turns <= patches::MOST_TURNS {
        return Ok(());
    }
    let message = format!(
        "the scene has {colliders} colliders, and contact may take {turns} iterations of a loop, \
         where a software adapter ends it after {}; the CPU would do",
        patches::MOST_TURNS
    );
    Err(Refusal::new(message, [Advice::Cpu]))
}

/// What may have ended a run, other than the scene: loops of a software adapter through the triangles of colliders.
pub fn failure_hint(gpu: &Gpu, assembly: &Assembly) -> Option<Warning> {
    let triangles: usize = meshes(assembly).map(|mesh| mesh.triangles.len()).sum();
    (triangles > 0 && gpu.info().is_software()).then(|| {
        let message = format!(
            "Or a node was near so many of the colliders' {triangles} triangles that it took more than the {} iterations \
             that a software adapter has for it; a run on the CPU would tell",
            WALK_TURNS
        );
        Warning::new(message, [Advice::Cpu])
    })
}

fn meshes(assembly: &Assembly) -> impl Iterator<Item = &MeshShape> {
    assembly.colliders().iter().filter_map(|collider| collider.mesh()).map(Arc::as_ref)
}

/// Refuses springs that are constraints on positions.
pub fn refuse_positions(assembly: &Assembly) -> Result<(), Refusal> {
    if assembly.position_constraints().iter().all(Option::is_none) {
        return Ok(());
    }
    let message = "solver.method is \"xpbd\", which does not run on a GPU yet; the CPU would do";
    Err(Refusal::new(message, [Advice::Cpu]))
}

/// Refuses meshes of colliders that are more than a kernel can see.
pub fn refuse_large_meshes(gpu: &Gpu, bytes: usize) -> Result<(), Refusal> {
    let limit = gpu.largest_binding();
    if bytes as u64 <= limit {
        return Ok(());
    }
    let message = format!(
        "the meshes among the colliders take {bytes} bytes, and the GPU does not give a kernel more than {limit} in one piece; \
         the CPU, coarser meshes or fewer poses would do"
    );
    Err(Refusal::new(message, [Advice::Cpu]))
}

/// Refuses to take over a scene with volumes behind the stage in which bodies are summed up, one whose nodes touch each
/// other behind that in which they are found, and one whose surfaces do in a part of a sub-step.
pub fn refuse_late(from: Stage, assembly: &Assembly) -> Result<(), Refusal> {
    let surface = assembly.bodies.iter().find(|body| body.surface_contact().is_some());
    if let Some(body) = surface.filter(|_| from > Stage::Elements) {
        return Err(format!(
            "body `{}` has self_collision.form = \"triangles\", and a GPU takes over such scenes at stage `{}`, not at `{}`",
            body.name,
            Stage::Elements.name(),
            from.name()
        )
        .into());
    }
    let contact = assembly.bodies.iter().find_map(|body| Some((body, body.contact_key()?)));
    if let Some((body, key)) = contact.filter(|_| from > Stage::Pairs) {
        return Err(format!(
            "body `{}` has {key}, and a GPU takes over such scenes at stage `{}` at the latest, not at `{}`",
            body.name,
            Stage::Pairs.name(),
            from.name()
        )
        .into());
    }
    if !assembly.attachments().is_empty() && from > Stage::Attach {
        return Err(format!(
            "nodes are sewn, tethered or held by pins that break, and a GPU takes over such scenes at stage `{}` at the \
             latest, not at `{}`",
            Stage::Attach.name(),
            from.name()
        ).into());
    }
    let solves = (0..assembly.bodies.len()).any(|body| assembly.is_solved_for(body));
    if solves && from > Stage::Constraints {
        return Err(format!(
            "the method is \"{}\", and a GPU takes over such scenes at stage `{}` at the latest, not at `{}`",
            assembly.solver.method.name(),
            Stage::Constraints.name(),
            from.name()
        )
        .into());
    }
    let kept = assembly.volumes().next();
    let Some((body, _)) = kept.filter(|_| from > Stage::Volumes) else { return Ok(()) };
    Err(format!(
        "body `{}` keeps its volume, and a GPU takes over such scenes at stage `{}` at the latest, not at `{}`",
        body.name,
        Stage::Volumes.name(),
        from.name()
    ).into())
}

/// Refuses what the tiled kernels cannot do.
pub fn refuse_untiled(gpu: &Gpu, partitions: &[Partition]) -> Result<(), Refusal> {
    let is_tiled = |one: &Partition| one.features.get::<Particles>().is_some_and(Particles::has_patches);
    if partitions.iter().all(is_tiled) {
        return Ok(());
    }
    Err(format!(
        "the tiled kernels are for scenes of grids alone without self_collision and without meshes as colliders, whose springs are no constraints, with {} bytes of memory in a workgroup; this GPU has {}",
        patches::rimmed_bytes(),
        gpu.limits().max_compute_workgroup_storage_size
    ).into())
}
