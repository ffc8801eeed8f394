//! The way to the screen that leaves nothing to copy: a kernel writes places and normals to the buffer that Bevy draws.

use crate::device::SharedGpu;
use crate::drawn::BodyMesh;
use crate::running::Running;
use bevy::mesh::MeshVertexAttribute;
use bevy::prelude::*;
use bevy::render::mesh::RenderMesh;
use bevy::render::mesh::allocator::{MeshAllocator, MeshAllocatorSettings};
use bevy::render::render_asset::RenderAssets;
use bevy::render::render_resource::BufferUsages;
use bevy::render::{ExtractSchedule, MainWorld, RenderApp};
use taffeta::VertexTarget;

/// Lets kernels write to the buffers of meshes, and has them do so before each frame is rendered.
pub fn share_device(app: &mut App) {
    app.init_resource::<SharedGpu>();
    let Some(renderer) = app.get_sub_app_mut(RenderApp) else { return };
    let mut settings = renderer.world_mut().get_resource_or_init::<MeshAllocatorSettings>();
    settings.extra_buffer_usages |= BufferUsages::STORAGE;
    renderer.add_systems(ExtractSchedule, draw);
}

/// Draws all bodies that are simulated on Bevy's device. The main world stands still meanwhile, and what the frame before
/// needed was handed to the queue: nothing changes under the kernel or under the renderer. A mesh that is not in its buffer
/// yet is drawn as it was made.
fn draw(mut main: ResMut<MainWorld>, allocator: Res<MeshAllocator>, meshes: Res<RenderAssets<RenderMesh>>) {
    let mut worlds = main.query::<&mut Running>();
    for mut running in worlds.iter_mut(&mut main).filter(|running| running.shared && !running.halted) {
        let Running { simulation, bodies, halted, .. } = &mut *running;
        for (index, body) in bodies.iter().enumerate() {
            let handle = simulation.bodies()[index].handle;
            let Some(target) = target_of(&body.mesh, &allocator, &meshes) else { continue };
            if let Err(error) = simulation.draw(handle, &target, &body.view) {
                error!("taffeta: {error}");
                *halted = true;
                break;
            }
        }
    }
}

/// Where Bevy keeps the vertices of a mesh.
fn target_of(
    mesh: &BodyMesh,
    allocator: &MeshAllocator,
    meshes: &RenderAssets<RenderMesh>,
) -> Option<VertexTarget> {
    let id = mesh.handle.id();
    let slice = allocator.mesh_vertex_slice(&id)?;
    let layout = &meshes.get(id)?.layout.0;
    let offset = |attribute: MeshVertexAttribute| {
        let found = layout.attribute_ids().iter().position(|id| *id == attribute.id)?;
        Some(layout.layout().attributes[found].offset)
    };
    let (place, normal) = (offset(Mesh::ATTRIBUTE_POSITION)?, offset(Mesh::ATTRIBUTE_NORMAL)?);
    let stride = layout.layout().array_stride;
    (slice.range.len() >= mesh.drawn.vertices.len()).then(|| VertexTarget {
        buffer: (**slice.buffer).clone(),
        first: u64::from(slice.range.start) * stride + place,
        stride,
        normal: normal - place,
    })
}
