//! Vertices in the user's hand: taken with the mouse, led in the plane that is parallel to the picture, and let go.

use crate::busy::Busy;
use crate::stage::{StageCamera, StageRoot};
use bevy::camera::visibility::NoFrustumCulling;
use bevy::light::{NotShadowCaster, NotShadowReceiver};
use bevy::mesh::{Indices, VertexAttributeValues};
use bevy::prelude::*;
use bevy::window::PrimaryWindow;
use bevy_taffeta::prelude::*;
use bevy_taffeta::taffeta::BodyHandle;
use bevy_taffeta::{DrawnBody, Running};

/// A vertex counts as under the mouse up to this distance, where no triangle is [pixel].
const NEAR: f32 = 12.0;
/// Edges at a taken vertex are pulled to this share of the length at which it was taken: cloth follows, and is not torn.
const PULL: f32 = 1.5;
/// Radius of the marker, by its distance from the camera.
const MARKER: f32 = 0.008;

/// What is in the user's hand.
#[derive(Resource, Default)]
pub struct Grab {
    held: Option<Held>,
    /// Where the mouse is, as a way into the scene.
    pub ray: Option<Ray3d>,
    /// Why a vertex does not follow.
    pub refused: Option<String>,
    /// Whether it follows only when time goes on.
    pub waits: bool,
}

/// A vertex that is held.
pub struct Held {
    /// The name of its body in the simulation.
    pub name: String,
    /// Its number in the body's mesh.
    pub vertex: usize,
    /// Its number among the vertices of all bodies.
    pub all: usize,
    /// The plane that it stays in: a point [m] and a normal.
    plane: (Vec3, Vec3),
    /// Vertices next to it among those of all bodies, and how far they may be [m].
    neighbours: Vec<(usize, f32)>,
}

impl Grab {
    /// Whether a vertex is held.
    pub fn holds(&self) -> bool {
        self.held.is_some()
    }

    /// The vertex that is held.
    pub fn held(&self) -> Option<&Held> {
        self.held.as_ref()
    }
}

/// Shows which vertex is held.
#[derive(Component)]
struct Marker;

/// Taking vertices with the left button.
pub fn grab(app: &mut App) {
    app.init_resource::<Grab>()
        .add_systems(Startup, make_marker)
        .add_systems(PreUpdate, (aim, take).chain().after(bevy::input::InputSystems))
        .add_systems(
            PostUpdate,
            (
                lead.after(TaffetaSystems::Build).before(TaffetaSystems::Step),
                mark.after(TaffetaSystems::Step),
            ),
        );
}

/// Where the mouse points.
fn aim(
    mut grab: ResMut<Grab>,
    window: Query<&Window, With<PrimaryWindow>>,
    camera: Query<(&Camera, &GlobalTransform), With<StageCamera>>,
) {
    let (Ok(window), Ok((camera, transform))) = (window.single(), camera.single()) else { return };
    grab.ray = window.cursor_position().and_then(|at| camera.viewport_to_world(transform, at).ok());
}

/// Takes the vertex under the mouse, or lets go.
fn take(
    buttons: Res<ButtonInput<MouseButton>>,
    busy: Res<Busy>,
    camera: Query<(&Camera, &GlobalTransform), With<StageCamera>>,
    colliders: Query<(&Mesh3d, &GlobalTransform, &Visibility), With<SoftCollider>>,
    meshes: Res<Assets<Mesh>>,
    mut worlds: Query<&mut Running, With<StageRoot>>,
    mut grab: ResMut<Grab>,
) {
    let Ok(mut running) = worlds.single_mut() else { return };
    if !buttons.pressed(MouseButton::Left)
        && let Some(held) = grab.held.take()
    {
        grab.refused = None;
        // A body that is not there any more holds nothing.
        let simulation = running.simulation_mut();
        let _ = simulation.body(&held.name).and_then(|body| simulation.unpin_vertex(body, held.vertex));
    }
    if buttons.just_pressed(MouseButton::Left)
        && !busy.pointer
        && let (Some(ray), Ok((camera, transform))) = (grab.ray, camera.single())
    {
        let shown = colliders.iter().filter(|(.., visibility)| **visibility != Visibility::Hidden);
        let walls = shown.filter_map(|(mesh, place, _)| wall(meshes.get(&mesh.0)?, place, ray));
        let nearest_wall = walls.fold(f32::INFINITY, f32::min);
        let seen = |point: Vec3| camera.world_to_viewport(transform, point).ok();
        let found = pick(&running, ray, nearest_wall, seen);
        grab.held = found.and_then(|found| Held::new(&running, found, transform.forward().as_vec3()));
    }
}

