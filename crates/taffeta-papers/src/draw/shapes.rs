//! Triangles to draw, and the shapes made of them.

use super::vector::{Vector, across, along, cross, difference, mix, unit};
use std::f64::consts::TAU;

/// Side of a square of a plane's chequers [m].
const CHEQUER: f64 = 0.2;
/// Rings and sectors of a plane's disc: so fine that one which reaches behind the camera is hardly missed.
const DISC: [usize; 2] = [40, 72];
/// Sides of a rod.
const SIDES: usize = 10;

/// What a triangle is made of.
#[derive(Clone, Copy, PartialEq)]
pub enum Material {
    /// Cloth: its two sides differ.
    Cloth,
    /// A soft body or the links of a chain.
    Soft,
    /// A ball that bodies rest on.
    Ball,
    /// What is held.
    Held,
    /// A plane: `chart` counts chequers, and from `rim` of them on it fades into the background.
    Floor {
        /// Where it begins to fade.
        rim: f64,
    },
}

/// A corner of a triangle.
#[derive(Clone, Copy)]
pub struct Corner {
    /// Where it is [m].
    pub place: Vector,
    /// The surface's normal there, of length 1.
    pub normal: Vector,
    /// Place on the pattern of the material.
    pub chart: [f64; 2],
}

/// A triangle.
pub struct Face {
    /// Its corners.
    pub corners: [Corner; 3],
    /// Whether the edge opposite each corner is one of the mesh.
    pub edges: [bool; 3],
    /// What it is made of.
    pub material: Material,
}

/// A mesh's polygon as a fan of triangles; only its own edges are drawn.
pub fn polygon(corners: &[Corner], material: Material) -> impl Iterator<Item = Face> {
    let last = corners.len().saturating_sub(1);
    (1..last).map(move |i| Face {
        corners: [corners[0], corners[i], corners[i + 1]],
        edges: [true, i + 1 == last, i == 1],
        material,
    })
}

fn plain(corners: [Corner; 3], material: Material) -> Face {
    Face { corners, edges: [false; 3], material }
}

/// A ball: an octahedron, each of its triangles split in four `times` times.
pub fn ball(center: Vector, radius: f64, times: u32, material: Material) -> Vec<Face> {
    let mut triangles = Vec::new();
    for [x, y, z] in
        [[1, 1, 1], [1, 1, -1], [1, -1, 1], [1, -1, -1], [-1, 1, 1], [-1, 1, -1], [-1, -1, 1], [-1, -1, -1]]
    {
        triangles.push([[f64::from(x), 0.0, 0.0], [0.0, f64::from(y), 0.0], [0.0, 0.0, f64::from(z)]]);
    }
    for _ in 0..times {
        triangles = triangles.iter().flat_map(split).collect();
    }
    let corner = |normal: Vector| Corner { place: along(center, radius, normal), normal, chart: [0.0; 2] };
    triangles.iter().map(|triangle| plain(triangle.map(corner), material)).collect()
}

fn split(&[a, b, c]: &[Vector; 3]) -> [[Vector; 3]; 4] {
    let middle = |p, q| unit(mix(p, q, 0.5));
    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}

/// A rod from `a` to `b` with open ends.
pub fn rod(a: Vector, b: Vector, radius: f64, material: Material) -> Vec<Face> {
    let [right, up] = across(unit(difference(b, a)));
    let corner = |end, side: usize| {
        let angle = TAU * side as f64 / SIDES as f64;
        let normal = along(right.map(|c| c * angle.cos()), angle.sin(), up);
        Corner { place: along(end, radius, normal), normal, chart: [0.0; 2] }
    };
    let quad = |side| [corner(a, side), corner(b, side), corner(b, side + 1), corner(a, side + 1)];
    let halves = |[p, q, r, s]: [Corner; 4]| [plain([p, q, r], material), plain([p, r, s], material)];
    (0..SIDES).map(quad).flat_map(halves).collect()
}

/// The part of a plane around `center`.
pub fn disc(center: Vector, normal: Vector, radius: f64) -> Vec<Face> {
    let normal = unit(normal);
    let [right, _] = across(normal);
    let front = cross(right, normal);
    let material = Material::Floor { rim: radius / CHEQUER };
    let corner = |ring: usize, sector: usize| {
        let (r, angle) = (radius * ring as f64 / DISC[0] as f64, TAU * sector as f64 / DISC[1] as f64);
        let [x, y] = [r * angle.cos(), r * angle.sin()];
        Corner { place: along(along(center, x, right), y, front), normal, chart: [x / CHEQUER, y / CHEQUER] }
    };
    let mut faces = Vec::new();
    for (ring, sector) in (0..DISC[0]).flat_map(|ring| (0..DISC[1]).map(move |sector| (ring, sector))) {
        let [p, q] = [corner(ring, sector), corner(ring + 1, sector)];
        let [r, s] = [corner(ring + 1, sector + 1), corner(ring, sector + 1)];
        faces.extend([plain([p, q, r], material), plain([p, r, s], material)]);
    }
    faces
}
