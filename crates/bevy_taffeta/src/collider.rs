//! Colliders that follow transforms, and meshes to draw them.

use crate::drawn::mesh_of;
use crate::running::Running;
use bevy::math::primitives::{Capsule3d, Cuboid, Cylinder, Plane3d, Sphere};
use bevy::mesh::{MeshBuilder, Meshable, PrimitiveTopology};
use bevy::prelude::*;
use taffeta::scene::{Bar, Collider, Layers, Shape};
use taffeta::topology::{Placement, Surface, ground, shapes};
use taffeta_io::output::Drawn;

/// What bodies of its world cannot enter: a shape in the coordinates of its transform, which it follows. With keyframes of
/// its own the transform follows them instead. Where poses change the shape of its mesh, the mesh that [`collider_mesh`] makes
/// changes with it.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_taffeta::prelude::*;
///
/// fn obstacles(mut commands: Commands) {
///     commands.spawn((SoftCollider::ground().friction(0.5), Transform::from_xyz(0.0, -1.0, 0.0)));
///     commands.spawn((SoftCollider::sphere(0.3).offset(0.005), Transform::from_xyz(0.0, 0.5, 0.0)));
/// }
/// assert_eq!(SoftCollider::ground().friction(0.5).0.friction, 0.5);
/// ```
#[derive(Component, Clone, Debug)]
#[require(Transform, Visibility)]
pub struct SoftCollider(pub Collider);

fn three(v: Vec3) -> [f64; 3] {
    v.as_dvec3().to_array()
}

impl SoftCollider {
    /// A ball about the origin.
    pub fn sphere(radius: f32) -> Self {
        Self(Collider::sphere([0.0; 3], radius.into()))
    }

    /// Everything below the xz plane.
    pub fn ground() -> Self {
        Self(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]))
    }

    /// A box about the origin, by half of its extent along each axis [m].
    pub fn cuboid(half: Vec3) -> Self {
        Self(Collider::cuboid([0.0; 3], three(half)))
    }

    /// A round bar with round ends about the points `a` and `b` [m].
    pub fn capsule(a: Vec3, b: Vec3, radius: f32) -> Self {
        Self(Collider::capsule(three(a), three(b), radius.into()))
    }

    /// A round bar with flat ends from `a` to `b` [m].
    pub fn cylinder(a: Vec3, b: Vec3, radius: f32) -> Self {
        Self(Collider::cylinder(three(a), three(b), radius.into()))
    }

    /// Coulomb coefficient.
    pub fn friction(self, friction: f64) -> Self {
        Self(self.0.friction(friction))
    }

    /// Distance kept between surface and nodes [m].
    pub fn offset(self, offset: f64) -> Self {
        Self(self.0.offset(offset))
    }

    /// Which bodies it meets.
    pub fn layers(self, layers: Layers) -> Self {
        Self(self.0.layers(layers))
    }

    /// Share of normal speed that is given back.
    pub fn restitution(self, restitution: f64) -> Self {
        Self(self.0.restitution(restitution))
    }
}

/// Half of the side of the square that is drawn of a plane [m].
const PLANE: f32 = 10.0;

