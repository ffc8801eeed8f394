//! How large a scene is, and where a camera sees all of it.

use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use bevy_taffeta::collider_mesh;
use bevy_taffeta::taffeta::Simulation;
use bevy_taffeta::taffeta::scene::{Plane, Scene, Shape};

/// Field of view up and down [rad].
pub const FIELD: f32 = 0.6;
/// Share of the picture that the scene fills.
const FILL: f32 = 0.86;
/// Where the camera is seen from the scene, if nobody says so: angle about the vertical from +z, and above the horizon [rad].
const HEADING: f32 = 0.42;
const ELEVATION: f32 = 0.33;
/// How far a held body may swing down, as shares of its diagonal across and of its height.
const SWING: [f32; 2] = [0.7, -0.4];
/// What a body is lowered by towards a floor at most, as a multiple of its diagonal.
const FALL: f32 = 1.0;

/// What the camera is to see: bodies and finite colliders at the start, and where gravity takes bodies.
#[derive(Resource, Clone, Debug)]
pub struct Extent {
    points: Vec<Vec3>,
    /// Middle of their box [m].
    pub middle: Vec3,
    /// Half its diagonal [m].
    pub radius: f32,
}

impl Extent {
    /// Of a scene that starts as this simulation does.
    pub fn of(scene: &Scene, simulation: &Simulation) -> Self {
        let mut places: Vec<[f32; 3]> = Vec::new();
        simulation.positions_f32(&mut places);
        let mut rest = places.into_iter().map(Vec3::from);
        let mut points = Vec::new();
        for (body, counts) in scene.bodies.iter().zip(simulation.bodies()) {
            let own: Vec<Vec3> = rest.by_ref().take(counts.vertices).collect();
            let drop = drop_of(scene, &own, !body.pins.is_empty());
            points.extend(own.iter().map(|point| *point + drop));
            points.extend(own);
        }
        for collider in &scene.colliders {
            if !matches!(collider.shape(), None | Some(Shape::Plane(_)))
                && let Some(VertexAttributeValues::Float32x3(all)) =
                    collider_mesh(collider).as_ref().and_then(|mesh| mesh.attribute(Mesh::ATTRIBUTE_POSITION))
            {
                points.extend(all.iter().map(|point| Vec3::from(*point)));
            }
        }
        Self::around(points)
    }

    fn around(points: Vec<Vec3>) -> Self {
        let (low, high) = bounds(&points);
        let radius = (0.5 * (high - low).length()).max(1e-3);
        Self { points, middle: 0.5 * (low + high), radius }
    }

    /// A camera that sees all, in pictures of this ratio of width to height; at `eye` and towards `at` where they are given.
    pub fn camera(&self, ratio: f32, eye: Option<Vec3>, at: Option<Vec3>) -> Transform {
        let turn = Quat::from_euler(EulerRot::YXZ, HEADING, -ELEVATION, 0.0);
        let fitted = self.fitted(turn, ratio);
        let at = at.unwrap_or(self.middle);
        let eye = eye.unwrap_or_else(|| {
            if at == self.middle { fitted } else { at + turn * Vec3::Z * fitted.distance(self.middle) }
        });
        if eye == fitted {
            // Its axis does not go through the middle, for the picture is filled evenly.
            return Transform { translation: eye, rotation: turn, scale: Vec3::ONE };
        }
        Transform::from_translation(eye).looking_at(at, Vec3::Y)
    }

    /// The nearest place from which all is in the picture. For each axis of the picture the two outermost planes of sight
    /// that touch the points give the place; the wider need of the two sets the distance.
    fn fitted(&self, turn: Quat, ratio: f32) -> Vec3 {
        let back = turn * Vec3::Z;
        let high = FILL * (0.5 * FIELD).tan();
        let mut distance = f32::MIN;
        let mut across = Vec3::ZERO;
        for (axis, slope) in [(turn * Vec3::X, high * ratio), (turn * Vec3::Y, high)] {
            let reach = |sign: f32| {
                let reaches = self.points.iter().map(|point| point.dot(sign * axis + slope * back));
                reaches.fold(f32::MIN, f32::max)
            };
            let (one, other) = (reach(1.0), reach(-1.0));
            distance = distance.max((one + other) / (2.0 * slope));
            across += 0.5 * (one - other) * axis;
        }
        across + distance * back
    }
}

/// Lowest and highest coordinates.
fn bounds(points: &[Vec3]) -> (Vec3, Vec3) {
    if points.is_empty() {
        return (Vec3::NEG_ONE, Vec3::ONE);
    }
    points.iter().fold((Vec3::MAX, Vec3::MIN), |(low, high), point| (low.min(*point), high.max(*point)))
}

