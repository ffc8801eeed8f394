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
    /// Where its surface is.
    pub shape: ShapeNow<T>,
    /// How it touches.
    pub touching: Touching<T>,
}

/// What all points of a collider have in common.
#[derive(Clone, Copy, Debug)]
pub struct Touching<T> {
    /// Coulomb coefficient.
    pub friction: T,
    /// Share of the normal speed given back.
    pub restitution: T,
    /// Rows of the matrix S [1/s] in the velocity S x + d of the surface at x.
    pub spin: [[T; 3]; 3],
    /// d [m/s].
    pub drift: [T; 3],
}

/// The shapes.
#[derive(Clone, Copy, Debug)]
pub enum ShapeNow<T> {
    /// A ball.
    Sphere(SphereNow<T>),
    /// A half-space.
    Plane(PlaneNow<T>),
}

/// A surface, as a function of place.
pub trait Solid<T: Real>: Copy {
    /// How far `x` is inside [m], negative outside, and the outward unit normal there.
    fn depth_and_normal(&self, x: [T; 3]) -> (T, [T; 3]);
}

/// A ball: centre and radius [m].
#[derive(Clone, Copy, Debug)]
pub struct SphereNow<T> {
    /// [m]
    pub center: [T; 3],
    /// [m]
    pub radius: T,
}

/// A half-space: unit normal, and its distance from the origin [m].
#[derive(Clone, Copy, Debug)]
pub struct PlaneNow<T> {
    /// Outward.
    pub normal: [T; 3],
    /// [m]
    pub level: T,
}

impl<T: Real> Solid<T> for SphereNow<T> {
    #[inline(always)]
    fn depth_and_normal(&self, x: [T; 3]) -> (T, [T; 3]) {
        let d = sub(x, self.center);
        let squared = dot(d, d);
        let distance = squared.sqrt();
        // At the very centre every way out is as good: up.
        let far = squared > T::TINY;
        let inverse = T::ONE / if far { distance } else { T::ONE };
        let normal = if far { scale(d, inverse) } else { [T::ZERO, T::ONE, T::ZERO] };
        (self.radius - distance, normal)
    }
}

impl<T: Real> Solid<T> for PlaneNow<T> {
    #[inline(always)]
    fn depth_and_normal(&self, x: [T; 3]) -> (T, [T; 3]) {
        (self.level - dot(self.normal, x), self.normal)
    }
}

impl<T: Real> Touching<T> {
    /// The touch of a node at `x`.
    #[inline(always)]
    pub fn touch(&self, x: [T; 3], (depth, normal): (T, [T; 3])) -> Touch<T> {
        let [a, b, c] = self.spin;
        Touch {
            depth,
            normal,
            surface_velocity: add([dot(a, x), dot(b, x), dot(c, x)], self.drift),
            friction: self.friction,
            restitution: self.restitution,
        }
    }
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
            touching: Touching {
                friction: T::from_f64(self.friction),
                restitution: T::from_f64(self.restitution),
                spin: spin.map(|row| row.map(T::from_f64)),
                drift: drift.map(T::from_f64),
            },
        }
    }

    fn shape_at<T: Real>(&self, pose: &Pose) -> ShapeNow<T> {
        match self.shape {
            scene::Shape::Sphere(sphere) => ShapeNow::Sphere(SphereNow {
                center: pose.apply(sphere.center).map(T::from_f64),
                radius: T::from_f64(sphere.radius + self.offset),
            }),
            scene::Shape::Plane(plane) => {
                let normal = pose.turn(plane.normal);
                let normal = scale(normal, 1.0 / norm(normal));
                let level = dot(normal, pose.apply(plane.point)) + self.offset;
                ShapeNow::Plane(PlaneNow { normal: normal.map(T::from_f64), level: T::from_f64(level) })
            }
        }
    }
}

impl<T: Real> ColliderNow<T> {
    /// How far `x` is inside [m], negative outside, and the outward unit normal there.
    pub fn depth_and_normal(&self, x: [T; 3]) -> (T, [T; 3]) {
        match self.shape {
            ShapeNow::Sphere(sphere) => sphere.depth_and_normal(x),
            ShapeNow::Plane(plane) => plane.depth_and_normal(x),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Keyframe;

    #[test]
    fn depth_and_normal_of_a_sphere_and_a_tilted_plane() {
        let ball = MovingCollider::new(&Collider::sphere([1.0, 0.0, 0.0], 0.5).offset(0.1)).unwrap();
        let (depth, normal) = ball.at::<f64>(0.0, 0.1).depth_and_normal([1.0, 0.4, 0.0]);
        assert!((depth - 0.2).abs() < 1e-15 && normal == [0.0, 1.0, 0.0]);
        assert!(ball.at::<f64>(0.0, 0.1).depth_and_normal([1.0, 0.61, 0.0]).0 < 0.0);
        assert_eq!(ball.at::<f64>(0.0, 0.1).depth_and_normal([1.0, 0.0, 0.0]), (0.6, [0.0, 1.0, 0.0]));
        let slope =
            MovingCollider::new(&Collider::plane([0.0, 1.0, 0.0], [0.0, 2.0, 2.0]).offset(0.0)).unwrap();
        let (depth, _) = slope.at::<f64>(0.0, 0.1).depth_and_normal([5.0, 0.0, 0.0]);
        assert!((depth - 0.5_f64.sqrt()).abs() < 1e-15);
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
        let x = [2.0, 0.0, 0.0];
        let v = now.touching.touch(x, now.depth_and_normal(x)).surface_velocity;
        let omega = 1.0_f64.to_radians();
        assert!((v[2] + 2.0 * omega).abs() < 1e-6 && v[1] == 0.0);
    }
}
