// Signed distance and normal of collider shapes, and where a way enters them. Source and proofs: shape.rs.

#import gpu/wgsl/vector.wgsl

/// A collider at the end of one sub-step, surface offset included. The surface moves with spin · x + drift.
struct Collider {
    /// Centre of a ball, a box or a cylinder, one end of a capsule, the shift of a mesh [m]; the unit normal of a half-space.
    place: vec3f,
    /// Radius of a ball or a capsule, distance of a half-space's plane from the origin, what rounds the others [m].
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
    /// Where a mesh says what it has.
    mesh: u32,
    /// Axes of a box, with half of its extent along them [m]; the axis of a cylinder, with half of its length, and its radius
    /// behind the next; the way to the other end of a capsule [m], with 1 through its squared length [1/m²]; rows of a mesh,
    /// with the shares of its way to the next pose at both ends of the sub-step, and their rate [1/s].
    axis_u: vec3f,
    u: f32,
    axis_v: vec3f,
    v: f32,
    axis_w: vec3f,
    w: f32,
    /// Rows and shift [m] of the motion in the sub-step.
    carry_x: vec4f,
    carry_y: vec4f,
    carry_z: vec4f,
}

/// Colliders of all sub-steps of a frame.
@group(0) @binding(1) var<storage, read> colliders: array<Collider>;

const SPHERE: u32 = 0u;
const PLANE: u32 = 1u;
const BOX: u32 = 2u;
const CAPSULE: u32 = 3u;
const CYLINDER: u32 = 4u;
const MESH: u32 = 5u;

/// Steps of Newton's method on the way into a solid: faces and edges take one each, round ones double their digits.
const ENTRIES: u32 = 12u;

/// How far a place is inside [m], negative outside, and the outward unit normal there.
struct Depth {
    normal: vec3f,
    depth: f32,
}

/// A vector's direction and its length; `other` where it has none.
fn direction_and_length(d: vec3f, other: vec3f) -> vec4f {
    let squared = dot3(d, d);
    let distance = sqrt(squared);
    let far = squared > TINY;
    let inverse = 1.0 / select(1.0, distance, far);
    return vec4f(select(other, d * inverse, far), distance);
}

fn sphere_depth(center: vec3f, radius: f32, x: vec3f) -> Depth {
    // At the very centre every way out is as good: up.
    let found = direction_and_length(x - center, vec3f(0.0, 1.0, 0.0));
    return Depth(found.xyz, radius - found.w);
}

fn plane_depth(normal: vec3f, level: f32, x: vec3f) -> Depth {
    return Depth(normal, level - dot3(normal, x));
}

/// On which side of 0 numbers are.
fn sides_of(x: vec3f) -> vec3f {
    return select(vec3f(1.0), vec3f(-1.0), x < vec3f(0.0));
}

fn positive(x: vec3f) -> vec3f {
    return select(vec3f(0.0), x, x > vec3f(0.0));
}

fn box_depth(solid: Collider, x: vec3f) -> Depth {
    let away = x - solid.place;
    let place = vec3f(dot3(solid.axis_u, away), dot3(solid.axis_v, away), dot3(solid.axis_w, away));
    let sides = sides_of(place);
    let beyond = place * sides - vec3f(solid.u, solid.v, solid.w);
    let outside = direction_and_length(positive(beyond), vec3f(0.0));
    // Inside, the nearest face is the way out.
    let first = beyond.x >= beyond.y && beyond.x >= beyond.z;
    let second = !first && beyond.y >= beyond.z;
    let face = select(vec3f(0.0), vec3f(1.0), vec3<bool>(first, second, !first && !second));
    let deepest = select(select(beyond.z, beyond.y, second), beyond.x, first);
    let inside = deepest <= 0.0;
    let way = select(outside.xyz, face, inside) * sides;
    let normal = solid.axis_u * way.x + solid.axis_v * way.y + solid.axis_w * way.z;
    return Depth(normal, solid.size - select(outside.w, deepest, inside));
}

fn capsule_depth(solid: Collider, x: vec3f) -> Depth {
    let away = x - solid.place;
    let fraction = dot3(away, solid.axis_u) * solid.u;
    let some = select(0.0, fraction, fraction > 0.0);
    let kept = select(1.0, some, some < 1.0);
    let apart = away - solid.axis_u * kept;
    // On the axis, what rounding leaves must not point along it, nor inward at its ends.
    let slant = dot3(apart, solid.axis_u) * solid.u;
    let off = (kept > 0.0 || slant > 0.0) && (kept < 1.0 || slant < 0.0);
    let square = apart - solid.axis_u * select(0.0, slant, off);
    let found = direction_and_length(square, across(solid.axis_u * sqrt(solid.u)));
    return Depth(found.xyz, solid.size - found.w);
}

