//! Bodies from meshes of Bevy.

use crate::body::{Cloth, SoftBody};
use crate::collider::SoftCollider;
use crate::step::Refused;
use crate::world::{DefaultWorld, SoftWorld};
use bevy::mesh::skinning::SkinnedMesh;
use bevy::mesh::{Indices, MeshAccessError, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;
use std::sync::Arc;
use taffeta::scene;
use taffeta::topology::{Polygons, Surface, Uvs};
use taffeta_io::{MeshError, surface_from};

/// Makes cloth, a soft body or a collider of the mesh that the entity is drawn with, once that is loaded, as [`Cloth::from_mesh`] does. The
/// mesh may come from any asset: of a glTF, the entity with `Mesh3d` is a child of the node. A body is drawn by a mesh of its own from
/// then on, with its first texture coordinates, but without tangents and vertex colours. What cannot be made a body, as a mesh that a
/// skin moves, is [refused](Refused), and is drawn as it was.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_taffeta::prelude::*;
///
/// // What is painted red on it is held.
/// fn hang(mut commands: Commands, assets: Res<AssetServer>) {
///     commands.spawn((
///         Mesh3d(assets.load("banner.glb#Mesh0/Primitive0")),
///         FromMesh3d::Cloth,
///         SoftMaterial::preset("cotton"),
///         Pins::hold(Select::group("red")),
///     ));
/// }
/// # bevy::ecs::system::assert_is_system(hang);
/// ```
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub enum FromMesh3d {
    /// An open or closed surface, as [`Cloth`].
    Cloth,
    /// A closed surface, as [`SoftBody`].
    SoftBody,
    /// What bodies meet, as [`SoftCollider`]; with an inside where the surface is closed.
    Collider,
}

impl Cloth {
    /// Cloth of a mesh of triangles. Vertices at one place become one node, so that seams of texture or shading hold together; what else
    /// was repaired is in [`BodyInfo::repairs`](taffeta::BodyInfo::repairs). Pins and others choose its vertices by their numbers in the
    /// mesh, or by these groups: `red`, `green`, `blue` and `alpha`, where a vertex colour is above one half (paint on black: white has
    /// all of them), and `joint 0`, `joint 1` and so on, the vertices that a joint of a skin has the largest weight of.
    ///
    /// # Errors
    /// Where the mesh has no triangles with an area, or its data are with the renderer alone.
    ///
    /// ```
    /// use bevy::prelude::*;
    /// use bevy_taffeta::prelude::*;
    ///
    /// let mesh = Plane3d::new(Vec3::Y, Vec2::new(0.5, 0.4)).mesh().subdivisions(10).build();
    /// let sheet = Cloth::from_mesh(&mesh)?;
    /// assert_eq!(sheet.0.nodes(), 144);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_mesh(mesh: &Mesh) -> Result<Self, MeshError> {
        shape_of(mesh).map(Self)
    }
}

impl SoftBody {
    /// A soft body of a mesh of triangles, as [`Cloth::from_mesh`] has them. Whether they close around a volume is found when the
    /// world is built.
    ///
    /// # Errors
    /// As [`Cloth::from_mesh`].
    pub fn from_mesh(mesh: &Mesh) -> Result<Self, MeshError> {
        shape_of(mesh).map(Self)
    }
}

impl SoftCollider {
    /// A collider of a mesh of triangles, as [`Cloth::from_mesh`] has them; with an inside where they close. Where a ball, a box or a
    /// capsule would do, that is faster.
    ///
    /// # Errors
    /// As [`Cloth::from_mesh`].
    pub fn from_mesh(mesh: &Mesh) -> Result<Self, MeshError> {
        shape_of(mesh).map(|mesh| Self(scene::Collider::mesh(mesh)))
    }
}

fn shape_of(mesh: &Mesh) -> Result<scene::Mesh, MeshError> {
    surface_of(mesh).map(|surface| scene::Mesh::Surface(Arc::new(surface)))
}

