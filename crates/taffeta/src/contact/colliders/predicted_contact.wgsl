// Surfaces that bear what constraints press against them.
//
// Contact comes after forces: a solver that does not know of it lets nodes on a surface go where they are pulled, finds
// their pulls relaxed, and contact puts the nodes back under full tension. That is work from nowhere. So nodes that will
// be pressed against a surface are held by it while pulls are solved for: along its normal, or, where friction is enough,
// in all directions (after Baraff and Witkin, "Large Steps in Cloth Simulation", SIGGRAPH 1998, section 5); where it is not, it
// is a force like others (see predicted_contact.rs).

#import contact/colliders/shape.wgsl
#import gpu/wgsl/vector.wgsl

/// Share of the friction that a surface can bear up to which a node is held.
const STICKS: f32 = 0.95;
/// Share of the speed at which a node comes to a surface that contact takes from it.
const LEFT_TO_CONTACT: f32 = 0.0625;

/// How a surface holds a node in a sub-step.
struct PredictedContact {
    /// Unit normal along which the node does not yield; 0: free.
    normal: vec3f,
    /// Share of what is left in which it yields: 1; 0 where it sticks.
    slides: f32,
    /// Velocity [m/s]: onto the surface; along it that of the surface where the node sticks, and else the change by friction.
    velocity: vec3f,
    /// Velocity of the surface [m/s] in the direction in which a node slides.
    surface_speed: f32,
}

/// A node as it comes to a surface.
struct Approach {
    /// Position at the start of the sub-step [m].
    position: vec3f,
    /// Way that gravity goes in a sub-step [m].
    fall: f32,
    /// Velocity [m/s] without pulls, and change of it by those of the last sub-step.
    free: vec3f,
    /// Sub-step [s].
    h: f32,
    solver_change: vec3f,
}

/// How a surface will hold a node, if it does.
struct Candidate {
    predicted: PredictedContact,
    /// By how much the node would be inside [m]; 0: it is not held.
    inside: f32,
}

/// Of a node that nothing holds.
fn no_contact() -> PredictedContact {
    return PredictedContact(vec3f(0.0), 1.0, vec3f(0.0), 0.0);
}

/// How a collider will hold a node: it is on the surface, or gets there without pulls, and those of the last sub-step do
/// not take it off.
fn predict_contact(collider: Collider, node: Approach) -> Candidate {
    let v = node.free + node.solver_change;
    let inside = depth_and_normal(collider, node.position + v * node.h).depth;
    return predict_at_surface(collider, node, inside, depth_and_normal(collider, node.position), vec3f(0.0));
}

/// How a surface will hold a node that is so deep in it, and would be so far `inside` [m]; `changing` is the velocity by a change
/// of shape [m/s].
fn predict_at_surface(collider: Collider, node: Approach, inside: f32, contact: Depth, changing: vec3f) -> Candidate {
    let h = node.h;
    let v = node.free + node.solver_change;
    let normal = contact.normal;
    let way = -h * dot3(node.free, normal);
    let reach = select(node.fall, way + node.fall, way > 0.0);
    if !(inside > 0.0 && -contact.depth <= reach) {
        return Candidate(no_contact(), 0.0);
    }
    let surface_v = surface_velocity(collider, node.position) + changing;
    // What is inside already is put out by contact, and gets no speed by it.
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

/// A change of velocity, as far as the node yields to it.
fn filtered(predicted: PredictedContact, v: vec3f) -> vec3f {
    return (v - predicted.normal * dot3(v, predicted.normal)) * predicted.slides;
}

/// Whether a surface holds the node.
fn in_contact(predicted: PredictedContact) -> bool {
    return predicted.normal.x != 0.0 || predicted.normal.y != 0.0 || predicted.normal.z != 0.0;
}

/// The change of velocity [m/s] by friction of a node that slides.
fn friction_change(predicted: PredictedContact) -> vec3f {
    return (predicted.velocity - predicted.normal * dot3(predicted.velocity, predicted.normal)) * predicted.slides;
}

/// Velocity [m/s] of a node that is held after `solver_change`; `free` is without it. What it presses, the surface bears. What
/// takes the node off lets it go no further than onto the surface: the next sub-step knows these pulls. Where it would bounce,
/// contact comes after. Friction stops a node that slides, and does not turn it back; as much of it as contact will take is left
/// to that.
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
    // Against the slip.
    let against = friction * (1.0 / friction_limit);
    let slip = -predicted.surface_speed - dot3(moved, against);
    let taken = select(friction_limit, slip, slip < friction_limit);
    let now = taken - collider.friction * (landing - kept);
    return moved + against * select(0.0, now, now > 0.0);
}
