//! Where the picture is seen from.

use super::vector::{Vector, along, cross, difference, dot, unit};

/// Half the height of the picture at distance 1: a field of view of 34° up and down.
const HALF_HEIGHT: f64 = 0.3057;
/// Share of the picture that the subject fills.
const FILL: f64 = 0.84;
/// Of the distance to the subject: what is nearer than this share is not drawn.
const NEAR: f64 = 0.1;

/// A perspective camera.
pub struct Camera {
    place: Vector,
    right: Vector,
    up: Vector,
    forward: Vector,
    near: f64,
    /// Samples for a slope of 1.
    scale: f64,
    middle: [f64; 2],
}

impl Camera {
    /// A camera that sees all `points`, turned by `heading` about the vertical from looking along −z, and from
    /// `elevation` above the horizon [°]; `size` is the picture's [samples].
    pub fn around(points: &[Vector], heading: f64, elevation: f64, size: [usize; 2]) -> Self {
        let (h, e) = (heading.to_radians(), elevation.to_radians());
        let back = [h.sin() * e.cos(), e.sin(), h.cos() * e.cos()];
        let right = unit(cross([0.0, 1.0, 0.0], back));
        let up = cross(back, right);
        let half = [HALF_HEIGHT * size[0] as f64 / size[1] as f64, HALF_HEIGHT].map(|slope| slope * FILL);
        let place = fitted(points, [right, up, back], half);
        let distance = points.iter().map(|&p| dot(difference(place, p), back)).fold(0.0, f64::max);
        Self {
            place,
            right,
            up,
            forward: back.map(|c| -c),
            near: distance * NEAR,
            scale: size[1] as f64 / (2.0 * HALF_HEIGHT),
            middle: size.map(|samples| samples as f64 / 2.0),
        }
    }

    /// Where a point is in the picture, and one over its depth; `None` where it is too near or behind.
    pub fn project(&self, point: Vector) -> Option<([f64; 2], f64)> {
        let seen = difference(point, self.place);
        let depth = dot(seen, self.forward);
        let [x, y] = [dot(seen, self.right), dot(seen, self.up)].map(|across| across / depth * self.scale);
        (depth > self.near).then_some(([self.middle[0] + x, self.middle[1] - y], 1.0 / depth))
    }

    /// Direction from a point to the camera.
    pub fn towards(&self, point: Vector) -> Vector {
        unit(difference(self.place, point))
    }
}

/// The nearest place from which all points are within the slopes `half`. For each axis of the picture the two
/// outermost planes of sight that touch the points give the place; the wider need of the two sets the distance.
fn fitted(points: &[Vector], [right, up, back]: [Vector; 3], half: [f64; 2]) -> Vector {
    let extent = |direction: Vector, slope: f64, sign: f64| {
        let reach = |&p: &Vector| sign * dot(p, direction) + slope * dot(p, back);
        points.iter().map(reach).fold(f64::NEG_INFINITY, f64::max)
    };
    let axes = [(right, half[0]), (up, half[1])];
    let touched = axes.map(|(axis, slope)| [extent(axis, slope, 1.0), extent(axis, slope, -1.0)]);
    let distance = (0..2).map(|i| (touched[i][0] + touched[i][1]) / (2.0 * half[i])).fold(f64::MIN, f64::max);
    let middle = touched.map(|[high, low]| (high - low) / 2.0);
    along(along(back.map(|c| c * distance), middle[0], right), middle[1], up)
}
