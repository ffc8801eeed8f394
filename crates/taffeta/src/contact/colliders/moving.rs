//! Colliders over time: a shape, where it starts, and how it moves.

use crate::assembly::Assembly;
use crate::contact::collider_mesh::surface::{MeshShape, mesh_shape};
use crate::contact::colliders::met::lists_now;
use crate::contact::colliders::response::ContactPoint;
use crate::contact::colliders::rigid::Rigid;
use crate::contact::colliders::shape::{
    BoxNow, CapsuleNow, CylinderNow, OnSolid, PlaneNow, ShapeNow, Solid, SphereNow,
};
use crate::motion::keyframes::{Pose, Track};
use crate::plan::Substep;
use crate::real::{Real, add, dot, norm, scale, sub};
use crate::scene::{self, Collider, Scene, SceneError, Shape};
use crate::topology::Placement;
use std::sync::Arc;

/// A bar with a shorter axis than this is a ball [m].
const SMALLEST: f64 = 1e-15;

/// A collider over time.
#[derive(Clone, Debug)]
pub struct MovingCollider {
    form: Form,
    offset: f64,
    friction: f64,
    restitution: f64,
    track: Track,
}

/// A shape at the start [m].
#[derive(Clone, Debug)]
enum Form {
    Sphere(scene::Sphere),
    Plane(scene::Plane),
    Box { center: [f64; 3], axes: [[f64; 3]; 3], half: [f64; 3] },
    Capsule(scene::Bar),
    Cylinder(scene::Bar),
    Mesh(Arc<MeshShape>),
}

/// A collider at the end of one sub-step, surface offset included.
#[derive(Clone, Copy, Debug)]
pub struct ColliderNow<T> {
    /// Its shape.
    pub shape: ShapeNow<T>,
    /// Its material and motion.
    pub surface: ContactSurface<T>,
}

/// The material and the motion of a collider's surface.
#[derive(Clone, Copy, Debug)]
pub struct ContactSurface<T> {
    /// Coulomb coefficient.
    pub friction: T,
    /// Fraction of the normal speed that is returned.
    pub restitution: T,
    /// Rows of the matrix S [1/s] in the velocity S x + d of the surface at x.
    pub spin: [[T; 3]; 3],
    /// d [m/s].
    pub drift: [T; 3],
    /// The rigid motion in the sub-step.
    pub carry: Rigid<T>,
}

impl ContactSurface<f64> {
    /// How far the collider's motion brings what passes through a ball in a step of `h` seconds, at most [m].
    pub fn way_through(&self, center: [f64; 3], radius: f64, h: f64) -> f64 {
        let at_center = add(self.spin.map(|row| dot(row, center)), self.drift);
        let turn = h * self.spin.as_flattened().iter().map(|s| s * s).sum::<f64>().sqrt();
        // What starts in the ball ends a way from it, where the motion is that much more. An arc is longer than its chord.
        if turn < 0.5 { 1.5 * (h * norm(at_center) + turn * radius) / (1.0 - turn) } else { f64::INFINITY }
    }
}

impl<T: Real> ContactSurface<T> {
    /// The contact point of a node at `x`.
    #[inline(always)]
    pub fn contact_at(&self, x: [T; 3], (depth, normal): (T, [T; 3])) -> ContactPoint<T> {
        let [a, b, c] = self.spin;
        ContactPoint {
            depth,
            normal,
            surface_velocity: add([dot(a, x), dot(b, x), dot(c, x)], self.drift),
            friction: self.friction,
            restitution: self.restitution,
        }
    }
}

impl Assembly {
    /// Colliders in the scene's order.
    pub fn colliders(&self) -> &[MovingCollider] {
        self.extensions.list()
    }

    /// The same, to move them.
    pub(crate) fn colliders_mut(&mut self) -> &mut [MovingCollider] {
        self.extensions.get_mut::<Vec<MovingCollider>>()
    }

    /// Adds those of a scene.
    pub(crate) fn add_colliders(&mut self, scene: &Scene) -> Result<(), SceneError> {
        let step = scene.time.longest_step();
        let at = |i: usize| move |error: SceneError| error.under(&format!("collider[{i}]"));
        let numbered = scene.colliders.iter().enumerate();
        let all = numbered.map(|(i, one)| MovingCollider::in_steps(one, step).map_err(at(i)));
        let all: Vec<MovingCollider> = all.collect::<Result<_, _>>()?;
        self.extensions.insert(all);
        Ok(())
    }

