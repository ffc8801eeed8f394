//! Solid shapes: depth and outward normal of a position. All of them but meshes are convex.

use crate::contact::collider_mesh::surface::MeshNow;
use crate::real::{Real, add, dot, norm, scale, sub};

/// The shapes at the end of a sub-step, surface offset included.
#[derive(Clone, Copy, Debug)]
pub enum ShapeNow<T> {
    /// A ball.
    Sphere(SphereNow<T>),
    /// A half-space.
    Plane(PlaneNow<T>),
    /// A box.
    Box(BoxNow<T>),
    /// A capsule.
    Capsule(CapsuleNow<T>),
    /// A cylinder.
    Cylinder(CylinderNow<T>),
    /// A surface of triangles.
    Mesh(MeshNow<T>),
}

impl<T> ShapeNow<T> {
    /// The mesh, if it is one.
    pub fn mesh(&self) -> Option<&MeshNow<T>> {
        match self {
            Self::Mesh(mesh) => Some(mesh),
            _ => None,
        }
    }
}

/// A convex solid, as a function of position.
pub trait Solid<T: Real>: Copy {
    /// The depth of `x` [m], negative outside, and the outward unit normal there. The depth changes by no more than
    /// the distance between positions, and it is concave along a line.
    fn depth_and_normal(&self, x: [T; 3]) -> (T, [T; 3]);

    /// Depth of its deepest point [m]. A shorter motion does not pass through it.
    fn deepest(&self) -> T;
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

/// A box with round edges.
#[derive(Clone, Copy, Debug)]
pub struct BoxNow<T> {
    /// [m]
    pub center: [T; 3],
    /// Unit vectors along its edges.
    pub axes: [[T; 3]; 3],
    /// Half of its extent along them, without the rounding radius [m].
    pub half: [T; 3],
    /// Rounding radius [m].
    pub offset: T,
}

/// A capsule: all positions within a radius of a segment.
#[derive(Clone, Copy, Debug)]
pub struct CapsuleNow<T> {
    /// One end [m].
    pub a: [T; 3],
    /// The way to the other [m], and 1 through its squared length [1/m²]; 0 for a point.
    pub along: [T; 3],
    pub inverse: T,
    /// [m]
    pub radius: T,
}

/// A cylinder with round edges.
#[derive(Clone, Copy, Debug)]
pub struct CylinderNow<T> {
    /// Middle of its axis [m].
    pub center: [T; 3],
    /// Unit vector along it.
    pub axis: [T; 3],
    /// Half of its length, and its radius, without the rounding radius [m].
    pub half: T,
    pub radius: T,
    /// Rounding radius [m].
    pub offset: T,
}

impl<T: Real> Solid<T> for SphereNow<T> {
    #[inline(always)]
    fn depth_and_normal(&self, x: [T; 3]) -> (T, [T; 3]) {
        let (distance, normal) = length_and_direction(sub(x, self.center), [T::ZERO, T::ONE, T::ZERO]);
        (self.radius - distance, normal)
    }

    fn deepest(&self) -> T {
        self.radius
    }
}

impl<T: Real> Solid<T> for PlaneNow<T> {
    #[inline(always)]
    fn depth_and_normal(&self, x: [T; 3]) -> (T, [T; 3]) {
        (self.level - dot(self.normal, x), self.normal)
    }

    fn deepest(&self) -> T {
        T::FAR
    }
}

impl<T: Real> Solid<T> for BoxNow<T> {
    #[inline(always)]
    fn depth_and_normal(&self, x: [T; 3]) -> (T, [T; 3]) {
        let [u, v, w] = self.axes;
        let from = sub(x, self.center);
        let place = [dot(u, from), dot(v, from), dot(w, from)];
        let [p, q, r] = place;
        let (a, b, c) = (beyond(p, self.half[0]), beyond(q, self.half[1]), beyond(r, self.half[2]));
        let outside = [positive(a.0), positive(b.0), positive(c.0)];
        let (distance, direction) = length_and_direction(outside, [T::ZERO; 3]);
        // Inside, the nearest face is the way out.
        let first = (a.0 >= b.0) & (a.0 >= c.0);
        let second = !first & (b.0 >= c.0);
        let one = |is: bool| if is { T::ONE } else { T::ZERO };
        let face = [one(first), one(second), one(!first & !second)];
        let deepest = if first { a.0 } else { if second { b.0 } else { c.0 } };
        let inside = deepest <= T::ZERO;
        let pick = |i: usize| if inside { face[i] } else { direction[i] };
        let [p, q, r] = [pick(0) * a.1, pick(1) * b.1, pick(2) * c.1];
        let along = |i: usize| u[i] * p + v[i] * q + w[i] * r;
        let normal = [along(0), along(1), along(2)];
        (self.offset - if inside { deepest } else { distance }, normal)
    }

    fn deepest(&self) -> T {
        let [a, b, c] = self.half;
        least(a, least(b, c)) + self.offset
    }
}

impl<T: Real> Solid<T> for CapsuleNow<T> {
    #[inline(always)]
    fn depth_and_normal(&self, x: [T; 3]) -> (T, [T; 3]) {
        let from = sub(x, self.a);
        let fraction = dot(from, self.along) * self.inverse;
        let fraction = if fraction > T::ZERO { fraction } else { T::ZERO };
        let fraction = if fraction < T::ONE { fraction } else { T::ONE };
        let apart = sub(from, scale(self.along, fraction));
        // On the axis, what rounding leaves must not point along it, nor inward at its ends.
        let slant = dot(apart, self.along) * self.inverse;
        let off = ((fraction > T::ZERO) | (slant > T::ZERO)) & ((fraction < T::ONE) | (slant < T::ZERO));
        let slant = if off { slant } else { T::ZERO };
        let apart = sub(apart, scale(self.along, slant));
        let aside = across(scale(self.along, self.inverse.sqrt()));
        let (distance, normal) = length_and_direction(apart, aside);
        (self.radius - distance, normal)
    }

