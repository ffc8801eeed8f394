//! Distances from surfaces by formulas of their own: all triangles, and the winding number for the side.

use crate::common::{V, add, cross, dot, norm, scale, sub};
use std::f64::consts::PI;
use taffeta::scene::{Collider, Mesh};
use taffeta::topology::shapes::surface;

/// A shape in its own frame [m].
#[derive(Clone)]
pub enum Form {
    Sphere(V, f64),
    Plane(V, V),
    Box(V, V),
    Capsule(V, V, f64),
    Cylinder(V, V, f64),
    Solid(Faces),
    Sheet(Faces),
    /// Places whose hull it is.
    Hull(Faces),
}

#[derive(Clone)]
pub struct Faces {
    pub nodes: Vec<V>,
    pub triangles: Vec<[u32; 3]>,
}

impl Faces {
    pub fn of(mesh: &Mesh) -> Self {
        let surface = surface(mesh).unwrap();
        Self { nodes: surface.nodes, triangles: surface.triangles }
    }

    pub fn corners(&self) -> impl Iterator<Item = [V; 3]> + '_ {
        self.triangles.iter().map(|t| t.map(|i| self.nodes[i as usize]))
    }

    fn distance(&self, x: V) -> f64 {
        self.corners().map(|corners| from_triangle(x, corners)).fold(f64::INFINITY, f64::min)
    }

    /// How often the surface goes around a place (van Oosterom and Strackee, 1983).
    fn winding(&self, x: V) -> f64 {
        let angle = |corners: [V; 3]| {
            let [a, b, c] = corners.map(|corner| sub(corner, x));
            let [p, q, r] = [norm(a), norm(b), norm(c)];
            let below = p * q * r + dot(a, b) * r + dot(b, c) * p + dot(c, a) * q;
            2.0 * dot(a, cross(b, c)).atan2(below)
        };
        self.corners().map(angle).sum::<f64>() / (4.0 * PI)
    }

    /// Distance from a closed surface [m], below 0 inside.
    fn signed(&self, x: V) -> f64 {
        let distance = self.distance(x);
        if self.winding(x).abs() > 0.5 { -distance } else { distance }
    }

    /// The hull's faces: every plane through three places that has all others on one side.
    pub fn hull(places: &[V]) -> Self {
        let n = places.len() as u32;
        let mut triangles = Vec::new();
        for (a, b, c) in (0..n).flat_map(|a| (0..a).flat_map(move |b| (0..b).map(move |c| (a, b, c)))) {
            let [p, q, r] = [a, b, c].map(|i| places[i as usize]);
            let normal = cross(sub(q, p), sub(r, p));
            let most = 1e-9 * norm(normal);
            let sides: Vec<f64> = places.iter().map(|x| dot(sub(*x, p), normal)).collect();
            if sides.iter().all(|side| *side <= most) {
                triangles.push([a, b, c]);
            } else if sides.iter().all(|side| *side >= -most) {
                triangles.push([a, c, b]);
            }
        }
        Self { nodes: places.to_vec(), triangles }
    }

    /// Distance from a convex surface whose triangles may overlap.
    fn signed_convex(&self, x: V) -> f64 {
        let beyond = |[a, b, c]: [V; 3]| {
            let normal = cross(sub(b, a), sub(c, a));
            dot(sub(x, a), normal) / norm(normal)
        };
        let inside = self.corners().map(beyond).fold(f64::NEG_INFINITY, f64::max);
        if inside <= 0.0 { inside } else { self.distance(x) }
    }
}

fn from_segment(x: V, a: V, b: V) -> f64 {
    let (along, from) = (sub(b, a), sub(x, a));
    let squared = dot(along, along);
    let share = if squared > 0.0 { (dot(from, along) / squared).clamp(0.0, 1.0) } else { 0.0 };
    norm(sub(from, scale(along, share)))
}

fn from_triangle(x: V, [a, b, c]: [V; 3]) -> f64 {
    let normal = cross(sub(b, a), sub(c, a));
    let area = norm(normal);
    let edges = [(a, b), (b, c), (c, a)];
    let within = |(p, q): &(V, V)| dot(cross(sub(*q, *p), sub(x, *p)), normal) >= 0.0;
    if area > 0.0 && edges.iter().all(within) {
        return dot(sub(x, a), normal).abs() / area;
    }
    edges.into_iter().map(|(p, q)| from_segment(x, p, q)).fold(f64::INFINITY, f64::min)
}

/// Distance from a product of two sets, by the distance from each, below 0 inside.
fn product(a: f64, b: f64) -> f64 {
    if a.max(b) <= 0.0 { a.max(b) } else { a.max(0.0).hypot(b.max(0.0)) }
}

impl Form {
    /// What a collider has in its own frame, before its place.
    pub fn of(collider: &Collider) -> Self {
        use taffeta::scene::Shape;
        match collider.shape().unwrap() {
            Shape::Sphere(ball) => Self::Sphere(ball.center, ball.radius),
            Shape::Plane(plane) => Self::Plane(plane.point, plane.normal),
            Shape::Box(cuboid) => Self::Box(cuboid.center, cuboid.half),
            Shape::Capsule(bar) => Self::Capsule(bar.a, bar.b, bar.radius),
            Shape::Cylinder(bar) => Self::Cylinder(bar.a, bar.b, bar.radius),
            Shape::Convex(mesh) => Self::Hull(Faces::hull(&Faces::of(mesh).nodes)),
            Shape::Mesh(mesh) => {
                let faces = Faces::of(mesh);
                if is_closed(&faces.triangles) { Self::Solid(faces) } else { Self::Sheet(faces) }
            }
            Shape::Heightfield(field) => Self::Solid(block(field.size, &field.heights, field.depth)),
        }
    }