    /// Whether any collider moves.
    pub fn colliders_move(&self) -> bool {
        self.colliders().iter().any(MovingCollider::moves)
    }
}

/// Where colliders are at the end of a sub-step.
pub fn parameters<T: Real>(assembly: &Assembly, [t, h]: [f64; 2], substep: &mut Substep<T>) {
    let mut meshes = 0;
    let all: Vec<ColliderNow<T>> =
        assembly.colliders().iter().map(|collider| collider.at(t, h, &mut meshes)).collect();
    if let Some(lists) = lists_now(assembly, &all) {
        substep.extensions.insert(lists);
    }
    substep.extensions.insert_list(all);
}

impl<T: Real> Substep<T> {
    /// Colliders at its end.
    pub fn colliders(&self) -> &[ColliderNow<T>] {
        self.extensions.list()
    }
}

impl MovingCollider {
    /// As [`Self::in_steps`], of any length.
    #[cfg(test)]
    pub fn new(collider: &Collider) -> Result<Self, SceneError> {
        Self::in_steps(collider, 0.0)
    }

    /// From the scene, for sub-steps of at most `step` [s]; it must have exactly one shape, and its meshes must be surfaces.
    pub fn in_steps(collider: &Collider, step: f64) -> Result<Self, SceneError> {
        Ok(Self {
            form: Form::new(collider, step)?,
            offset: collider.offset,
            friction: collider.friction,
            restitution: collider.restitution,
            track: Track::new(&collider.motion),
        })
    }

    /// Distance kept between its surface and nodes [m].
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// Coulomb coefficient.
    pub fn friction(&self) -> f64 {
        self.friction
    }

    /// Whether it has keyframes, or poses.
    pub fn moves(&self) -> bool {
        !self.track.is_still() || self.mesh().is_some_and(|mesh| mesh.deforms())
    }

    /// Its triangles, if it is a mesh.
    pub fn mesh(&self) -> Option<&Arc<MeshShape>> {
        match &self.form {
            Form::Mesh(mesh) => Some(mesh),
            _ => None,
        }
    }

    /// Corners of a box at the start [m], towards + along its edges where bits 0, 1, 2 of their number are set.
    pub fn box_corners(&self) -> Option<[[f64; 3]; 8]> {
        let Form::Box { center, axes, half } = &self.form else { return None };
        let to = |corner: usize, axis: usize| if corner >> axis & 1 == 1 { half[axis] } else { -half[axis] };
        let corner = |k: usize| (0..3).fold(*center, |x, axis| add(x, scale(axes[axis], to(k, axis))));
        Some(std::array::from_fn(corner))
    }

    /// Its rigid motion.
    pub fn track(&self) -> &Track {
        &self.track
    }

    /// Its rigid motion, mutable.
    pub fn track_mut(&mut self) -> &mut Track {
        &mut self.track
    }

    /// As it is at time `t` + `h` [s], having moved since `t`. Meshes are counted in `meshes`.
    pub fn at<T: Real>(&self, t: f64, h: f64, meshes: &mut u32) -> ColliderNow<T> {
        let (before, after) = (self.track.pose(t), self.track.pose(t + h));
        let still = self.track.is_still();
        let (spin, drift) = if still { ([[0.0; 3]; 3], [0.0; 3]) } else { after.velocity_from(&before, h) };
        let carry = if still { Pose::REST } else { after.since(&before) };
        ColliderNow {
            shape: self.shape_at(&after, (t, h), meshes),
            surface: ContactSurface {
                friction: T::from_f64(self.friction),
                restitution: T::from_f64(self.restitution),
                spin: spin.map(|row| row.map(T::from_f64)),
                drift: drift.map(T::from_f64),
                carry: Rigid::of(&carry),
            },
        }
    }