/// Makes bodies of entities whose meshes are loaded.
pub fn make_bodies(
    mut commands: Commands,
    waiting: Query<(NameOrEntity, &FromMesh3d, &Mesh3d, Has<SkinnedMesh>)>,
    meshes: Option<Res<Assets<Mesh>>>,
    worlds: Query<(), With<SoftWorld>>,
    default_world: Query<Entity, With<DefaultWorld>>,
    parents: Query<&ChildOf>,
    mut refused: MessageWriter<Refused>,
) {
    for (name, kind, drawn, is_skinned) in &waiting {
        let Some(mesh) = meshes.as_ref().and_then(|meshes| meshes.get(&drawn.0)) else { continue };
        let mut entity = commands.entity(name.entity);
        entity.remove::<FromMesh3d>();
        let made = if is_skinned {
            Err(MeshError::new("a skin moves the mesh; one without a skin would do"))
        } else {
            shape_of(mesh)
        };
        match (made, kind) {
            (Ok(mesh), FromMesh3d::Cloth) => {
                entity.insert(Cloth(mesh));
            }
            (Ok(mesh), FromMesh3d::SoftBody) => {
                entity.insert(SoftBody(mesh));
            }
            (Ok(mesh), FromMesh3d::Collider) => {
                entity.insert(SoftCollider(scene::Collider::mesh(mesh)));
            }
            (Err(error), _) => {
                error!("taffeta: {name}: {error}");
                let above = std::iter::once(name.entity).chain(parents.iter_ancestors(name.entity));
                let world = above.into_iter().find(|&one| worlds.contains(one));
                if let Some(world) = world.or_else(|| default_world.iter().next()) {
                    let error = scene::SceneError::new("mesh", error.to_string()).into();
                    refused.write(Refused { world, entity: Some(name.entity), error });
                }
            }
        }
    }
}

/// The surface of a mesh.
fn surface_of(mesh: &Mesh) -> Result<Surface, MeshError> {
    let corners = corners_of(mesh)?;
    let places = match attribute(mesh, Mesh::ATTRIBUTE_POSITION.id)? {
        Some(VertexAttributeValues::Float32x3(places)) => places,
        _ => return Err(MeshError::new("it has no positions of three 32-bit numbers")),
    };
    let uvs = match attribute(mesh, Mesh::ATTRIBUTE_UV_0.id)? {
        // Pictures are counted from their top.
        Some(VertexAttributeValues::Float32x2(uvs)) => {
            Some(Uvs { coords: uvs.iter().map(|[u, v]| [*u, 1.0 - v]).collect(), corners: corners.clone() })
        }
        _ => None,
    };
    let mut groups = painted(mesh)?;
    groups.extend(of_joints(mesh)?);
    let mut polygons = Polygons::default();
    corners.as_chunks::<3>().0.iter().for_each(|triangle| polygons.push(triangle));
    let vertices = places.iter().map(|place| place.map(f64::from)).collect();
    surface_from(vertices, polygons, uvs, groups)
}

/// The vertices of its triangles.
fn corners_of(mesh: &Mesh) -> Result<Vec<u32>, MeshError> {
    let indices: Vec<u32> = match mesh.try_indices_option().map_err(with_renderer)? {
        Some(Indices::U16(all)) => all.iter().map(|&index| index.into()).collect(),
        Some(Indices::U32(all)) => all.clone(),
        None => (0..mesh.count_vertices() as u32).collect(),
    };
    match mesh.primitive_topology() {
        PrimitiveTopology::TriangleList if indices.len().is_multiple_of(3) => Ok(indices),
        PrimitiveTopology::TriangleList => {
            let count = indices.len();
            Err(MeshError::new(format!("its triangles have {count} corners, which is no multiple of three")))
        }
        PrimitiveTopology::TriangleStrip => {
            // Every other triangle of a strip is turned.
            let turned = |(index, corners): (usize, &[u32])| {
                let [a, b, c] = [corners[0], corners[1], corners[2]];
                if index.is_multiple_of(2) { [a, b, c] } else { [b, a, c] }
            };
            Ok(indices.windows(3).enumerate().flat_map(turned).collect())
        }
        other => {
            Err(MeshError::new(format!("it is drawn as {other:?}; a list or strip of triangles would do")))
        }
    }
}

fn attribute(
    mesh: &Mesh,
    id: bevy::mesh::MeshVertexAttributeId,
) -> Result<Option<&VertexAttributeValues>, MeshError> {
    mesh.try_attribute_option(id).map_err(with_renderer)
}

fn with_renderer(_: MeshAccessError) -> MeshError {
    MeshError::new("its data are with the renderer alone; RenderAssetUsages::all() for the mesh would do")
}

/// Groups of what vertex colours have above one half.
fn painted(mesh: &Mesh) -> Result<Vec<(String, Vec<u32>)>, MeshError> {
    let above: Vec<[bool; 4]> = match attribute(mesh, Mesh::ATTRIBUTE_COLOR.id)? {
        Some(VertexAttributeValues::Float32x4(all)) => all.iter().map(|one| one.map(|x| x > 0.5)).collect(),
        Some(VertexAttributeValues::Unorm8x4(all)) => all.iter().map(|one| one.map(|x| x > 127)).collect(),
        Some(VertexAttributeValues::Unorm16x4(all)) => {
            all.iter().map(|one| one.map(|x| x > 32_767)).collect()
        }
        _ => return Ok(Vec::new()),
    };
    let group = |(channel, name): (usize, &str)| {
        let members = (0..).zip(&above).filter(|(_, above)| above[channel]).map(|(vertex, _)| vertex);
        (name.to_owned(), members.collect())
    };
    Ok(["red", "green", "blue", "alpha"].into_iter().enumerate().map(group).collect())
}

