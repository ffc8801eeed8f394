//! The copying way to the screen: the mesh asset is changed in every frame.

use crate::drawn::viewed;
use crate::running::Running;
use bevy::prelude::*;

/// Puts places and normals of now into the meshes of bodies that are not drawn where they are simulated.
pub fn draw(worlds: Query<&Running>, meshes: Option<ResMut<Assets<Mesh>>>) {
    let Some(mut meshes) = meshes else { return };
    for running in worlds.iter().filter(|running| !running.shared) {
        let [before, now] = &running.copied;
        let share = running.share;
        for body in &running.bodies {
            let Some(mut mesh) = meshes.get_mut(&body.mesh.handle) else { continue };
            let place = |vertex: usize| {
                let (a, b) = (before[body.first_vertex + vertex], now[body.first_vertex + vertex]);
                std::array::from_fn(|i| a[i] + share * (b[i] - a[i]))
            };
            let (places, normals) = viewed(&body.mesh.drawn, &body.view, place);
            mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, places);
            mesh.insert_attribute(Mesh::ATTRIBUTE_NORMAL, normals);
        }
    }
}