/// How far a ray goes until it meets a mesh [m].
fn wall(mesh: &Mesh, place: &GlobalTransform, ray: Ray3d) -> Option<f32> {
    let VertexAttributeValues::Float32x3(places) = mesh.attribute(Mesh::ATTRIBUTE_POSITION)? else {
        return None;
    };
    let at = |index: usize| place.transform_point(Vec3::from(places[index]));
    let corners: Vec<usize> = match mesh.indices()? {
        Indices::U16(all) => all.iter().map(|&index| usize::from(index)).collect(),
        Indices::U32(all) => all.iter().map(|&index| index as usize).collect(),
    };
    let hits = corners.as_chunks::<3>().0.iter().filter_map(|triangle| meet(ray, triangle.map(at)));
    hits.min_by(f32::total_cmp)
}

/// Triangles are wider by this share, so that no ray goes through between two of them.
const SEAM: f32 = 1e-5;

/// How far a ray goes until it meets a triangle from either side [m] (Möller and Trumbore, "Fast, minimum storage
/// ray-triangle intersection", 1997).
pub fn meet(ray: Ray3d, [a, b, c]: [Vec3; 3]) -> Option<f32> {
    let (along, across, way) = (b - a, c - a, ray.direction.as_vec3());
    let p = way.cross(across);
    let volume = along.dot(p);
    if volume == 0.0 {
        return None;
    }
    let from = ray.origin - a;
    let u = from.dot(p) / volume;
    let q = from.cross(along);
    let v = way.dot(q) / volume;
    let far = across.dot(q) / volume;
    (u >= -SEAM && v >= -SEAM && u + v <= 1.0 + SEAM && far > 0.0).then_some(far)
}

/// A vertex: its body, its number there and among all, and where it is [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// The body.
    pub body: BodyHandle,
    /// The vertex's number in the body's mesh.
    pub vertex: usize,
    /// Its number among the vertices of all bodies.
    pub all: usize,
    /// [m]
    pub at: Vec3,
}

/// The vertex under a ray: a corner of the first triangle that it meets, before `wall` metres; else the nearest one in the
/// picture. `seen` says where a point is in the picture [pixel].
pub fn pick(running: &Running, ray: Ray3d, wall: f32, seen: impl Fn(Vec3) -> Option<Vec2>) -> Option<Found> {
    let mut places = Vec::new();
    running.places(&mut places);
    let mut hit: Option<(f32, DrawnBody, [u32; 3])> = None;
    for body in running.drawn_bodies() {
        let DrawnBody { mesh: drawn, first_vertex: first, .. } = body;
        let at = |corner: u32| places[first + drawn.vertices[corner as usize] as usize];
        for triangle in &drawn.triangles {
            if let Some(far) = meet(ray, triangle.map(at))
                && far < hit.map_or(wall, |hit| hit.0)
            {
                hit = Some((far, body, triangle.map(|corner| drawn.vertices[corner as usize])));
            }
        }
    }
    let found = |body: DrawnBody, vertex: usize| {
        let all = body.first_vertex + vertex;
        Found { body: body.handle, vertex, all, at: places[all] }
    };
    if let Some((far, body, corners)) = hit {
        let point = ray.get_point(far);
        let corners = corners.map(|vertex| found(body, vertex as usize));
        return corners.into_iter().min_by(|a, b| a.at.distance(point).total_cmp(&b.at.distance(point)));
    }
    let target = seen(ray.get_point(1.0))?;
    let used = running.drawn_bodies().flat_map(|body| {
        let drawn = body.mesh;
        let of_nodes = drawn.vertices.iter().zip(&drawn.nodes).filter(|(_, node)| **node != u32::MAX);
        of_nodes.map(move |(&vertex, _)| (body, vertex as usize))
    });
    let near = used.filter_map(|(body, vertex)| {
        let one = found(body, vertex);
        let off = seen(one.at)?.distance(target);
        (off < NEAR && (one.at - ray.origin).dot(*ray.direction) < wall).then_some((off, one))
    });
    near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, one)| one)
}

impl Held {
    /// Takes a vertex; it stays in the plane through it across `forward`.
    pub fn new(running: &Running, found: Found, forward: Vec3) -> Option<Self> {
        let DrawnBody { mesh: drawn, first_vertex: first, .. } = running.drawn(found.body)?;
        let mut places = Vec::new();
        running.places(&mut places);
        let vertex = |corner: &u32| first + drawn.vertices[*corner as usize] as usize;
        let faces =
            drawn.triangles.iter().map(|face| &face[..]).chain(drawn.links.iter().map(|link| &link[..]));
        let around = faces.filter(|face| face.iter().any(|corner| vertex(corner) == found.all));
        let mut others: Vec<usize> =
            around.flatten().map(vertex).filter(|&other| other != found.all).collect();
        others.sort_unstable();
        others.dedup();
        let reach = |other: usize| (other, PULL * places[other].distance(found.at));
        Some(Self {
            name: running.simulation().bodies()[found.body.index()].name.clone(),
            vertex: found.vertex,
            all: found.all,
            plane: (found.at, forward),
            neighbours: others.into_iter().map(reach).collect(),
        })
    }

