//! Colliders.

use crate::contact::colliders::moving::ColliderNow;
use crate::contact::colliders::shape::ShapeNow;
use crate::gpu::layout::Four;
use bytemuck::{Pod, Zeroable};

/// `Collider` of shape.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Collider {
    pub place: [f32; 3],
    pub size: f32,
    pub spin_x: [f32; 3],
    pub friction: f32,
    pub spin_y: [f32; 3],
    pub restitution: f32,
    pub spin_z: [f32; 3],
    pub kind: u32,
    pub drift: [f32; 3],
    pub mesh: u32,
    pub axis_u: [f32; 3],
    pub u: f32,
    pub axis_v: [f32; 3],
    pub v: f32,
    pub axis_w: [f32; 3],
    pub w: f32,
    pub carry_x: Four,
    pub carry_y: Four,
    pub carry_z: Four,
}

/// In [`Collider::kind`].
pub const MESH: u32 = 5;

impl From<&ColliderNow<f32>> for Collider {
    fn from(now: &ColliderNow<f32>) -> Self {
        let surface = &now.surface;
        let [spin_x, spin_y, spin_z] = surface.spin;
        let [carry_x, carry_y, carry_z] = [0, 1, 2].map(|i| {
            let [a, b, c] = surface.carry.rows[i];
            [a, b, c, surface.carry.shift[i]]
        });
        let plain = Self {
            spin_x,
            friction: surface.friction,
            spin_y,
            restitution: surface.restitution,
            spin_z,
            drift: surface.drift,
            carry_x,
            carry_y,
            carry_z,
            ..Self::zeroed()
        };
        plain.shaped(&now.shape)
    }
}

impl Collider {
    /// With a shape; a mesh is still to be told where its triangles are.
    fn shaped(self, shape: &ShapeNow<f32>) -> Self {
        match *shape {
            ShapeNow::Sphere(ball) => Self { kind: 0, place: ball.center, size: ball.radius, ..self },
            ShapeNow::Plane(plane) => Self { kind: 1, place: plane.normal, size: plane.level, ..self },
            ShapeNow::Box(cuboid) => {
                let ([axis_u, axis_v, axis_w], [u, v, w]) = (cuboid.axes, cuboid.half);
                let (place, size) = (cuboid.center, cuboid.offset);
                Self { kind: 2, place, size, axis_u, u, axis_v, v, axis_w, w, ..self }
            }
            ShapeNow::Capsule(bar) => {
                let (axis_u, u) = (bar.along, bar.inverse);
                Self { kind: 3, place: bar.a, size: bar.radius, axis_u, u, ..self }
            }
            ShapeNow::Cylinder(bar) => {
                let (axis_u, u, v) = (bar.axis, bar.half, bar.radius);
                Self { kind: 4, place: bar.center, size: bar.offset, axis_u, u, v, ..self }
            }
            ShapeNow::Mesh(mesh) => {
                let ([axis_u, axis_v, axis_w], [before, v], w) =
                    (mesh.place.rows, mesh.pose_fractions, mesh.rate);
                let u = if mesh.stride > 0.0 { before } else { v };
                let (place, size) = (mesh.place.shift, mesh.offset);
                Self { kind: MESH, place, size, axis_u, u, axis_v, v, axis_w, w, ..self }
            }
        }
    }
}
