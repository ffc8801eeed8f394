// Contact of a position with all colliders, solids and meshes.

#import contact/colliders/met.wgsl
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

/// Moves a position out of all colliders, if it is in another than the one that it touched last. In a wedge, leaving one collider
/// enters the other. So the two deepest penetrations are resolved together.
fn push_out(start: vec3f, last: u32, met: Met) -> vec3f {
    var x = start;
    var is_inside_another = false;
    for (var round = 0u; round < ROUNDS; round++) {
        var most = Depth(vec3f(0.0), -FAR);
        var next = Depth(vec3f(0.0), -FAR);
        for (var i = 0u; i < met.count; i++) {
            let penetration = penetration_of(collider_met(met, i), x);
            is_inside_another |= i + 1u != last && penetration.depth > 0.0;
            if penetration.depth > most.depth {
                next = most;
                most = penetration;
            } else if penetration.depth > next.depth {
                next = penetration;
            }
        }
        if most.depth <= 0.0 || !is_inside_another {
            break;
        }
        x = x + leave_both(most, next);
    }
    return x;
}

/// Keeps a free node out of the colliders that it meets. Colliders act in the scene's order. If one of
/// them pushes the node into another, the node is moved out of both, and its velocity does not change again.
fn contact(start: vec3f, velocity: vec3f, origin: Origin, met: Met, h: f32) -> ContactState {
    var node = ContactState(start, 0u, velocity);
    for (var i = 0u; i < met.count; i++) {
        let collider = collider_met(met, i);
        if collider.kind == MESH {
            node = collide_mesh(node, origin, collider, i + 1u, h);
        } else {
            node = collide_solid(node, origin, collider, i + 1u, h);
        }
    }
    if node.last != 0u && met.count > 1u {
        node.x = push_out(node.x, node.last, met);
    }
    return node;
}