    fn shape_at<T: Real>(&self, pose: &Pose, (t, h): (f64, f64), meshes: &mut u32) -> ShapeNow<T> {
        let place = |x: [f64; 3]| pose.apply(x).map(T::from_f64);
        let (number, offset) = (T::from_f64, T::from_f64(self.offset));
        match &self.form {
            Form::Sphere(sphere) => ShapeNow::Sphere(SphereNow {
                center: place(sphere.center),
                radius: number(sphere.radius + self.offset),
            }),
            Form::Plane(plane) => {
                let normal = pose.turn(plane.normal);
                let normal = scale(normal, 1.0 / norm(normal));
                let level = dot(normal, pose.apply(plane.point)) + self.offset;
                ShapeNow::Plane(PlaneNow { normal: normal.map(number), level: number(level) })
            }
            Form::Box { center, axes, half } => ShapeNow::Box(BoxNow {
                center: place(*center),
                axes: axes.map(|axis| pose.turn(axis).map(number)),
                half: half.map(number),
                offset,
            }),
            Form::Capsule(bar) => {
                let (a, b) = (pose.apply(bar.a), pose.apply(bar.b));
                let along = sub(b, a);
                let squared = dot(along, along);
                let inverse = if squared > SMALLEST * SMALLEST { 1.0 / squared } else { 0.0 };
                ShapeNow::Capsule(CapsuleNow {
                    a: a.map(number),
                    along: along.map(number),
                    inverse: number(inverse),
                    radius: number(bar.radius + self.offset),
                })
            }
            Form::Cylinder(bar) => {
                let axis = pose.turn(sub(bar.b, bar.a));
                let length = norm(axis);
                ShapeNow::Cylinder(CylinderNow {
                    center: place(scale(add(bar.a, bar.b), 0.5)),
                    axis: scale(axis, 1.0 / length).map(number),
                    half: number(length / 2.0),
                    radius: number(bar.radius),
                    offset,
                })
            }
            Form::Mesh(mesh) => {
                let index = *meshes;
                *meshes += 1;
                ShapeNow::Mesh(mesh.at(index, Rigid::of(pose), self.offset, (t, h)))
            }
        }
    }
}

impl Form {
    fn new(collider: &Collider, step: f64) -> Result<Self, SceneError> {
        let Some(shape) = collider.shape() else {
            return Err(SceneError::new("", "has not exactly one shape"));
        };
        if let Some(mesh) = mesh_shape(collider, shape, step)? {
            return Ok(Self::Mesh(Arc::new(mesh)));
        }
        let across = if collider.place.scale.is_some() { corners(shape) } else { [[0.0; 3]; 2] };
        let placed = Placement::new(&collider.place, &across)
            .map_err(|(field, message)| SceneError::new(field, message))?;
        let at = |x: [f64; 3]| placed.apply(x);
        let bar =
            |bar: scene::Bar| scene::Bar { a: at(bar.a), b: at(bar.b), radius: bar.radius * placed.factor };
        let turn = |x: [f64; 3]| placed.rotation.map(|row| dot(row, x));
        Ok(match shape {
            Shape::Sphere(ball) => {
                Self::Sphere(scene::Sphere { center: at(ball.center), radius: ball.radius * placed.factor })
            }
            Shape::Plane(plane) => {
                Self::Plane(scene::Plane { point: at(plane.point), normal: turn(plane.normal) })
            }
            Shape::Box(cuboid) => Self::Box {
                center: at(cuboid.center),
                axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(turn),
                half: scale(cuboid.half, placed.factor),
            },
            Shape::Capsule(ends) => Self::Capsule(bar(ends)),
            Shape::Cylinder(ends) => Self::Cylinder(bar(ends)),
            Shape::Mesh(_) | Shape::Convex(_) | Shape::Heightfield(_) => {
                return Err(SceneError::new("", "has a mesh without triangles"));
            }
        })
    }
}

/// Two corners of a box that has a shape's lengths [m].
fn corners(shape: Shape<'_>) -> [[f64; 3]; 2] {
    let ball = |center: [f64; 3], r: f64| [center.map(|x| x - r), center.map(|x| x + r)];
    match shape {
        Shape::Sphere(one) => ball(one.center, one.radius),
        Shape::Box(one) => [sub(one.center, one.half), add(one.center, one.half)],
        Shape::Capsule(bar) | Shape::Cylinder(bar) => {
            let reach = bar.radius + norm(sub(bar.b, bar.a)) / 2.0;
            ball(scale(add(bar.a, bar.b), 0.5), reach)
        }
        _ => [[0.0; 3]; 2],
    }
}

/// Depth and normal at a place.
struct DepthAt<T>([T; 3]);

impl<T: Real> OnSolid<T> for DepthAt<T> {
    type Output = (T, [T; 3]);
    #[inline(always)]
    fn run<S: Solid<T>>(self, solid: S) -> Self::Output {
        solid.depth_and_normal(self.0)
    }
}

impl<T: Real> ColliderNow<T> {
    /// How far `x` is inside a convex shape [m], negative outside, and the outward unit normal there; `None` for a mesh,
    /// which is asked by way of its triangles.
    #[inline(always)]
    pub fn depth_and_normal(&self, x: [T; 3]) -> Option<(T, [T; 3])> {
        self.shape.convex(DepthAt(x))
    }
}
