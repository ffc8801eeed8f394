//! A body's mesh, and where it is drawn.

use crate::running::Running;
use bevy::asset::RenderAssetUsages;
use bevy::math::Affine3A;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use taffeta::scene;
use taffeta::topology::Surface;
use taffeta::{Simulation, View};
use taffeta_io::output::Drawn;

/// A body's mesh, and which vertices and nodes of the simulation are its vertices.
#[derive(Clone, Default)]
pub struct BodyMesh {
    pub handle: Handle<Mesh>,
    pub drawn: Drawn,
}

/// What is drawn of a body's surface. A grid has texture coordinates from 0 to 1 along columns and rows.
pub fn drawn_of(surface: &Surface, shape: &scene::Mesh) -> Drawn {
    let mut drawn = Drawn::of(surface);
    if let (None, scene::Mesh::Grid(grid)) = (&drawn.uvs, shape) {
        let (rows, cols) = ((grid.rows - 1).max(1) as f32, (grid.cols - 1).max(1) as f32);
        let uv = |&node: &u32| [(node % grid.cols) as f32 / cols, (node / grid.cols) as f32 / rows];
        drawn.uvs = Some(drawn.vertices.iter().map(uv).collect());
    }
    drawn
}

/// A mesh of vertices at `places` [m]. One that is `shared` is given away to the renderer.
pub fn mesh_of(drawn: &Drawn, places: Vec<[f32; 3]>, normals: Vec<[f32; 3]>, shared: bool) -> Mesh {
    let usages = if shared {
        RenderAssetUsages::RENDER_WORLD
    } else {
        RenderAssetUsages::RENDER_WORLD | RenderAssetUsages::MAIN_WORLD
    };
    let (topology, indices) = if drawn.triangles.is_empty() {
        (PrimitiveTopology::LineList, drawn.links.as_flattened())
    } else {
        (PrimitiveTopology::TriangleList, drawn.triangles.as_flattened())
    };
    let mut mesh = Mesh::new(topology, usages)
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, places)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
        .with_inserted_indices(Indices::U32(indices.to_vec()));
    if let Some(uvs) = &drawn.uvs {
        // Pictures are counted from their top.
        let uvs: Vec<[f32; 2]> = uvs.iter().map(|[u, v]| [*u, 1.0 - v]).collect();
        mesh.insert_attribute(Mesh::ATTRIBUTE_UV_0, uvs);
    }
    mesh
}

/// Places and normals of a body's vertices in the coordinates of a view.
pub fn viewed(
    drawn: &Drawn,
    view: &View,
    place: impl Fn(usize) -> [f32; 3],
) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
    let rows = view.places.map(|[x, y, z, shift]| (Vec3::new(x, y, z), shift));
    let local = |x: Vec3| Vec3::from_array(rows.map(|(row, shift)| row.dot(x) + shift));
    let places: Vec<Vec3> =
        drawn.vertices.iter().map(|&vertex| local(place(vertex as usize).into())).collect();
    // Vertices at a seam of the texture share a node, and its normal.
    let nodes =
        drawn.nodes.iter().filter(|&&node| node != u32::MAX).max().map_or(0, |&node| node as usize + 1);
    let mut sums = vec![Vec3::ZERO; nodes];
    for triangle in &drawn.triangles {
        let [a, b, c] = triangle.map(|vertex| places[vertex as usize]);
        for vertex in triangle {
            sums[drawn.nodes[*vertex as usize] as usize] += (b - a).cross(c - a);
        }
    }
    let normal = |&node: &u32| {
        let sum = sums.get(node as usize).copied().unwrap_or_default();
        sum.try_normalize().unwrap_or(Vec3::Y).to_array()
    };
    (places.iter().map(Vec3::to_array).collect(), drawn.nodes.iter().map(normal).collect())
}

/// Into the coordinates of a transform, a share of the way between two states.
pub fn view_into(transform: &GlobalTransform, alpha: f32) -> View {
    let Affine3A { matrix3, .. } = transform.affine();
    let inverse = transform.affine().inverse();
    let rows = inverse.matrix3.transpose();
    let places = [
        (rows.x_axis, inverse.translation.x),
        (rows.y_axis, inverse.translation.y),
        (rows.z_axis, inverse.translation.z),
    ];
    let normals = [matrix3.x_axis, matrix3.y_axis, matrix3.z_axis];
    View {
        alpha,
        places: places.map(|(row, shift)| [row.x, row.y, row.z, shift]),
        normals: normals.map(|axis| axis.to_array()),
    }
}

/// The vertices of all bodies as they are [m].
pub fn all_places(simulation: &Simulation) -> Vec<[f32; 3]> {
    let mut places = Vec::new();
    simulation.positions_f32(&mut places);
    places
}

/// Finds how bodies are drawn: in the coordinates of their entities, which may move.
pub fn aim(mut worlds: Query<&mut Running>, transforms: Query<&GlobalTransform>) {
    for mut running in &mut worlds {
        let alpha = running.share;
        for body in &mut running.bodies {
            if let Ok(transform) = transforms.get(body.entity) {
                body.view = view_into(transform, alpha);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use taffeta::scene::Mesh as Shape;

    #[test]
    fn places_and_normals_are_seen_from_an_entity_that_is_turned_and_stretched() {
        let surface = taffeta::topology::shapes::surface(&Shape::grid(2, 2, [2.0, 2.0])).unwrap();
        let drawn = drawn_of(&surface, &Shape::grid(2, 2, [2.0, 2.0]));
        assert_eq!(drawn.uvs.as_deref().unwrap()[1], [1.0, 0.0]);
        let turn = Quat::from_rotation_x(0.7);
        let transform: GlobalTransform = Transform {
            translation: Vec3::new(1.0, 2.0, 3.0),
            rotation: turn,
            scale: Vec3::new(2.0, 3.0, 0.5),
        }
        .into();
        let places = |vertex: usize| surface.vertices[vertex].map(|x| x as f32);
        let (seen, normals) = viewed(&drawn, &view_into(&transform, 1.0), places);
        for (vertex, place) in seen.iter().enumerate() {
            let back = transform.transform_point((*place).into());
            assert!(back.distance(places(vertex).into()) < 1e-5);
        }
        // What Bevy makes of a normal is the surface's own again.
        let matrix = transform.affine().matrix3.inverse().transpose();
        let up = (matrix * Vec3::from(normals[0])).normalize();
        assert!(up.abs_diff_eq(Vec3::Y, 1e-5), "{up}");
    }
}
