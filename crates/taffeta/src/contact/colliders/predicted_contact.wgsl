// Predicted contact: surfaces that support nodes while constraints are solved. Source and reasons:
// predicted_contact.rs.

#import contact/colliders/shape.wgsl
#import gpu/wgsl/vector.wgsl

/// A node sticks up to this fraction of the friction limit.
const STICKS: f32 = 0.95;
/// Fraction of the approach speed that is left to contact.
const LEFT_TO_CONTACT: f32 = 0.0625;

/// Predicted contact of a node in a sub-step.
struct PredictedContact {
    /// Unit normal of the surface; 0: no contact.
    normal: vec3f,
    /// 1 if the node slides, or is free; 0 if it sticks.
    slides: f32,
    /// Velocity [m/s]. Along the normal: the landing velocity. Along the surface: the surface's velocity if the node
    /// sticks, else the change by friction.
    velocity: vec3f,
    /// Speed of the surface [m/s] in the direction in which the node slides.
    surface_speed: f32,
}

/// The motion of a node before a sub-step is solved.
struct Approach {
    /// Position at the start of the sub-step [m].
    position: vec3f,
    /// How far from a surface a node at rest counts as on it [m].
    reach: f32,
    /// Velocity [m/s] without constraints, and its change by the constraints of the last sub-step.
    free: vec3f,
    /// Length of the sub-step [s].
    h: f32,
    solver_change: vec3f,
}

/// A predicted contact, and how deep it is.
struct Candidate {
    predicted: PredictedContact,
    /// Predicted depth [m]; 0: no contact.
    inside: f32,
}

/// A node so near to a surface touches it [m].
const TOUCHES: f32 = 1e-6;

/// How far from a surface a node at rest counts as on it [m]: what it falls in a sub-step `h` [s], or `TOUCHES`.
fn reach_of(gravity: vec3f, h: f32) -> f32 {
    return max(norm3(gravity) * h * h, TOUCHES);
}

/// No contact.
fn no_contact() -> PredictedContact {
    return PredictedContact(vec3f(0.0), 1.0, vec3f(0.0), 0.0);
}

/// Predicted contact with a convex collider. A node is in contact if it is on the surface, or reaches it without
/// constraints, and the constraint forces of the last sub-step do not lift it off.
fn predict_contact(collider: Collider, node: Approach) -> Candidate {
    let v = node.free + node.solver_change;
    let inside = depth_and_normal(collider, node.position + v * node.h).depth;
    return predict_at_surface(collider, node, inside, depth_and_normal(collider, node.position), vec3f(0.0));
}

/// Predicted contact with a surface, from the present penetration and the predicted depth `inside` [m]. `changing` is
/// the velocity of the surface by a change of shape [m/s].
fn predict_at_surface(collider: Collider, node: Approach, inside: f32, contact: Depth, changing: vec3f) -> Candidate {
    let h = node.h;
    let v = node.free + node.solver_change;
    let normal = contact.normal;
    let way = -h * dot3(node.free, normal);
    let reach = select(node.reach, way + node.reach, way > 0.0);
    if !(inside > 0.0 && -contact.depth <= reach) {
        return Candidate(no_contact(), 0.0);
    }
    let surface_v = surface_velocity(collider, node.position) + changing;
    // Contact pushes out a node that is inside already, and gives it no speed.
    let onto = contact.depth / h;
    let out = dot3(surface_v, normal);
    let landing = select(out, onto, onto < out);
    let relative = v - surface_v;
    let impulse = landing - dot3(v, normal);
    let friction_limit = collider.friction * select(0.0, impulse, impulse > 0.0);
    let slip = relative - normal * dot3(relative, normal);
    let speed = norm3(slip);
    if speed <= friction_limit * STICKS && friction_limit > 0.0 {
        let along = surface_v - normal * dot3(surface_v, normal);
        return Candidate(PredictedContact(normal, 0.0, normal * landing + along, 0.0), inside);
    }
    let direction = slip * (1.0 / select(1.0, speed, speed > 0.0));
    let velocity = normal * landing - direction * friction_limit;
    return Candidate(PredictedContact(normal, 1.0, velocity, dot3(surface_v, direction)), inside);
}

/// The part of a velocity change in which the node is free to move.
fn filtered(predicted: PredictedContact, v: vec3f) -> vec3f {
    return (v - predicted.normal * dot3(v, predicted.normal)) * predicted.slides;
}

/// Whether the node is in contact.
fn in_contact(predicted: PredictedContact) -> bool {
    return predicted.normal.x != 0.0 || predicted.normal.y != 0.0 || predicted.normal.z != 0.0;
}

/// The velocity change [m/s] of a sliding node by friction.
fn friction_change(predicted: PredictedContact) -> vec3f {
    return (predicted.velocity - predicted.normal * dot3(predicted.velocity, predicted.normal)) * predicted.slides;
}

/// The velocity [m/s] of a node in contact after `solver_change`; `free` is the velocity without it. The surface
/// supports what pushes the node into it. What lifts the node off moves it onto the surface at most: the next
/// sub-step knows that force. If the node bounces, contact follows. Friction stops a sliding node and does not
/// reverse it. The friction that contact will apply is left to contact.
fn velocity_after(predicted: PredictedContact, free: vec3f, solver_change: vec3f, collider: Collider) -> vec3f {
    let normal = predicted.normal;
    let landing = dot3(predicted.velocity, normal);
    let inward = dot3(free, normal);
    let changed = dot3(free + solver_change, normal);
    let least = select(landing, inward, inward < landing);
    let some = select(changed, least, changed < least);
    let bouncing = select(some, landing, some > landing);
    let kept = select(bouncing, landing - (landing - least) * LEFT_TO_CONTACT, collider.restitution == 0.0);
    if predicted.slides == 0.0 {
        return predicted.velocity + normal * (kept - landing);
    }
    let moved = free + solver_change + normal * (kept - changed);
    let friction = friction_change(predicted);
    let friction_limit = norm3(friction);
    if friction_limit == 0.0 {
        return moved;
    }
    // Opposite to the slip.
    let against = friction * (1.0 / friction_limit);
    let slip = -predicted.surface_speed - dot3(moved, against);
    let taken = select(friction_limit, slip, slip < friction_limit);
    let now = taken - collider.friction * (landing - kept);
    return moved + against * select(0.0, now, now > 0.0);
}
