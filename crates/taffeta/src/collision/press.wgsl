// Surfaces that bear what constraints press against them.
//
// Contact comes after forces: a solver that does not know of it lets nodes on a surface go where they are pulled, finds
// their pulls relaxed, and contact puts the nodes back under full tension. That is work from nowhere. So nodes that will
// be pressed against a surface are held by it while pulls are solved for: along its normal, or, where friction is enough,
// in all directions (after Baraff and Witkin, "Large Steps in Cloth Simulation", SIGGRAPH 1998, section 5).

/// How a surface holds a node in a sub-step.
struct Press {
    /// Unit normal along which the node does not yield; 0: free.
    normal: vec3f,
    /// Share of what is left in which it yields: 1; 0 where it sticks.
    yields: f32,
    /// Velocity [m/s] of the directions in which it does not: onto the surface, and with it.
    velocity: vec3f,
}

/// A node as it comes to a surface.
struct Coming {
    /// Place at the start of the sub-step [m].
    place: vec3f,
    /// Way that gravity goes in a sub-step [m].
    fall: f32,
    /// Velocity [m/s] without pulls, and change of it by those of the last sub-step.
    free: vec3f,
    /// Sub-step [s].
    h: f32,
    pulls: vec3f,
}

/// How a surface will hold a node, if it does.
struct Held {
    press: Press,
    /// By how much the node would be inside [m]; 0: it is not held.
    inside: f32,
}

/// Of a node that nothing holds.
fn free_press() -> Press {
    return Press(vec3f(0.0), 1.0, vec3f(0.0));
}

/// How a collider will hold a node: it is on the surface, or gets there without pulls, and those of the last sub-step do
/// not take it off.
fn press_of(collider: Collider, node: Coming) -> Held {
    let v = node.free + node.pulls;
    let inside = depth_and_normal(collider, node.place + v * node.h).depth;
    return press_by(collider, node, inside, depth_and_normal(collider, node.place));
}

/// How a surface will hold a node that is so deep in it, and would be so far `inside` [m].
fn press_by(collider: Collider, node: Coming, inside: f32, touch: Depth) -> Held {
    let h = node.h;
    let v = node.free + node.pulls;
    let normal = touch.normal;
    let way = -h * dot3(node.free, normal);
    let reach = select(node.fall, way + node.fall, way > 0.0);
    if !(inside > 0.0 && -touch.depth <= reach) {
        return Held(free_press(), 0.0);
    }
    let surface = surface_velocity(collider, node.place);
    let landing = touch.depth / h;
    let relative = v - surface;
    let impulse = landing - dot3(v, normal);
    let slip = norm3(relative - normal * dot3(relative, normal));
    let along = surface - normal * dot3(surface, normal);
    let onto = normal * landing;
    if slip <= collider.friction * impulse {
        return Held(Press(normal, 0.0, onto + along), inside);
    }
    return Held(Press(normal, 1.0, onto), inside);
}

/// A change of velocity, as far as the node yields to it.
fn yielded(press: Press, v: vec3f) -> vec3f {
    return (v - press.normal * dot3(v, press.normal)) * press.yields;
}

/// Whether a surface holds the node.
fn is_pressed(press: Press) -> bool {
    return press.normal.x != 0.0 || press.normal.y != 0.0 || press.normal.z != 0.0;
}

/// Velocity [m/s] of a node that is held after `pulls`; `free` is without them. What they press, the surface bears, and
/// friction comes with it: where it was enough, the node stays. What takes the node off lets it go no further than onto the
/// surface: the next sub-step knows these pulls.
fn after_pulls(press: Press, free: vec3f, pulls: vec3f, collider: Collider, place: vec3f) -> vec3f {
    let normal = press.normal;
    let landing = dot3(press.velocity, normal);
    let inward = dot3(free, normal);
    let pulled = dot3(free + pulls, normal);
    let least = select(landing, inward, inward < landing);
    let some = select(pulled, least, pulled < least);
    let kept = select(some, landing, some > landing);
    if press.yields == 0.0 {
        return press.velocity + normal * (kept - landing);
    }
    let moved = free + pulls + normal * (kept - pulled);
    let impulse = select(0.0, kept - pulled, kept > pulled);
    return moved + rub(moved - surface_velocity(collider, place), normal, collider.friction * impulse);
}