    /// Distance of a place from the surface [m], below 0 inside.
    pub fn distance(&self, x: V) -> f64 {
        match self {
            Self::Sphere(center, radius) => norm(sub(x, *center)) - radius,
            Self::Plane(point, normal) => dot(sub(x, *point), *normal) / norm(*normal),
            Self::Box(center, half) => {
                let beyond: [f64; 3] = std::array::from_fn(|i| (x[i] - center[i]).abs() - half[i]);
                product(product(beyond[0], beyond[1]), beyond[2])
            }
            Self::Capsule(a, b, radius) => from_segment(x, *a, *b) - radius,
            Self::Cylinder(a, b, radius) => {
                let axis = scale(sub(*b, *a), 1.0 / norm(sub(*b, *a)));
                let along = dot(sub(x, *a), axis);
                let apart = norm(cross(axis, sub(x, *a))) - radius;
                product(apart, (-along).max(along - norm(sub(*b, *a))))
            }
            Self::Solid(faces) => faces.signed(x),
            Self::Sheet(faces) => faces.distance(x),
            Self::Hull(faces) => faces.signed_convex(x),
        }
    }

    /// Whether it has no grooves, so that one push leads out of it.
    pub fn is_convex(&self) -> bool {
        match self {
            Self::Solid(_) => false,
            Self::Sheet(faces) => faces.nodes.iter().all(|x| x[1] == 0.0),
            _ => true,
        }
    }

    /// Places where formulas change: corners, edges, faces, centres, axes.
    pub fn corners(&self) -> Vec<V> {
        let mid = |a: V, b: V| scale(add(a, b), 0.5);
        match self {
            Self::Sphere(center, radius) => vec![*center, add(*center, [0.0, *radius, 0.0])],
            Self::Plane(point, _) => vec![*point],
            Self::Box(center, half) => (0..27)
                .map(|i| {
                    let step: V = std::array::from_fn(|k| f64::from(i / 3_i32.pow(k as u32) % 3 - 1));
                    add(*center, std::array::from_fn(|k| half[k] * step[k]))
                })
                .collect(),
            Self::Capsule(a, b, radius) | Self::Cylinder(a, b, radius) => {
                let axis = sub(*b, *a);
                let side = cross(axis, [0.3, 0.5, 0.8]);
                let rim = scale(side, radius / norm(side).max(1e-9));
                let on_axis = [*a, *b, mid(*a, *b), add(*a, scale(axis, 0.2))];
                on_axis.into_iter().flat_map(|x| [x, add(x, rim), add(x, scale(rim, 0.3))]).collect()
            }
            Self::Solid(faces) | Self::Sheet(faces) | Self::Hull(faces) => faces
                .corners()
                .flat_map(|[a, b, c]| [a, mid(a, b), mid(c, a), scale(add(add(a, b), c), 1.0 / 3.0)])
                .collect(),
        }
    }
}

/// Whether each edge has two triangles.
fn is_closed(triangles: &[[u32; 3]]) -> bool {
    let mut edges: Vec<[u32; 2]> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges.chunk_by(|a, b| a == b).all(|run| run.len() == 2)
}

/// A block below heights, each cell cut along its second diagonal.
fn block(size: [f64; 2], heights: &[Vec<f64>], depth: f64) -> Faces {
    let (rows, cols) = (heights.len(), heights[0].len());
    let low = heights.iter().flatten().copied().fold(f64::INFINITY, f64::min) - depth;
    let at = |row: usize, col: usize, top: bool| {
        let x = (col as f64 / (cols - 1) as f64 - 0.5) * size[0];
        let z = (row as f64 / (rows - 1) as f64 - 0.5) * size[1];
        [x, if top { heights[row][col] } else { low }, z]
    };
    let mut faces = Faces { nodes: Vec::new(), triangles: Vec::new() };
    let mut add = |corners: [V; 3]| {
        let first = faces.nodes.len() as u32;
        faces.nodes.extend(corners);
        faces.triangles.push([first, first + 1, first + 2]);
    };
    for (row, col) in (0..rows - 1).flat_map(|row| (0..cols - 1).map(move |col| (row, col))) {
        for top in [true, false] {
            let [a, b] = [at(row, col, top), at(row, col + 1, top)];
            let [c, d] = [at(row + 1, col, top), at(row + 1, col + 1, top)];
            for [p, q, r] in [[a, c, b], [b, c, d]] {
                add(if top { [p, q, r] } else { [p, r, q] });
            }
        }
    }
    let mut wall = |(r, c): (usize, usize), (s, d): (usize, usize)| {
        let [a, b] = [at(r, c, true), at(s, d, true)];
        let [p, q] = [at(r, c, false), at(s, d, false)];
        add([a, p, b]);
        add([b, p, q]);
    };
    (0..rows - 1).for_each(|row| {
        wall((row, 0), (row + 1, 0));
        wall((row + 1, cols - 1), (row, cols - 1));
    });
    (0..cols - 1).for_each(|col| {
        wall((rows - 1, col), (rows - 1, col + 1));
        wall((0, col + 1), (0, col));
    });
    faces
}

/// A turn about an axis by an angle [°] (Rodrigues).
pub fn turn(axis: V, degrees: f64, x: V) -> V {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let n = scale(axis, 1.0 / norm(axis));
    add(add(scale(x, cos), scale(cross(n, x), sin)), scale(n, dot(n, x) * (1.0 - cos)))
}
