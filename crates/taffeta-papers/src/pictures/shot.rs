//! A scene at one moment, as faces.

use super::Moment;
use crate::draw::shapes::{self, Corner, Face, Material};
use crate::draw::solid;
use crate::draw::vector::{Vector, along, cross, difference, dot, unit};
use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;
use taffeta::scene::{Body, Bounds, Collider, Kind, Mass, Mesh, Scene, Select, Shape};
use taffeta::topology::{Surface, ground};
use taffeta::{BodyInfo, Options, Simulation};

/// Radius of rods and beads, as a share of the scene's size.
const ROD: f64 = 0.009;
/// Radius of a plane's disc, as a multiple of the scene's size.
const DISC: f64 = 2.2;

/// Cosine of the angle between a face and what is around it from which on an edge is sharp.
const SMOOTH: f64 = 0.8;

/// What to draw.
pub struct Shot {
    pub faces: Vec<Face>,
    /// Places that the picture must show.
    pub subject: Vec<Vector>,
    /// The frame it is of.
    pub frame: u32,
    /// What the user should know.
    pub notes: Vec<String>,
}

/// A scene that runs, with a held body for each collider that shows how it has moved.
struct Stage {
    scene: Scene,
    simulation: Simulation,
    /// The scene's own bodies; the others follow.
    bodies: usize,
}

/// Places and normals of all bodies, one after the other.
struct Instant {
    frame: u32,
    places: Vec<Vec<Vector>>,
    normals: Vec<Vec<Vector>>,
}

/// Runs a scene to its moment.
pub fn take(file: &Path, moment: Moment) -> Result<Shot, String> {
    let loaded = taffeta_io::load_scene(file, &[]).map_err(|error| error.to_string())?;
    let mut stage = Stage::new(loaded.scene)?;
    let start = stage.instant();
    let mut held = Vec::new();
    let mut taken = None;
    let mut lowest = f64::INFINITY;
    let frames = stage.scene.time.frames;
    for frame in 1..=frames {
        stage.simulation.step().map_err(|error| error.to_string())?;
        if frame == 1 {
            held = stage.held(&start);
        }
        let wanted = match moment {
            Moment::End => frame == frames,
            Moment::Middle => frame == frames.div_ceil(2),
            Moment::Deepest => stage.lowest() < lowest,
        };
        if wanted {
            lowest = stage.lowest();
            taken = Some(stage.instant());
        }
    }
    Ok(stage.shot(&taken.unwrap_or(start), &held, loaded.notes))
}

impl Stage {
    fn new(scene: Scene) -> Result<Self, String> {
        let mut with_shapes = scene.clone();
        for (index, collider) in scene.colliders.iter().enumerate() {
            if let Some(shape) = collider.shape() {
                with_shapes.bodies.push(shown(index, collider, shape)?);
            }
        }
        let simulation =
            Simulation::new(&with_shapes, &Options::default()).map_err(|error| error.to_string())?;
        let bodies = scene.bodies.len();
        Ok(Self { scene, simulation, bodies })
    }

    fn instant(&self) -> Instant {
        let mut all = Vec::new();
        self.simulation.positions_f64(&mut all);
        let mut rest = all.into_iter();
        let bodies = self.simulation.bodies();
        let places = bodies.iter().map(|body| rest.by_ref().take(body.vertices).collect()).collect();
        let wide = |normals: Vec<[f32; 3]>| normals.into_iter().map(|normal| normal.map(f64::from)).collect();
        let own = |body: &BodyInfo| self.simulation.normals(body.handle).expect("a body of this simulation");
        let normals = bodies.iter().map(|body| wide(own(body))).collect();
        Instant { frame: self.simulation.frame(), places, normals }
    }

    fn lowest(&self) -> f64 {
        let bodies = &self.simulation.bodies()[..self.bodies];
        let own: usize = bodies.iter().map(|body| body.vertices).sum();
        let mut all: Vec<[f64; 3]> = Vec::new();
        self.simulation.positions_f64(&mut all);
        all[..own].iter().map(|place| place[1]).fold(f64::INFINITY, f64::min)
    }

    /// Vertices of each cloth that are held: those that stay at their height while gravity takes all others down.
    fn held(&self, start: &Instant) -> Vec<HashSet<u32>> {
        let now = self.instant();
        let pulled = self.scene.world.gravity[1] != 0.0;
        let held_of = |(index, body): (usize, &Body)| {
            let cloth = body.kind == Kind::Cloth && !body.pins.is_empty() && pulled;
            let pairs = start.places[index].iter().zip(&now.places[index]).enumerate();
            pairs
                .filter(|(_, (before, after))| cloth && before[1] == after[1])
                .map(|(i, _)| i as u32)
                .collect()
        };
        self.scene.bodies.iter().enumerate().map(held_of).collect()
    }

    fn shot(&self, instant: &Instant, held: &[HashSet<u32>], notes: Vec<String>) -> Shot {
        let mut subject: Vec<Vector> = instant.places[..self.bodies].concat();
        let mut planes = Vec::new();
        let mut faces = Vec::new();
        let shapes = self.scene.colliders.iter().filter_map(Collider::shape);
        for (shape, shown) in shapes.zip(&instant.places[self.bodies..]) {
            match shape {
                Shape::Sphere(_) => {
                    let radius = length(difference(shown[1], shown[0]));
                    subject.extend(corners_around(shown[0], radius));
                    faces.extend(shapes::ball(shown[0], radius, 5, Material::Ball));
                }
                Shape::Plane(_) => planes.push([shown[0], unit(difference(shown[1], shown[0]))]),
                _ => subject.extend(shown),
            }
        }
        for index in self.bodies..instant.places.len() {
            self.draw(index, instant, None, 0.0, &mut faces);
        }
        let (middle, size) = bounds(&subject);
        for [point, normal] in planes {
            let above = dot(difference(middle, point), normal);
            faces.extend(shapes::disc(along(middle, -above, normal), normal, DISC * size));
        }
        for index in 0..self.bodies {
            self.draw(index, instant, held.get(index), size * ROD, &mut faces);
        }
        Shot { faces, subject, frame: instant.frame, notes }
    }

