// What a surface does to a node that has come too close.
//
// The new position is put back onto the surface, the inward normal speed is removed or reflected (restitution e),
// and Coulomb friction takes at most μ times the normal impulse from the tangential speed relative to the
// collider's own motion. Va, Choi, Hong 2021 (S1), algorithm 4, adds unit vectors to velocities instead, which has
// no unit and depends on the step; this is the textbook impulse form (Baraff, Witkin, "Physically Based Modeling",
// SIGGRAPH course notes, 2001).

/// A node that may touch.
struct Touched {
    x: vec3f,
    /// The collider that it touched last, from 1; 0: none.
    last: u32,
    v: vec3f,
}

/// A length beyond all scenes [m].
const FAR: f32 = 1e30;
/// Squared sine of the angle below which a wedge counts as two faces that face each other, about 10°: the way out of a
/// narrower one is so long that a node pinched between a ball and a floor would be thrown across the scene.
const NARROW: f32 = 0.03;
/// Rounds in which a place leaves a wedge between curved colliders: each halves the number of wrong digits.
const ROUNDS: u32 = 12u;

/// Position [m] and velocity [m/s] after contact, at the end of a step `h` [s].
fn respond(node: Touched, collider: Collider, touch: Depth, h: f32) -> Touched {
    let lifted = node.x + touch.normal * touch.depth;
    let relative = node.v - surface_velocity(collider, node.x);
    // A node that leaves already gets no impulse, and hence no friction.
    let closing = -dot3(relative, touch.normal);
    let approach = select(0.0, closing, closing > 0.0);
    let impulse = (1.0 + collider.restitution) * approach;
    let friction = rub(relative, touch.normal, collider.friction * impulse);
    let velocity = node.v + touch.normal * impulse + friction;
    return Touched(lifted + friction * h, node.last, velocity);
}

/// Change of velocity by friction that takes at most `most` [m/s] from the tangential part of a relative velocity.
fn rub(relative: vec3f, normal: vec3f, most: f32) -> vec3f {
    let tangential = relative - normal * dot3(relative, normal);
    let slip = norm3(tangential);
    let share = select(1.0, most / select(1.0, slip, slip > most), slip > most);
    let lost = select(0.0, share, most > 0.0);
    return tangential * -lost;
}

/// The shortest way [m] out of two half-spaces. Where one of them is enough, or where they face each other, the first
/// alone is left.
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

/// Moves a place out of all colliders. In a wedge, going out of one collider goes into the other; so the two that
/// press most are left together.
fn push_out(start: vec3f, first: u32, count: u32) -> vec3f {
    var x = start;
    for (var round = 0u; round < ROUNDS; round++) {
        var most = Depth(vec3f(0.0), -FAR);
        var next = Depth(vec3f(0.0), -FAR);
        for (var i = 0u; i < count; i++) {
            let pressing = depth_and_normal(colliders[first + i], x);
            if pressing.depth > most.depth {
                next = most;
                most = pressing;
            } else if pressing.depth > next.depth {
                next = pressing;
            }
        }
        if most.depth <= 0.0 {
            break;
        }
        x = x + leave_both(most, next);
    }
    return x;
}

/// Keeps a free node out of `count` colliders from `first` on. Colliders act in the scene's order. A node that one has
/// pushed into another is then moved out of both, without a further change of velocity.
fn contact(start: vec3f, velocity: vec3f, first: u32, count: u32, h: f32) -> Touched {
    var node = Touched(start, 0u, velocity);
    for (var i = 0u; i < count; i++) {
        let collider = colliders[first + i];
        let touch = depth_and_normal(collider, node.x);
        if touch.depth > 0.0 {
            node = respond(node, collider, touch, h);
            node.last = i + 1u;
        }
    }
    if node.last == 0u || count < 2u {
        return node;
    }
    var pressed = false;
    for (var i = 0u; i < count; i++) {
        pressed = pressed || (i + 1u != node.last && depth_and_normal(colliders[first + i], node.x).depth > 0.0);
    }
    if pressed {
        node.x = push_out(node.x, first, count);
    }
    return node;
}