    /// Where it is to go: to the ray in its plane, as far as the vertices next to it allow.
    pub fn target(&self, ray: Ray3d, places: &[Vec3]) -> Vec3 {
        let (point, normal) = self.plane;
        let at = places[self.all];
        let wanted = ray
            .intersect_plane(point, InfinitePlane3d { normal: Dir3::new(normal).unwrap_or(Dir3::Z) })
            .map_or(at, |far| ray.get_point(far));
        let way = wanted - at;
        let shares = self.neighbours.iter().map(|&(other, reach)| share(at - places[other], way, reach));
        at + shares.fold(1.0, f32::min) * way
    }
}

/// The share of a way that leads no farther from the origin than `reach`, or than it starts.
fn share(from: Vec3, way: Vec3, reach: f32) -> f32 {
    let (a, b) = (way.length_squared(), from.dot(way));
    let c = from.length_squared() - reach * reach;
    if c >= 0.0 {
        return if b > 0.0 {
            0.0
        } else if a > 0.0 {
            (-2.0 * b / a).min(1.0)
        } else {
            1.0
        };
    }
    if a > 0.0 { (((b * b - a * c).sqrt() - b) / a).min(1.0) } else { 1.0 }
}

/// Leads the vertex that is held through the next frame.
fn lead(mut worlds: Query<(&mut Running, &Playback), With<StageRoot>>, mut grab: ResMut<Grab>) {
    let Ok((mut running, playback)) = worlds.single_mut() else { return };
    grab.waits = grab.holds() && playback.paused && playback.single_frames == 0;
    if grab.waits {
        return;
    }
    let Grab { held: Some(held), ray: Some(ray), refused, .. } = &mut *grab else { return };
    let mut places: Vec<Vec3> = Vec::new();
    running.simulation().positions_f32(&mut places);
    if held.all >= places.len() {
        grab.held = None;
        return;
    }
    let to = held.target(*ray, &places);
    let simulation = running.simulation_mut();
    // The world may have been built again since the vertex was taken.
    let led = simulation.body(&held.name).and_then(|body| simulation.pin_vertex(body, held.vertex, to));
    *refused = led.err().map(|error| error.to_string());
}

fn make_marker(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let material = StandardMaterial { base_color: Color::srgb(1.0, 0.75, 0.0), unlit: true, ..default() };
    commands.spawn((
        Marker,
        Mesh3d(meshes.add(Sphere::new(1.0))),
        MeshMaterial3d(materials.add(material)),
        Visibility::Hidden,
        (NoFrustumCulling, NotShadowCaster, NotShadowReceiver),
    ));
}

/// Puts the marker on the vertex that is held.
fn mark(
    grab: Res<Grab>,
    worlds: Query<&Running, With<StageRoot>>,
    camera: Query<&GlobalTransform, (With<StageCamera>, Without<Marker>)>,
    mut marker: Query<(&mut Transform, &mut GlobalTransform, &mut Visibility), With<Marker>>,
) {
    let Ok((mut transform, mut global, mut visibility)) = marker.single_mut() else { return };
    let (Some(held), Ok(running), Ok(camera)) = (grab.held(), worlds.single(), camera.single()) else {
        visibility.set_if_neq(Visibility::Hidden);
        return;
    };
    let mut places = Vec::new();
    running.places(&mut places);
    let Some(&at) = places.get(held.all) else { return };
    let radius = MARKER * camera.translation().distance(at);
    *transform = Transform { translation: at, scale: Vec3::splat(radius), ..default() };
    *global = (*transform).into();
    visibility.set_if_neq(Visibility::Inherited);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_meets_a_triangle_from_both_sides_and_misses_beside_it() {
        let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let ray = |origin: Vec3, to: Vec3| Ray3d { origin, direction: Dir3::new(to - origin).unwrap() };
        let inside = Vec3::new(0.2, 0.3, 0.0);
        for z in [2.0, -2.0] {
            assert!((meet(ray(inside + z * Vec3::Z, inside), triangle).unwrap() - 2.0).abs() < 1e-6);
            assert!(meet(ray(inside + z * Vec3::Z, Vec3::new(0.6, 0.6, 0.0)), triangle).is_none());
        }
        assert!(meet(ray(inside - Vec3::Z, inside - 2.0 * Vec3::Z), triangle).is_none(), "behind");
    }

    #[test]
    fn a_way_ends_where_it_would_go_beyond_its_reach() {
        let go = |from: Vec3, way: Vec3| from + share(from, way, 1.5) * way;
        assert_eq!(go(Vec3::X, 0.2 * Vec3::X), 1.2 * Vec3::X);
        assert!(go(Vec3::X, 9.0 * Vec3::Y).length() < 1.5001 && go(Vec3::X, 9.0 * Vec3::Y).y > 1.1);
        assert_eq!(go(2.0 * Vec3::X, Vec3::X), 2.0 * Vec3::X, "from beyond, only nearer");
        assert_eq!(go(2.0 * Vec3::X, -Vec3::X), Vec3::X);
    }
}
