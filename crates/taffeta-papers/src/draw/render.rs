//! Faces to a picture: nearest face first, lit, 3 × 3 samples a pixel.

use super::camera::Camera;
use super::light::{Light, sky};
use super::raster::{fill, twice_area};
use super::shapes::{Corner, Face, Material};
use super::vector::{Vector, along, cross, difference, dot, mix, unit};

/// Width and height of a picture in pixels.
pub const SIZE: [usize; 2] = [960, 640];
/// Samples of a pixel along each axis.
pub const FINE: usize = 3;
/// Half the width of an edge [samples].
const EDGE: f64 = 1.5;
/// How much an edge darkens, where triangles are not small.
const EDGE_SHADE: f64 = 0.22;
/// Height of a triangle [samples] above which its edges are drawn in full.
const LARGE: f64 = 40.0;

/// Draws the faces in a picture of `size` in pixels; bytes of red, green and blue by rows.
pub fn render(faces: &[Face], camera: &Camera, light: &Light, size: [usize; 2]) -> Vec<u8> {
    let samples = size.map(|pixels| pixels * FINE);
    let background = |index: usize| sky((index / samples[0]) as f64 / samples[1] as f64);
    let mut colors: Vec<Vector> = (0..samples[0] * samples[1]).map(background).collect();
    let mut nearness = vec![0.0_f64; colors.len()];
    for face in faces {
        let Some(seen) = Seen::new(face, camera) else { continue };
        fill(samples, seen.corners, |index, weights| {
            let near = dot(weights, seen.nearness);
            if near > nearness[index] {
                nearness[index] = near;
                colors[index] = seen.color(weights, near, light, background(index));
            }
        });
    }
    pixels(&colors, size)
}

/// A face as the camera sees it.
struct Seen<'a> {
    face: &'a Face,
    corners: [[f64; 2]; 3],
    nearness: Vector,
    /// Whether its front is turned to the camera.
    front: bool,
    /// Distance of each corner from the edge opposite [samples].
    heights: Vector,
}

impl<'a> Seen<'a> {
    /// Nothing where it is behind the camera, or the back of a plane, which would hide what it presses.
    fn new(face: &'a Face, camera: &Camera) -> Option<Self> {
        let front = is_front(face, camera);
        if !front && matches!(face.material, Material::Floor { .. }) {
            return None;
        }
        let [a, b, c] = face.corners.map(|corner| camera.project(corner.place));
        let [(a, near_a), (b, near_b), (c, near_c)] = [a?, b?, c?];
        let area = twice_area(a, b, c).abs();
        let length = |p: [f64; 2], q: [f64; 2]| (p[0] - q[0]).hypot(p[1] - q[1]).max(1e-9);
        let heights = [length(b, c), length(c, a), length(a, b)].map(|side| area / side);
        let nearness = [near_a, near_b, near_c];
        Some(Self { face, corners: [a, b, c], nearness, front, heights })
    }

    fn color(&self, weights: Vector, near: f64, light: &Light, behind: Vector) -> Vector {
        let true_weights: Vector = std::array::from_fn(|i| weights[i] * self.nearness[i] / near);
        let blend = |of: fn(&Corner) -> Vector| {
            let parts = self.face.corners.iter().zip(true_weights);
            parts.fold([0.0; 3], |sum, (corner, weight)| along(sum, weight, of(corner)))
        };
        let place = blend(|corner| corner.place);
        let normal = unit(blend(|corner| corner.normal));
        let normal = if self.front { normal } else { normal.map(|c| -c) };
        let chart = blend(|corner| [corner.chart[0], corner.chart[1], 0.0]);
        let lit = light.at(place, normal);
        let own = albedo(self.face.material, self.front, chart);
        let color: Vector = std::array::from_fn(|i| own[i] * lit[i] * (1.0 - self.edge(weights)));
        match self.face.material {
            Material::Floor { rim } => mix(color, behind, (chart[0].hypot(chart[1]) / rim).powi(2).min(1.0)),
            _ => color,
        }
    }

    /// How much the mesh's edges darken a sample: the faster the smaller the triangles, lest they cover them.
    fn edge(&self, weights: Vector) -> f64 {
        let near = (0..3).any(|i| self.face.edges[i] && weights[i] * self.heights[i] < EDGE);
        let smallest = self.heights.into_iter().fold(f64::INFINITY, f64::min);
        if near { EDGE_SHADE * (smallest / LARGE).min(1.0) } else { 0.0 }
    }
}

/// Whether the camera sees a face from the side that its corners' normals point to. The face itself decides: near
/// an outline a normal may point away from a camera that sees the front.
fn is_front(face: &Face, camera: &Camera) -> bool {
    let [a, b, c] = face.corners.map(|corner| corner.place);
    let across = cross(difference(b, a), difference(c, a));
    let agrees: f64 = face.corners.iter().map(|corner| dot(across, corner.normal)).sum();
    (dot(across, camera.towards(a)) >= 0.0) == (agrees >= 0.0)
}

fn albedo(material: Material, front: bool, chart: Vector) -> Vector {
    match material {
        Material::Cloth if front => [0.58, 0.07, 0.06],
        Material::Cloth => [0.72, 0.42, 0.18],
        Material::Soft => [0.16, 0.42, 0.40],
        Material::Ball => [0.20, 0.28, 0.48],
        Material::Held => [0.10, 0.10, 0.12],
        Material::Floor { .. } => {
            let odd = (chart[0].floor() + chart[1].floor()).rem_euclid(2.0) == 1.0;
            if odd { [0.50, 0.51, 0.53] } else { [0.66, 0.67, 0.69] }
        }
    }
}

/// The mean of each pixel's samples, as sRGB.
fn pixels(colors: &[Vector], [width, height]: [usize; 2]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(3 * width * height);
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let rows = (0..FINE).flat_map(|row| {
            let first = ((y * FINE + row) * width + x) * FINE;
            &colors[first..first + FINE]
        });
        let sum = rows.fold([0.0; 3], |sum, &color| along(sum, 1.0, color));
        bytes.extend(sum.map(|c| srgb(c / (FINE * FINE) as f64)));
    }
    bytes
}

/// A share of light as a byte (IEC 61966-2-1).
fn srgb(light: f64) -> u8 {
    let c = light.clamp(0.0, 1.0);
    let encoded = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0).round() as u8
}