    /// A body's polygons, its links as rods, and what is held of it as rods and beads.
    fn draw(
        &self,
        index: usize,
        instant: &Instant,
        held: Option<&HashSet<u32>>,
        rod: f64,
        faces: &mut Vec<Face>,
    ) {
        let (places, normals) = (&instant.places[index], &instant.normals[index]);
        let handle = self.simulation.bodies()[index].handle;
        let surface = self.simulation.surface(handle).expect("a body of this simulation");
        let material = match self.scene.bodies.get(index) {
            None => Material::Ball,
            Some(body) if body.kind == Kind::Soft => Material::Soft,
            Some(_) => Material::Cloth,
        };
        let collider =
            index.checked_sub(self.bodies).and_then(|collider| self.scene.colliders[collider].shape());
        let has_edges = matches!(collider, Some(Shape::Box(_) | Shape::Cylinder(_) | Shape::Heightfield(_)));
        // What shows how a collider has moved is not drawn.
        let links: &[[u32; 2]] = if index < self.bodies { &surface.links } else { &[] };
        let place = |vertex: u32| places[vertex as usize];
        let is_held = |vertex: &u32| held.is_some_and(|held| held.contains(vertex));
        for polygon in surface.polygons.iter() {
            let flat = has_edges.then(|| face_normal([0, 1, 2].map(|i| place(polygon[i]))));
            let corner = |&v: &u32| {
                let smooth = normals[v as usize];
                let sharp = flat.filter(|flat| dot(smooth, *flat) < SMOOTH);
                Corner { place: place(v), normal: sharp.unwrap_or(smooth), chart: [0.0; 2] }
            };
            faces.extend(shapes::polygon(&polygon.iter().map(corner).collect::<Vec<_>>(), material));
            for (i, &a) in polygon.iter().enumerate() {
                let b = polygon[(i + 1) % polygon.len()];
                if is_held(&a) && is_held(&b) {
                    faces.extend(shapes::rod(place(a), place(b), rod, Material::Held));
                }
            }
        }
        for &[a, b] in links {
            faces.extend(shapes::rod(place(a), place(b), rod, material));
            faces.extend(shapes::ball(place(b), rod, 2, material));
        }
        for vertex in (0..places.len() as u32).filter(is_held) {
            faces.extend(shapes::ball(place(vertex), rod, 2, Material::Held));
        }
    }
}

/// What moves with a collider and shows it: its surface, or a held rod from a sphere's centre to its top or from a plane's
/// point along its normal.
fn shown(index: usize, collider: &Collider, shape: Shape<'_>) -> Result<Body, String> {
    let mesh = match shape {
        Shape::Sphere(sphere) => rod(sphere.center, [0.0, sphere.radius, 0.0]),
        Shape::Plane(plane) => rod(plane.point, unit(plane.normal)),
        Shape::Mesh(mesh) | Shape::Convex(mesh) => mesh.clone(),
        Shape::Box(cuboid) => given(solid::cuboid(cuboid)?),
        Shape::Capsule(bar) => given(solid::capsule(bar)?),
        Shape::Cylinder(bar) => given(solid::cylinder(bar)?),
        Shape::Heightfield(field) => given(ground(field)?),
    };
    let everywhere = Select { inside: Some(Bounds { min: [-1e9; 3], max: [1e9; 3] }), ..Select::default() };
    let body = Body::cloth(format!("shape of collider {index}"), mesh).with_mass(Mass::Node(1.0));
    let placed = Body { place: collider.place.clone(), ..body };
    Ok(placed.pin_moving(everywhere, collider.motion.clone()))
}

fn rod(from: Vector, way: Vector) -> Mesh {
    let ends = vec![from, along(from, 1.0, way)];
    given(Surface { vertices: ends.clone(), nodes: ends, links: vec![[0, 1]], ..Surface::default() })
}

fn given(surface: Surface) -> Mesh {
    Mesh::Surface(Arc::new(surface))
}

/// The unit normal of a face with these corners.
fn face_normal([a, b, c]: [Vector; 3]) -> Vector {
    unit(cross(difference(b, a), difference(c, a)))
}

fn length(way: Vector) -> f64 {
    dot(way, way).sqrt()
}

fn corners_around(center: Vector, radius: f64) -> impl Iterator<Item = Vector> {
    (0..3).flat_map(move |axis| {
        [-radius, radius].map(|r| {
            let mut point = center;
            point[axis] += r;
            point
        })
    })
}

/// Middle of the points' box, and the length of half its diagonal.
fn bounds(points: &[Vector]) -> (Vector, f64) {
    let extreme = |pick: fn(f64, f64) -> f64, from: f64| -> Vector {
        std::array::from_fn(|axis| points.iter().map(|p| p[axis]).fold(from, pick))
    };
    let (low, high) = (extreme(f64::min, f64::INFINITY), extreme(f64::max, f64::NEG_INFINITY));
    let half: Vector = std::array::from_fn(|axis| (high[axis] - low[axis]) / 2.0);
    (along(low, 1.0, half), dot(half, half).sqrt())
}