/// A mesh that shows a collider in the coordinates of its entity: a square of a plane, the points of a convex hull by the
/// mesh that they are of. `None` where it has not exactly one shape, or its mesh cannot be made.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_taffeta::{collider_mesh, prelude::*};
///
/// let mut meshes = Assets::<Mesh>::default();
/// let table = SoftCollider::cuboid(Vec3::new(0.5, 0.4, 0.5));
/// let shown = Mesh3d(meshes.add(collider_mesh(&table.0).expect("it has one shape")));
/// assert_eq!(meshes.get(&shown.0).map(Mesh::count_vertices), Some(24));
/// ```
pub fn collider_mesh(collider: &Collider) -> Option<Mesh> {
    let placed =
        |mesh: Mesh, place: Transform| mesh.transformed_by(place).transformed_by(transform_of(collider, &[]));
    Some(match collider.shape()? {
        Shape::Sphere(ball) => {
            placed(Sphere::new(ball.radius as f32).mesh().ico(5).ok()?, shift(ball.center))
        }
        Shape::Plane(plane) => {
            let normal = Dir3::new(vec3(plane.normal)).ok()?;
            let turn = Quat::from_rotation_arc(Vec3::Y, *normal);
            let square = Plane3d::new(Vec3::Y, Vec2::splat(PLANE)).mesh().build();
            placed(square, Transform { rotation: turn, ..shift(plane.point) })
        }
        Shape::Box(cuboid) => {
            let [x, y, z] = cuboid.half.map(|half| 2.0 * half as f32);
            placed(Cuboid::new(x, y, z).mesh().build(), shift(cuboid.center))
        }
        Shape::Capsule(bar) => {
            placed(Capsule3d::new(bar.radius as f32, length(bar)).mesh().build(), along(bar))
        }
        Shape::Cylinder(bar) => {
            placed(Cylinder::new(bar.radius as f32, length(bar)).mesh().build(), along(bar))
        }
        Shape::Mesh(mesh) | Shape::Convex(mesh) => surface_mesh(collider, &shapes::surface(mesh).ok()?),
        Shape::Heightfield(field) => surface_mesh(collider, &ground(field).ok()?),
    })
}

fn vec3(v: [f64; 3]) -> Vec3 {
    Vec3::from_array(v.map(|x| x as f32))
}

fn shift(center: [f64; 3]) -> Transform {
    Transform::from_translation(vec3(center))
}

fn length(bar: Bar) -> f32 {
    vec3(bar.a).distance(vec3(bar.b))
}

/// From a bar along y about the origin.
fn along(bar: Bar) -> Transform {
    let axis = (vec3(bar.b) - vec3(bar.a)).try_normalize().unwrap_or(Vec3::Y);
    let turn = Quat::from_rotation_arc(Vec3::Y, axis);
    Transform { rotation: turn, ..Transform::from_translation((vec3(bar.a) + vec3(bar.b)) / 2.0) }
}

/// The collider's place as a transform.
fn transform_of(collider: &Collider, nodes: &[[f64; 3]]) -> Transform {
    let Ok(placed) = Placement::new(&collider.place, nodes) else { return Transform::IDENTITY };
    let rows = placed.rotation.map(vec3);
    let rotation = Quat::from_mat3(&Mat3::from_cols(rows[0], rows[1], rows[2]).transpose());
    Transform { translation: vec3(placed.position), rotation, scale: Vec3::splat(placed.factor as f32) }
}

fn surface_mesh(collider: &Collider, surface: &Surface) -> Mesh {
    let places = surface.nodes.iter().map(|place| place.map(|x| x as f32)).collect::<Vec<_>>();
    let (count, nodes) = (places.len(), (0..places.len() as u32).collect::<Vec<_>>());
    let drawn =
        Drawn { vertices: nodes.clone(), nodes, triangles: surface.triangles.clone(), ..Drawn::default() };
    // By area, for Bevy's other way gives corners of edges shorter than 2 cm no weight.
    mesh_of(&drawn, places, vec![[0.0, 1.0, 0.0]; count], false)
        .with_computed_area_weighted_normals()
        .transformed_by(transform_of(collider, &surface.nodes))
}