/// How far gravity may take a body that starts here: to the floor, or to where a held one hangs.
fn drop_of(scene: &Scene, body: &[Vec3], held: bool) -> Vec3 {
    let gravity = Vec3::from(scene.world.gravity.map(|x| x as f32));
    let (low, high) = bounds(body);
    if gravity.y >= 0.0 || gravity.y.abs() < 0.5 * gravity.length() {
        return Vec3::ZERO;
    }
    let size = high - low;
    if held {
        let swing = SWING[0] * Vec2::new(size.x, size.z).length() + SWING[1] * size.y;
        return Vec3::NEG_Y * swing.max(0.0);
    }
    let floors = scene.colliders.iter().filter_map(|collider| match collider.shape() {
        Some(Shape::Plane(plane)) => Some(height_under(plane, 0.5 * (low + high))),
        _ => None,
    });
    let floor = floors.flatten().filter(|height| *height < high.y).fold(f32::MIN, f32::max);
    Vec3::NEG_Y * (low.y - floor).clamp(0.0, FALL * size.length())
}

/// Height of a plane that looks up, below a point [m].
fn height_under(plane: Plane, point: Vec3) -> Option<f32> {
    let normal = Vec3::from(plane.normal.map(|x| x as f32)).try_normalize()?;
    let through = Vec3::from(plane.point.map(|x| x as f32));
    (normal.y > 0.5).then(|| point.y - normal.dot(point - through) / normal.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::Affine3A;
    use bevy_taffeta::taffeta::Options;
    use bevy_taffeta::taffeta::scene::{Body, Collider, Mass, Mesh as Form, Select};

    /// Where a point is in a picture, from −1 to 1 to the right and up, for a camera at this place.
    fn seen(camera: &Transform, ratio: f32, point: Vec3) -> Vec2 {
        let local = Affine3A::from_rotation_translation(camera.rotation, camera.translation).inverse();
        let local = local.transform_point3(point);
        Vec2::new(local.x / ratio, local.y) / (-local.z * (0.5 * FIELD).tan())
    }

    fn extent(scene: &Scene) -> Extent {
        Extent::of(scene, &Simulation::new(scene, &Options::default()).unwrap())
    }

    fn sheet() -> Body {
        Body::cloth("sheet", Form::grid(3, 3, [2.0, 2.0])).with_mass(Mass::Node(0.1)).structural(1.0, 0.1)
    }

    #[test]
    fn the_camera_sees_all_points_and_comes_as_near_as_it_can() {
        let ball = Collider::sphere([0.3, -1.0, 0.2], 0.7);
        let extent = extent(&Scene::new("").body(sheet()).collider(ball));
        for ratio in [0.5, 1.0, 1.8] {
            let camera = extent.camera(ratio, None, None);
            let all = extent.points.iter().map(|point| seen(&camera, ratio, *point));
            let farthest = all.map(Vec2::abs).fold(Vec2::ZERO, Vec2::max);
            assert!((farthest.max_element() - FILL).abs() < 1e-3, "{ratio}: {farthest}");
        }
    }

    #[test]
    fn a_camera_that_is_told_where_to_be_is_there() {
        let extent = extent(&Scene::new("").body(sheet()));
        let (eye, at) = (Vec3::new(3.0, 1.0, 0.0), Vec3::new(0.5, 0.5, 0.5));
        let camera = extent.camera(1.0, Some(eye), Some(at));
        assert_eq!(camera.translation, eye);
        assert!(seen(&camera, 1.0, at).length() < 1e-6);
    }

    #[test]
    fn what_falls_is_followed_to_the_floor_and_what_hangs_to_where_it_hangs() {
        let floor = Collider::plane([0.0, -0.8, 0.0], [0.0, 1.0, 0.0]);
        let lowest = |scene: &Scene| extent(scene).points.iter().map(|point| point.y).fold(0.0, f32::min);
        let falls = Scene::new("").body(sheet());
        assert!((lowest(&falls.clone().collider(floor)) + 0.8).abs() < 1e-6);
        let hangs = Scene::new("").body(sheet().pin(Select::nodes([0, 2])));
        assert!((lowest(&hangs) + 0.7 * 8.0_f32.sqrt()).abs() < 1e-5);
        let mut weightless = hangs;
        weightless.world.gravity = [0.0; 3];
        assert_eq!(lowest(&weightless), 0.0);
    }
}
