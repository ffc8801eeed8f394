//! Colliders: what they are, and surfaces to draw them.

use crate::object::{self, Object};
use taffeta::ColliderInfo;
use taffeta::glam::{DMat3, DQuat, DVec3};
use taffeta::scene::{Bar, Collider, Shape};
use taffeta::topology::{Placement, ground, shapes};
use wasm_bindgen::JsValue;
use wasm_bindgen::prelude::wasm_bindgen;

/// Half of the side of the square that is drawn of a plane [m].
const PLANE: f64 = 10.0;
/// Segments of what is round.
const SEGMENTS: u32 = 48;

/// Triangles to draw.
#[wasm_bindgen]
pub struct Surface {
    pub(crate) places: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

#[wasm_bindgen]
impl Surface {
    /// Places of its vertices [m].
    #[wasm_bindgen(getter)]
    pub fn positions(&self) -> Vec<f32> {
        self.places.as_flattened().iter().map(|&x| x as f32).collect()
    }

    /// Vertices of its triangles.
    #[wasm_bindgen(getter)]
    pub fn indices(&self) -> Vec<u32> {
        self.triangles.as_flattened().to_vec()
    }
}

/// The colliders, in the scene's order.
pub fn list(all: &[ColliderInfo]) -> JsValue {
    object::list(all.iter().map(|one| {
        Object::new()
            .with("name", &one.name)
            .with("shape", one.shape)
            .with("keyframes", one.keyframes as u32)
            .with("poses", one.poses as u32)
            .with("repairs", one.repairs.clone())
    }))
}

/// What is drawn of a collider: a square of a plane, the points of a convex hull by the mesh that they are of.
pub fn surface(collider: &Collider) -> Result<Surface, String> {
    let mut surface = match collider.shape().ok_or("a collider without a shape")? {
        Shape::Sphere(ball) => {
            let arc = arc([-1.0, 1.0], ball.radius, 0.0);
            moved(lathe(&arc), DQuat::IDENTITY, ball.center.into())
        }
        Shape::Plane(plane) => {
            let turn = DQuat::from_rotation_arc(DVec3::Y, DVec3::from(plane.normal).normalize_or(DVec3::Y));
            let corners = [[-PLANE, -PLANE], [-PLANE, PLANE], [PLANE, PLANE], [PLANE, -PLANE]];
            let places = corners.map(|[x, z]| [x, 0.0, z]).to_vec();
            moved(Surface { places, triangles: vec![[0, 1, 2], [0, 2, 3]] }, turn, plane.point.into())
        }
        Shape::Box(cuboid) => {
            let corner = |i: u32| {
                std::array::from_fn(
                    |axis| if i >> axis & 1 == 1 { cuboid.half[axis] } else { -cuboid.half[axis] },
                )
            };
            // Each side has corners of its own, so that edges are sharp.
            let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
            let places = sides.as_flattened().iter().map(|&i| corner(i)).collect();
            let triangles =
                (0..6).flat_map(|side| [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|i: u32| 4 * side + i)));
            moved(Surface { places, triangles: triangles.collect() }, DQuat::IDENTITY, cuboid.center.into())
        }
        Shape::Capsule(bar) => {
            let half = 0.5 * length(bar);
            let profile = [arc([-1.0, 0.0], bar.radius, -half), arc([0.0, 1.0], bar.radius, half)].concat();
            along(lathe(&profile), bar)
        }
        Shape::Cylinder(bar) => {
            let (r, half) = (bar.radius, 0.5 * length(bar));
            let profile = [[0.0, -half], [r, -half], [r, -half], [r, half], [r, half], [0.0, half]];
            along(lathe(&profile), bar)
        }
        Shape::Mesh(mesh) | Shape::Convex(mesh) => {
            let surface = shapes::surface(mesh)?;
            Surface { places: surface.nodes, triangles: surface.triangles }
        }
        Shape::Heightfield(field) => {
            let surface = ground(field).map_err(|error| format!("{error:?}"))?;
            Surface { places: surface.nodes, triangles: surface.triangles }
        }
    };
    let place = Placement::new(&collider.place, &surface.places)
        .map_err(|(key, why)| format!("place.{key}: {why}"))?;
    place.apply_all(&mut surface.places);
    Ok(surface)
}

fn length(bar: Bar) -> f64 {
    DVec3::from(bar.a).distance(bar.b.into())
}

/// A bar along y about the origin, brought to where it is.
fn along(surface: Surface, bar: Bar) -> Surface {
    let [a, b] = [bar.a, bar.b].map(DVec3::from);
    moved(surface, DQuat::from_rotation_arc(DVec3::Y, (b - a).normalize_or(DVec3::Y)), 0.5 * (a + b))
}

fn moved(mut surface: Surface, turn: DQuat, shift: DVec3) -> Surface {
    let turn = DMat3::from_quat(turn);
    for place in &mut surface.places {
        *place = (turn * DVec3::from(*place) + shift).to_array();
    }
    surface
}

/// Part of a circle from one height to another, as parts of the radius; the radius there and the height [m].
fn arc([from, to]: [f64; 2], radius: f64, height: f64) -> Vec<[f64; 2]> {
    let [from, to] = [from, to].map(f64::asin);
    let count = SEGMENTS / 4;
    let point = |i: u32| {
        let angle = from + (to - from) * f64::from(i) / f64::from(count);
        [radius * angle.cos(), height + radius * angle.sin()]
    };
    (0..=count).map(point).collect()
}

/// A profile of radius and height [m] turned about the y axis.
fn lathe(profile: &[[f64; 2]]) -> Surface {
    let around = |&[r, y]: &[f64; 2]| {
        (0..SEGMENTS).map(move |i| {
            let angle = std::f64::consts::TAU * f64::from(i) / f64::from(SEGMENTS);
            [r * angle.cos(), y, r * angle.sin()]
        })
    };
    let quad = |row: u32, i: u32| {
        let [a, b] = [i, (i + 1) % SEGMENTS].map(|i| row * SEGMENTS + i);
        [[a, a + SEGMENTS, b], [b, a + SEGMENTS, b + SEGMENTS]]
    };
    let rows = profile.len() as u32 - 1;
    let triangles = (0..rows).flat_map(|row| (0..SEGMENTS).flat_map(move |i| quad(row, i)));
    Surface { places: profile.iter().flat_map(around).collect(), triangles: triangles.collect() }
}