    fn deepest(&self) -> T {
        self.radius
    }
}

impl<T: Real> Solid<T> for CylinderNow<T> {
    #[inline(always)]
    fn depth_and_normal(&self, x: [T; 3]) -> (T, [T; 3]) {
        let from = sub(x, self.center);
        let along = dot(from, self.axis);
        // On the axis, what rounding leaves must not point along it.
        let apart = sub(from, scale(self.axis, along));
        let apart = sub(apart, scale(self.axis, dot(apart, self.axis)));
        let (far, outward) = length_and_direction(apart, across(self.axis));
        let (end, side) = (beyond(along, self.half), far - self.radius);
        let outside = [positive(end.0), positive(side), T::ZERO];
        let (distance, direction) = length_and_direction(outside, [T::ZERO; 3]);
        let by_end = end.0 >= side;
        let deepest = if by_end { end.0 } else { side };
        let inside = deepest <= T::ZERO;
        let flat = if by_end { T::ONE } else { T::ZERO };
        let p = if inside { flat } else { direction[0] } * end.1;
        let q = if inside { T::ONE - flat } else { direction[1] };
        let normal = add(scale(self.axis, p), scale(outward, q));
        (self.offset - if inside { deepest } else { distance }, normal)
    }

    fn deepest(&self) -> T {
        least(self.half, self.radius) + self.offset
    }
}

#[inline(always)]
fn least<T: Real>(a: T, b: T) -> T {
    if a < b { a } else { b }
}

/// How far `x` is beyond ±`half`, and on which side.
#[inline(always)]
fn beyond<T: Real>(x: T, half: T) -> (T, T) {
    let side = if x < T::ZERO { -T::ONE } else { T::ONE };
    (x * side - half, side)
}

#[inline(always)]
pub fn positive<T: Real>(x: T) -> T {
    if x > T::ZERO { x } else { T::ZERO }
}

/// A vector's length, and its direction; `other` where it has none.
#[inline(always)]
fn length_and_direction<T: Real>(d: [T; 3], other: [T; 3]) -> (T, [T; 3]) {
    let squared = dot(d, d);
    let length = squared.sqrt();
    let far = squared > T::TINY;
    let inverse = T::ONE / if far { length } else { T::ONE };
    let along = scale(d, inverse);
    let pick = |i: usize| if far { along[i] } else { other[i] };
    (length, [pick(0), pick(1), pick(2)])
}

/// A unit vector perpendicular to another. Any would do; this one is the same on all machines.
#[inline(always)]
fn across<T: Real>([x, y, z]: [T; 3]) -> [T; 3] {
    let steep = y * y > T::from_f64(0.5);
    // (0, 0, 1) × axis, or axis × (1, 0, 0).
    let d = [if steep { T::ZERO } else { -y }, if steep { z } else { x }, if steep { -y } else { T::ZERO }];
    let flat = dot(d, d) > T::TINY;
    let d = if flat { d } else { [T::ONE, T::ZERO, T::ZERO] };
    scale(d, T::ONE / norm(d))
}

impl<T: Real> ShapeNow<T> {
    /// Applies `job` to a convex shape; `None` for a mesh.
    #[inline(always)]
    pub fn convex<J: OnSolid<T>>(&self, job: J) -> Option<J::Output> {
        Some(match *self {
            Self::Sphere(solid) => job.run(solid),
            Self::Plane(solid) => job.run(solid),
            Self::Box(solid) => job.run(solid),
            Self::Capsule(solid) => job.run(solid),
            Self::Cylinder(solid) => job.run(solid),
            Self::Mesh(_) => return None,
        })
    }
}

/// An operation on any convex solid.
pub trait OnSolid<T> {
    /// Its result.
    type Output;
    /// Applies it.
    fn run<S: Solid<T>>(self, solid: S) -> Self::Output
    where
        T: Real;
}

/// The entry of the swept segment from `start` to `end` into a solid that it passes through, so that the nearest way
/// out of `end`, if any, is on the wrong side. Returns the depth of `end` below the tangent plane there [m], and its
/// normal. Depth along a line is concave, so Newton's method from outside never overshoots.
pub fn entry<T: Real>(solid: impl Solid<T>, start: [T; 3], end: [T; 3]) -> Option<(T, [T; 3])> {
    let way = sub(end, start);
    if dot(solid.depth_and_normal(end).1, way) <= T::ZERO {
        return None;
    }
    let mut fraction = T::ZERO;
    for _ in 0..ENTRIES {
        let place = add(start, scale(way, fraction));
        let (depth, normal) = solid.depth_and_normal(place);
        let approach = -dot(normal, way);
        let comes = approach > T::ZERO;
        if !comes {
            return None;
        }
        let next = fraction - depth / approach;
        // Converged to the precision of the numbers.
        if depth >= T::ZERO || next <= fraction {
            return Some((depth + approach * (T::ONE - fraction), normal));
        }
        if next > T::ONE {
            return None;
        }
        fraction = next;
    }
    let place = add(start, scale(way, fraction));
    let (depth, normal) = solid.depth_and_normal(place);
    Some((depth - dot(normal, way) * (T::ONE - fraction), normal))
}

/// Steps of Newton's method to an entry: faces and edges take one each, round surfaces double their digits.
pub const ENTRIES: usize = 12;
