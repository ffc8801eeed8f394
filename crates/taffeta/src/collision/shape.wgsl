// Signed distance and normal of collider shapes.

/// A collider at the end of one sub-step, surface offset included. The surface moves with spin · x + drift.
struct Collider {
    /// Centre of a ball [m], or unit normal of a half-space.
    place: vec3f,
    /// Radius of a ball, or distance of a half-space's plane from the origin [m].
    size: f32,
    /// Rows of the spin [1/s].
    spin_x: vec3f,
    friction: f32,
    spin_y: vec3f,
    restitution: f32,
    spin_z: vec3f,
    kind: u32,
    /// [m/s]
    drift: vec3f,
}

const SPHERE: u32 = 0u;
const PLANE: u32 = 1u;

/// How far a place is inside [m], negative outside, and the outward unit normal there.
struct Depth {
    normal: vec3f,
    depth: f32,
}

fn sphere_depth(center: vec3f, radius: f32, x: vec3f) -> Depth {
    let d = x - center;
    let squared = dot3(d, d);
    let distance = sqrt(squared);
    // At the very centre every way out is as good: up.
    let far = squared > TINY;
    let inverse = 1.0 / select(1.0, distance, far);
    return Depth(select(vec3f(0.0, 1.0, 0.0), d * inverse, far), radius - distance);
}

fn plane_depth(normal: vec3f, level: f32, x: vec3f) -> Depth {
    return Depth(normal, level - dot3(normal, x));
}

fn depth_and_normal(collider: Collider, x: vec3f) -> Depth {
    if collider.kind == SPHERE {
        return sphere_depth(collider.place, collider.size, x);
    }
    return plane_depth(collider.place, collider.size, x);
}

/// Velocity [m/s] of the collider's surface at `x`.
fn surface_velocity(collider: Collider, x: vec3f) -> vec3f {
    let turning = vec3f(dot3(collider.spin_x, x), dot3(collider.spin_y, x), dot3(collider.spin_z, x));
    return turning + collider.drift;
}