/// Groups of what each joint of a skin has the largest weight of.
fn of_joints(mesh: &Mesh) -> Result<Vec<(String, Vec<u32>)>, MeshError> {
    let joints = attribute(mesh, Mesh::ATTRIBUTE_JOINT_INDEX.id)?;
    let weights = attribute(mesh, Mesh::ATTRIBUTE_JOINT_WEIGHT.id)?;
    let (Some(VertexAttributeValues::Uint16x4(joints)), Some(VertexAttributeValues::Float32x4(weights))) =
        (joints, weights)
    else {
        return Ok(Vec::new());
    };
    let mut members = std::collections::BTreeMap::<u16, Vec<u32>>::new();
    for (vertex, (joints, weights)) in (0..).zip(joints.iter().zip(weights)) {
        let first_of_largest = (0..4).rev().max_by(|&a, &b| weights[a].total_cmp(&weights[b]));
        members.entry(joints[first_of_largest.unwrap_or(0)]).or_default().push(vertex);
    }
    Ok(members.into_iter().map(|(joint, vertices)| (format!("joint {joint}"), vertices)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::asset::RenderAssetUsages;

    /// Two triangles over a square, as a list whose corners are vertices of their own.
    fn square() -> Mesh {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
        let vertices: Vec<[f32; 3]> = [0, 2, 1, 1, 2, 3].map(|corner: usize| corners[corner]).to_vec();
        Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::all())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vertices)
    }

    #[test]
    fn vertices_at_one_place_are_one_node_and_keep_their_texture() {
        let uvs: Vec<[f32; 2]> = (0..6).map(|vertex| [0.1 * vertex as f32, 0.25]).collect();
        let mesh = square().with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs);
        let surface = surface_of(&mesh).unwrap();
        assert_eq!((surface.nodes.len(), surface.vertices.len(), surface.triangles.len()), (4, 6, 2));
        assert_eq!(surface.uvs.unwrap().coords[5], [0.5, 0.75]);
        assert!(surface.repairs.iter().any(|repair| repair.contains("weld")), "{:?}", surface.repairs);
    }

    #[test]
    fn strips_are_the_surface_of_their_list() {
        let corners = vec![[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0_f32], [1.0, 0.0, 1.0]];
        let strip = Mesh::new(PrimitiveTopology::TriangleStrip, RenderAssetUsages::all())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners)
            .with_inserted_indices(Indices::U16(vec![0, 1, 2, 3]));
        let normals = [surface_of(&strip), surface_of(&square())].map(|surface| {
            let Surface { nodes, triangles, .. } = surface.unwrap();
            let normal = |triangle: &[u32; 3]| {
                let [a, b, c] = triangle.map(|node| Vec3::from(nodes[node as usize].map(|x| x as f32)));
                (b - a).cross(c - a)
            };
            triangles.iter().map(normal).collect::<Vec<_>>()
        });
        assert_eq!(normals, [vec![Vec3::Y; 2], vec![Vec3::Y; 2]]);
    }

    #[test]
    fn paint_and_joints_make_groups() {
        let colours = vec![[1.0, 0.0, 0.0, 1.0], [0.51, 0.5, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0_f32]];
        let colours: Vec<[f32; 4]> = colours.into_iter().cycle().take(6).collect();
        let joints = VertexAttributeValues::Uint16x4(vec![[7, 3, 0, 0]; 6]);
        let weights: Vec<[f32; 4]> =
            (0..6).map(|vertex| [0.2 * vertex as f32, 1.0 - 0.2 * vertex as f32, 0.0, 0.0]).collect();
        let mesh = square()
            .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colours)
            .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, joints)
            .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights);
        let groups = surface_of(&mesh).unwrap().groups;
        let of = |name: &str| &groups.iter().find(|(other, _)| other == name).expect("a group").1[..];
        assert_eq!((of("red"), of("green")), (&[0, 1, 3, 4][..], &[2, 5][..]));
        assert_eq!((of("blue"), of("joint 3"), of("joint 7")), (&[][..], &[0, 1, 2][..], &[3, 4, 5][..]));
    }

    #[test]
    fn what_is_no_surface_of_triangles_is_said() {
        let lines = Mesh::new(PrimitiveTopology::LineList, RenderAssetUsages::all())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0_f32; 3]; 2]);
        let odd = square().with_inserted_indices(Indices::U32(vec![0, 1]));
        let beyond = square().with_inserted_indices(Indices::U32(vec![0, 1, 9]));
        let flat = square().with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0_f32; 3]; 6]);
        for (mesh, said) in [(lines, "LineList"), (odd, "2 corners"), (beyond, "9"), (flat, "area")] {
            let error = surface_of(&mesh).unwrap_err().to_string();
            assert!(error.contains(said), "{error}");
        }
    }
}
