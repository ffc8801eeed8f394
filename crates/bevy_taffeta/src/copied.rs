//! The copying way to the screen: the mesh asset is changed in every frame.

use crate::drawn::viewed;
use crate::running::Running;
use bevy::prelude::*;

/// Puts places and normals of now into the meshes of bodies that are not drawn where they are simulated, where they are not
/// what they were.
pub fn draw(mut worlds: Query<&mut Running>, meshes: Option<ResMut<Assets<Mesh>>>) {
    let Some(mut meshes) = meshes else { return };
    for mut running in worlds.iter_mut().filter(|running| !running.shared) {
        let frame = running.simulation.frame();
        let Running { bodies, copied: [before, now], share, .. } = &mut *running;
        for body in bodies.iter_mut().filter(|body| body.copied != Some((frame, body.view))) {
            let Some(mut mesh) = meshes.get_mut(&body.mesh.handle) else { continue };
            let place = |vertex: usize| {
                let (a, b) = (before[body.first_vertex + vertex], now[body.first_vertex + vertex]);
                std::array::from_fn(|i| a[i] + *share * (b[i] - a[i]))
            };
            let (places, normals) = viewed(&body.mesh.drawn, &body.view, place);
            mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, places);
            mesh.insert_attribute(Mesh::ATTRIBUTE_NORMAL, normals);
            body.copied = Some((frame, body.view));
        }
    }
}
