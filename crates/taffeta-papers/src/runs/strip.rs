//! The cloth at some moments side by side, all seen from the same place.

use crate::draw::camera::Camera;
use crate::draw::light::Light;
use crate::draw::shapes::{self, Corner, Face, Material};
use crate::draw::vector::{Vector, along, difference, dot, unit};
use crate::draw::{self, render};
use taffeta::Simulation;
use taffeta::scene::{Collider, Plane, Scene, Shape};
use taffeta::topology::Surface;

/// Width and height of one moment [pixels].
const SIZE: [usize; 2] = [320, 208];
/// Heading and elevation of the camera [°].
const VIEW: [f64; 2] = [25.0, 14.0];
/// Radius of a plane's disc, by the size of what is seen.
const DISC: f64 = 2.2;
/// How far a plane is drawn below its place, by the same: so cloth that lies on it is on top.
const BELOW: f64 = 0.004;

/// One cloth and what it falls on, which does not move.
pub struct Strip {
    colliders: Vec<Collider>,
    surface: Surface,
    /// Places that every moment shows, whatever becomes of the cloth.
    subject: Vec<Vector>,
    moments: Vec<Moment>,
}

/// Places and normals of the cloth at one time.
pub struct Moment {
    places: Vec<Vector>,
    normals: Vec<Vector>,
}

impl Moment {
    /// As it is now.
    pub fn now(simulation: &Simulation) -> Self {
        let mut places = Vec::new();
        simulation.positions_f64(&mut places);
        let cloth = simulation.bodies()[0].handle;
        let normals = simulation
            .normals::<[f32; 3]>(cloth)
            .expect("a body of this simulation")
            .into_iter()
            .map(|normal| normal.map(f64::from));
        Self { places, normals: normals.collect() }
    }
}

impl Strip {
    /// Of a simulation at its start, without moments yet.
    pub fn new(simulation: &Simulation, scene: &Scene) -> Self {
        let colliders = &scene.colliders;
        let mut subject = Moment::now(simulation).places;
        let (middle, _) = extent(&subject);
        let planes = colliders.iter().filter_map(|collider| match collider.shape()? {
            Shape::Plane(plane) => Some(plane),
            _ => None,
        });
        subject.extend(planes.map(|plane| dropped(middle, &plane)));
        Self {
            colliders: scene.colliders.clone(),
            surface: simulation.surface(simulation.bodies()[0].handle).expect("a body of this simulation"),
            subject,
            moments: Vec::new(),
        }
    }

    /// Adds a moment.
    pub fn push(&mut self, moment: Moment) {
        self.moments.push(moment);
    }

    /// The moments from left to right, as a PNG.
    ///
    /// # Errors
    /// Where there is none.
    pub fn png(&self) -> Result<Vec<u8>, String> {
        let samples = SIZE.map(|pixels| pixels * render::FINE);
        let camera = Camera::around(&self.subject, VIEW[0], VIEW[1], samples);
        let panels: Vec<Vec<u8>> = self.moments.iter().map(|moment| self.panel(moment, &camera)).collect();
        let width = SIZE[0] * panels.len();
        draw::png(&draw::beside(&panels, SIZE), [width, SIZE[1]]).map_err(|error| error.to_string())
    }

    fn panel(&self, moment: &Moment, camera: &Camera) -> Vec<u8> {
        let mut faces = self.cloth(moment);
        let (middle, size) = extent(&self.subject);
        for shape in self.colliders.iter().filter_map(Collider::shape) {
            match shape {
                Shape::Sphere(ball) => {
                    faces.extend(shapes::ball(ball.center, ball.radius, 5, Material::Ball));
                }
                Shape::Plane(plane) => {
                    let below = along(dropped(middle, &plane), -BELOW * size, unit(plane.normal));
                    faces.extend(shapes::disc(below, plane.normal, DISC * size));
                }
                _ => {}
            }
        }
        render::render(&faces, camera, &Light::on(&faces, VIEW[0]), SIZE)
    }

    /// Its polygons, but those that are nowhere.
    fn cloth(&self, moment: &Moment) -> Vec<Face> {
        let corner = |&vertex: &u32| {
            let (place, normal) = (moment.places[vertex as usize], moment.normals[vertex as usize]);
            Corner { place, normal, chart: [0.0; 2] }
        };
        let finite = |corner: &Corner| corner.place.iter().chain(&corner.normal).all(|c| c.is_finite());
        let mut faces = Vec::new();
        for polygon in self.surface.polygons.iter() {
            let corners: Vec<Corner> = polygon.iter().map(corner).collect();
            if corners.iter().all(finite) {
                faces.extend(shapes::polygon(&corners, Material::Cloth));
            }
        }
        faces
    }
}

/// The nearest place on a plane.
fn dropped(place: Vector, plane: &Plane) -> Vector {
    let normal = unit(plane.normal);
    along(place, -dot(difference(place, plane.point), normal), normal)
}

/// Middle of the places' box, and the length of half its diagonal.
fn extent(places: &[Vector]) -> (Vector, f64) {
    let extreme = |pick: fn(f64, f64) -> f64, from: f64| -> Vector {
        std::array::from_fn(|axis| places.iter().map(|place| place[axis]).fold(from, pick))
    };
    let (low, high) = (extreme(f64::min, f64::INFINITY), extreme(f64::max, f64::NEG_INFINITY));
    let half = difference(high, low).map(|c| c / 2.0);
    (along(low, 1.0, half), dot(half, half).sqrt())
}