/// Brings the meshes of colliders whose shape changes to where these are drawn now.
pub fn show_shapes(
    mut worlds: Query<&mut Running>,
    drawn: Query<(&Mesh3d, &GlobalTransform)>,
    meshes: Option<ResMut<Assets<Mesh>>>,
) {
    let Some(mut meshes) = meshes else { return };
    for mut running in &mut worlds {
        let now = (running.simulation.frame(), running.share);
        let Running { simulation, colliders, .. } = &mut *running;
        for (index, one) in colliders.iter_mut().enumerate().filter(|(_, one)| one.shown != Some(now)) {
            let nodes = simulation.collider_nodes(simulation.colliders()[index].handle, f64::from(now.1));
            let (Ok(Some(nodes)), Ok((mesh, transform))) = (nodes, drawn.get(one.entity)) else {
                continue;
            };
            // Another mesh that is drawn instead is not ours to change.
            if !meshes.get(&mesh.0).is_some_and(|mesh| shows(mesh, nodes.len())) {
                continue;
            }
            let Some(mut mesh) = meshes.get_mut(&mesh.0) else { continue };
            one.shown = Some(now);
            // The engine's nodes are in the world, where the entity was when the simulation was built.
            let (scale, ..) = transform.to_scale_rotation_translation();
            let back = one.track.start.transform(scale).compute_affine().inverse();
            let local = |node: &[f64; 3]| back.transform_point3(vec3(*node)).to_array();
            mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, nodes.iter().map(local).collect::<Vec<_>>());
            mesh.compute_area_weighted_normals();
        }
    }
}

/// Whether it is a surface with this number of vertices that the renderer has not taken away.
fn shows(mesh: &Mesh, vertices: usize) -> bool {
    mesh.primitive_topology() == PrimitiveTopology::TriangleList
        && mesh.try_indices().is_ok()
        && mesh.try_attribute(Mesh::ATTRIBUTE_POSITION).is_ok_and(|places| places.len() == vertices)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::mesh::VertexAttributeValues;
    use taffeta::scene::{Keyframe, Mesh as Shape, Place, Rotation};

    fn farthest(collider: &Collider, distance: impl Fn(Vec3) -> f32) -> f32 {
        let mesh = collider_mesh(collider).unwrap();
        let Some(VertexAttributeValues::Float32x3(places)) = mesh.attribute(Mesh::ATTRIBUTE_POSITION) else {
            panic!("no places");
        };
        places.iter().map(|place| distance(Vec3::from(*place)).abs()).fold(0.0, f32::max)
    }

    #[test]
    fn what_is_drawn_of_a_collider_is_its_surface() {
        let place = Place {
            position: [1.0, 2.0, 3.0],
            rotation: Some(Rotation { axis: [0.0, 0.0, 1.0], degrees: 90.0 }),
            scale: Some(2.0),
            ..Place::default()
        };
        let capsule = Collider::capsule([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], 0.25).placed(place.clone());
        // From (1, 2, 3) two up, 0.5 thick.
        let off_axis = |x: Vec3| {
            let nearest = Vec3::new(1.0, x.y.clamp(2.0, 4.0), 3.0);
            x.distance(nearest) - 0.5
        };
        assert!(farthest(&capsule, off_axis) < 1e-5);
        let ball = Collider::sphere([0.5, 0.0, 0.0], 1.0).placed(place.clone());
        assert!(farthest(&ball, |x| x.distance(Vec3::new(1.0, 3.0, 3.0)) - 2.0) < 1e-5);
        let plane = Collider::plane([0.0, 0.5, 0.0], [1.0, 1.0, 0.0]);
        assert!(farthest(&plane, |x| (x - Vec3::new(0.0, 0.5, 0.0)).dot(Vec3::new(1.0, 1.0, 0.0))) < 1e-5);
        let mesh = Collider::mesh(Shape::grid(3, 3, [1.0, 1.0])).placed(place);
        assert!(farthest(&mesh, |x| x.x - 1.0) < 1e-5);
        assert!(collider_mesh(&Collider::default().keyframe(Keyframe::default())).is_none());
    }

    #[test]
    fn a_collider_of_small_triangles_has_normals() {
        let mesh = collider_mesh(&Collider::mesh(Shape::grid(9, 9, [0.01, 0.01]))).unwrap();
        let normals =
            mesh.attribute(Mesh::ATTRIBUTE_NORMAL).and_then(VertexAttributeValues::as_float3).unwrap();
        assert!(normals.iter().all(|normal| Vec3::from(*normal).abs().abs_diff_eq(Vec3::Y, 1e-5)));
    }
}
