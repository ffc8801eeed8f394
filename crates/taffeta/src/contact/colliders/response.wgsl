// Contact response: position and velocity of a node that is inside a collider.
//
// The new position is put back onto the surface, the inward normal speed is removed or reflected (restitution e),
// and Coulomb friction takes at most μ times the normal impulse from the tangential speed relative to the
// collider's own motion. Va, Choi, Hong 2021 (S1), algorithm 4, adds unit vectors to velocities instead, which has
// no unit and depends on the step; this is the textbook impulse form (Baraff, Witkin, "Physically Based Modeling",
// SIGGRAPH course notes, 2001).

#import contact/colliders/shape.wgsl
#import gpu/wgsl/vector.wgsl

/// A node during contact.
struct ContactState {
    x: vec3f,
    /// The collider that it touched last, from 1; 0: none.
    last: u32,
    v: vec3f,
}

/// Squared sine of the angle below which a wedge counts as two opposite faces, about 10°. The way out of a narrower
/// wedge is so long that a node pinched between a ball and a floor would be thrown across the scene.
const NARROW: f32 = 0.03;

/// Position [m] and velocity [m/s] after contact, at the end of a step `h` [s].
fn respond(node: ContactState, collider: Collider, contact: Depth, h: f32) -> ContactState {
    return respond_to_surface(node, collider, contact, surface_velocity(collider, node.x), h);
}

/// The same for a given velocity of the surface [m/s].
fn respond_to_surface(node: ContactState, collider: Collider, contact: Depth, surface: vec3f, h: f32) -> ContactState {
    let lifted = node.x + contact.normal * contact.depth;
    let relative = node.v - surface;
    // A node that is separating gets no impulse, and hence no friction.
    let closing = -dot3(relative, contact.normal);
    let approach = select(0.0, closing, closing > 0.0);
    let impulse = (1.0 + collider.restitution) * approach;
    let friction = friction_of(relative, contact.normal, collider.friction * impulse);
    let velocity = node.v + contact.normal * impulse + friction;
    return ContactState(lifted + friction * h, node.last, velocity);
}

/// Change of velocity by friction that takes at most `most` [m/s] from the tangential part of a relative velocity.
fn friction_of(relative: vec3f, normal: vec3f, most: f32) -> vec3f {
    let tangential = relative - normal * dot3(relative, normal);
    let slip = norm3(tangential);
    let fraction = select(1.0, most / select(1.0, slip, slip > most), slip > most);
    let lost = select(0.0, fraction, most > 0.0);
    return tangential * -lost;
}

/// The shortest translation [m] out of two half-spaces. If one of them is sufficient, or if they are opposite, only
/// the first is left.
fn leave_both(first: Depth, second: Depth) -> vec3f {
    let cosine = dot3(first.normal, second.normal);
    let room = 1.0 - cosine * cosine;
    if first.depth * cosine >= second.depth || room <= NARROW {
        return first.normal * first.depth;
    }
    let a = (first.depth - cosine * second.depth) / room;
    let b = (second.depth - cosine * first.depth) / room;
    return first.normal * a + second.normal * b;
}

/// The start of a node's motion, and whether colliders have moved since.
struct Origin {
    /// [m]
    x: vec3f,
    is_carried: bool,
}

/// The start of a node's motion [m], moved along with the collider.
fn seen_from(collider: Collider, origin: Origin) -> vec3f {
    return select(origin.x, carried(collider, origin.x), origin.is_carried);
}

/// Collides a node with a convex collider: first where its swept segment enters the collider, if it passes through;
/// then by the nearest way out.
fn collide_solid(start: ContactState, origin: Origin, collider: Collider, number: u32, h: f32) -> ContactState {
    var node = start;
    if collider.kind != PLANE {
        let come = seen_from(collider, origin);
        let way = node.x - come;
        let far = deepest_in(collider);
        if dot3(way, way) > far * far {
            let entrance = entry_of(collider, come, node.x);
            if entrance.is_one {
                node = respond(node, collider, entrance.contact, h);
                node.last = number;
            }
        }
    }
    let contact = depth_and_normal(collider, node.x);
    if contact.depth > 0.0 {
        node = respond(node, collider, contact, h);
        node.last = number;
    }
    return node;
}