/// A unit vector across another: any would do, this one is the same everywhere.
fn across(axis: vec3f) -> vec3f {
    let steep = axis.y * axis.y > 0.5;
    // (0, 0, 1) × axis, or axis × (1, 0, 0).
    let d = select(vec3f(-axis.y, axis.x, 0.0), vec3f(0.0, axis.z, -axis.y), steep);
    let some = select(vec3f(1.0, 0.0, 0.0), d, dot3(d, d) > TINY);
    return some * (1.0 / norm3(some));
}

fn cylinder_depth(solid: Collider, x: vec3f) -> Depth {
    let axis = solid.axis_u;
    let away = x - solid.place;
    let along = dot3(away, axis);
    // On the axis, what rounding leaves must not point along it.
    let apart = away - axis * along;
    let outward = direction_and_length(apart - axis * dot3(apart, axis), across(axis));
    let end_side = select(1.0, -1.0, along < 0.0);
    let end = along * end_side - solid.u;
    let side = outward.w - solid.v;
    let outside = direction_and_length(positive(vec3f(end, side, 0.0)), vec3f(0.0));
    let by_end = end >= side;
    let deepest = select(side, end, by_end);
    let inside = deepest <= 0.0;
    let flat = select(0.0, 1.0, by_end);
    let p = select(outside.x, flat, inside) * end_side;
    let q = select(outside.y, 1.0 - flat, inside);
    return Depth(axis * p + outward.xyz * q, solid.size - select(outside.w, deepest, inside));
}

/// Of a convex collider. The depth changes by no more than the place does, and along a line it is concave.
fn depth_and_normal(collider: Collider, x: vec3f) -> Depth {
    switch collider.kind {
        case SPHERE: {
            return sphere_depth(collider.place, collider.size, x);
        }
        case BOX: {
            return box_depth(collider, x);
        }
        case CAPSULE: {
            return capsule_depth(collider, x);
        }
        case CYLINDER: {
            return cylinder_depth(collider, x);
        }
        default: {
            return plane_depth(collider.place, collider.size, x);
        }
    }
}

/// Depth of the deepest place of a convex collider [m]: a way that is no longer does not go through it.
fn deepest_in(collider: Collider) -> f32 {
    // 0 for balls and capsules, which have no second number.
    let shorter = select(collider.v, collider.u, collider.u < collider.v);
    let least = select(shorter, select(collider.w, shorter, shorter < collider.w), collider.kind == BOX);
    return least + collider.size;
}

/// Where a way goes into a collider, if it does: depth of its end below the tangent plane there [m], and its normal.
struct Entrance {
    contact: Depth,
    is_one: bool,
}

/// Where the way from `start` to `end` enters a convex collider that it goes through, so that the nearest way out of it, if
/// any, is on the wrong side. Depth along a line is concave, so Newton's method from outside never goes too far.
fn entry_of(collider: Collider, start: vec3f, end: vec3f) -> Entrance {
    let way = end - start;
    let none = Entrance(Depth(vec3f(0.0), 0.0), false);
    var fraction = 0.0;
    // The end is looked at first, and one place after the last step: compilers have a copy of a function wherever it is called.
    for (var i = 0u; i < ENTRIES + 2u; i++) {
        let here = depth_and_normal(collider, select(start + way * fraction, end, i == 0u));
        let approach = -dot3(here.normal, way);
        if i == 0u {
            if approach >= 0.0 {
                return none;
            }
            continue;
        }
        let is_last = i == ENTRIES + 1u;
        if !(is_last || approach > 0.0) {
            return none;
        }
        let next = fraction - here.depth / approach;
        // As near as numbers tell.
        if is_last || here.depth >= 0.0 || next <= fraction {
            return Entrance(Depth(here.normal, here.depth + approach * (1.0 - fraction)), true);
        }
        if next > 1.0 {
            return none;
        }
        fraction = next;
    }
    return none;
}

/// Velocity [m/s] of the collider's surface at `x`.
fn surface_velocity(collider: Collider, x: vec3f) -> vec3f {
    let turning = vec3f(dot3(collider.spin_x, x), dot3(collider.spin_y, x), dot3(collider.spin_z, x));
    return turning + collider.drift;
}

/// Where a place of the collider has gone in the sub-step [m].
fn carried(collider: Collider, x: vec3f) -> vec3f {
    let turned = vec3f(dot3(collider.carry_x.xyz, x), dot3(collider.carry_y.xyz, x), dot3(collider.carry_z.xyz, x));
    return turned + vec3f(collider.carry_x.w, collider.carry_y.w, collider.carry_z.w);
}
