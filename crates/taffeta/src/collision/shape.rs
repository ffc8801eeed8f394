//! Signed distance and normal of collider shapes.

use super::contact::Touch;
use crate::integrate::keyframes::{Pose, Track};
use crate::real::{Real, add, dot, norm, scale, sub};
use crate::scene::{self, Collider};

/// A collider over time.
#[derive(Clone, Debug)]
pub struct MovingCollider {
    shape: scene::Shape,
    offset: f64,
    friction: f64,
    restitution: f64,
    track: Track,
}

/// A collider at the end of one sub-step, surface offset included.
#[derive(Clone, Copy, Debug)]
pub struct ColliderNow<T> {
    shape: ShapeNow<T>,
    friction: T,
    restitution: T,
    spin: [[T; 3]; 3],
    drift: [T; 3],
}

#[derive(Clone, Copy, Debug)]
enum ShapeNow<T> {
    /// Centre and radius [m].
    Sphere([T; 3], T),
    /// Unit normal and its distance from the origin [m].
    Plane([T; 3], T),
}

impl MovingCollider {
    /// From the scene; `None` if it has not exactly one shape.
    pub fn new(collider: &Collider) -> Option<Self> {
        Some(Self {
            shape: collider.shape()?,
            offset: collider.offset,
            friction: collider.friction,
            restitution: collider.restitution,
            track: Track::new(&collider.motion),
        })
    }

    /// Whether it has keyframes.
    pub fn moves(&self) -> bool {
        !self.track.is_still()
    }

    /// As it is at time `t` + `h` [s], having moved since `t`.
    pub fn at<T: Real>(&self, t: f64, h: f64) -> ColliderNow<T> {
        let (before, after) = (self.track.pose(t), self.track.pose(t + h));
        let (spin, drift) =
            if self.track.is_still() { ([[0.0; 3]; 3], [0.0; 3]) } else { after.velocity_from(&before, h) };
        ColliderNow {
            shape: self.shape_at(&after),
            friction: T::from_f64(self.friction),
            restitution: T::from_f64(self.restitution),
            spin: spin.map(|row| row.map(T::from_f64)),
            drift: drift.map(T::from_f64),
        }
    }

    fn shape_at<T: Real>(&self, pose: &Pose) -> ShapeNow<T> {
        match self.shape {
            scene::Shape::Sphere(sphere) => ShapeNow::Sphere(
                pose.apply(sphere.center).map(T::from_f64),
                T::from_f64(sphere.radius + self.offset),
            ),
            scene::Shape::Plane(plane) => {
                let normal = pose.turn(plane.normal);
                let normal = scale(normal, 1.0 / norm(normal));
                let level = dot(normal, pose.apply(plane.point)) + self.offset;
                ShapeNow::Plane(normal.map(T::from_f64), T::from_f64(level))
            }
        }
    }
}

impl<T: Real> ColliderNow<T> {
    /// How many of the nodes at `x` are inside, as a cheap test over many. A NaN is not.
    #[inline(always)]
    pub fn count_inside(&self, x: [&[T]; 3]) -> u32 {
        let [px, py, pz] = x;
        let n = px.len();
        let (py, pz) = (&py[..n], &pz[..n]);
        let mut inside = 0;
        match self.shape {
            ShapeNow::Sphere(center, radius) => {
                let limit = radius * radius;
                for i in 0..n {
                    let d = sub([px[i], py[i], pz[i]], center);
                    inside += u32::from(dot(d, d) < limit);
                }
            }
            ShapeNow::Plane(normal, level) => {
                for i in 0..n {
                    inside += u32::from(dot(normal, [px[i], py[i], pz[i]]) < level);
                }
            }
        }
        inside
    }

    /// The contact of a node at `x`, if it is inside.
    #[inline]
    pub fn touch(&self, x: [T; 3]) -> Option<Touch<T>> {
        let (depth, normal) = match self.shape {
            ShapeNow::Sphere(center, radius) => {
                let d = sub(x, center);
                let distance = norm(d);
                // At the very centre every way out is as good: up.
                let normal = if distance * distance > T::TINY {
                    scale(d, T::ONE / distance)
                } else {
                    [T::ZERO, T::ONE, T::ZERO]
                };
                (radius - distance, normal)
            }
            ShapeNow::Plane(normal, level) => (level - dot(normal, x), normal),
        };
        (depth > T::ZERO).then(|| Touch {
            depth,
            normal,
            surface_velocity: add(self.spin.map(|row| dot(row, x)), self.drift),
            friction: self.friction,
            restitution: self.restitution,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Keyframe;

    #[test]
    fn depth_and_normal_of_a_sphere_and_a_tilted_plane() {
        let ball = MovingCollider::new(&Collider::sphere([1.0, 0.0, 0.0], 0.5).offset(0.1)).unwrap();
        let touch = ball.at::<f64>(0.0, 0.1).touch([1.0, 0.4, 0.0]).unwrap();
        assert!((touch.depth - 0.2).abs() < 1e-15 && touch.normal == [0.0, 1.0, 0.0]);
        assert!(ball.at::<f64>(0.0, 0.1).touch([1.0, 0.61, 0.0]).is_none());
        let slope = MovingCollider::new(&Collider::plane([0.0, 1.0, 0.0], [0.0, 2.0, 2.0]).offset(0.0)).unwrap();
        let touch = slope.at::<f64>(0.0, 0.1).touch([5.0, 0.0, 0.0]).unwrap();
        assert!((touch.depth - 0.5_f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn a_turning_plane_moves_with_its_surface() {
        let table = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).keyframe(Keyframe::rotate(
            1.0,
            [0.0, 1.0, 0.0],
            1.0,
            [0.0; 3],
        ));
        let now = MovingCollider::new(&table).unwrap().at::<f64>(0.0, 1e-3);
        let v = now.touch([2.0, 0.0, 0.0]).unwrap().surface_velocity;
        let omega = 1.0_f64.to_radians();
        assert!((v[2] + 2.0 * omega).abs() < 1e-6 && v[1] == 0.0);
    }
}
