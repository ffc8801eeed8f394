// Contact of a position with all colliders, solids and meshes.

#import contact/colliders/response.wgsl
#import contact/colliders/shape.wgsl
#import meshes

/// Rounds in which a position leaves a wedge between curved colliders. Each round halves the number of wrong digits.
const ROUNDS: u32 = 12u;

/// The penetration of a position into any collider. For a mesh it is known inside only.
fn penetration_of(collider: Collider, x: vec3f) -> Depth {
    if collider.kind == MESH {
        return mesh_penetration(collider, x);
    }
    return depth_and_normal(collider, x);
}

/// Moves a position out of all colliders. In a wedge, leaving one collider enters the other. So the two deepest
/// penetrations are resolved together.
fn push_out(start: vec3f, first: u32, count: u32) -> vec3f {
    var x = start;
    for (var round = 0u; round < ROUNDS; round++) {
        var most = Depth(vec3f(0.0), -FAR);
        var next = Depth(vec3f(0.0), -FAR);
        for (var i = 0u; i < count; i++) {
            let penetration = penetration_of(colliders[first + i], x);
            if penetration.depth > most.depth {
                next = most;
                most = penetration;
            } else if penetration.depth > next.depth {
                next = penetration;
            }
        }
        if most.depth <= 0.0 {
            break;
        }
        x = x + leave_both(most, next);
    }
    return x;
}

/// Keeps a free node out of `count` colliders, starting at `first`. Colliders act in the scene's order. If one of
/// them pushes the node into another, the node is moved out of both, and its velocity does not change again.
fn contact(start: vec3f, velocity: vec3f, origin: Origin, first: u32, count: u32, h: f32) -> ContactState {
    var node = ContactState(start, 0u, velocity);
    for (var i = 0u; i < count; i++) {
        let collider = colliders[first + i];
        if collider.kind == MESH {
            node = collide_mesh(node, origin, collider, i + 1u, h);
        } else {
            node = collide_solid(node, origin, collider, i + 1u, h);
        }
    }
    if node.last == 0u || count < 2u {
        return node;
    }
    var is_inside_another = false;
    for (var i = 0u; i < count; i++) {
        let penetration = penetration_of(colliders[first + i], node.x);
        is_inside_another = is_inside_another || (i + 1u != node.last && penetration.depth > 0.0);
    }
    if is_inside_another {
        node.x = push_out(node.x, first, count);
    }
    return node;
}
