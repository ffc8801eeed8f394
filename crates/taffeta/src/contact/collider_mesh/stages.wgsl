// Kernels of their own for meshes as colliders, beside contact_all and restore_volumes: other kernels have no buffer
// left for triangles.

#import contact/collider_mesh/surface.wgsl as meshes
#import contact/colliders/met.wgsl
#import contact/colliders/predicted_contact.wgsl
#import contact/colliders/shape.wgsl
#import contact/colliders/resolve_contact_again.wgsl
#import contact/nodes/broad_phase.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl
#import solvers/dual/solve.wgsl
#import solvers/implicit/levels.wgsl

/// Keeps nodes out of colliders again after the response of self-collision.
@compute @workgroup_size(256)
fn contact_after_self_collision(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let node = node_of(id, lane);
    if node >= arrayLength(&old_position) || contacts_of(node) == 0u {
        return;
    }
    let v = new_velocity[node];
    resolve_contact_again(node, old_position[node], v, new_position[node].xyz, v.xyz);
}

/// Predicted contact of a node with a mesh. Its surface counts as flat around the node.
fn predict_mesh_contact(collider: Collider, node: Approach) -> Candidate {
    let contact = mesh_contact(collider, node.position, collider.size + node.h * norm3(node.free) + node.reach);
    if contact.depth == -FAR {
        return Candidate(no_contact(), 0.0);
    }
    let inside = contact.depth - node.h * dot3(node.free + node.solver_change, contact.normal);
    return predict_at_surface(collider, node, inside, Depth(contact.normal, contact.depth), contact.velocity);
}

/// The deepest predicted contact of the node at a place with a mesh.
fn deepest_mesh_contact(place: u32, node: Approach) -> ContactRecord {
    var found = contact_record(no_contact(), 0u, 0.0);
    let met = met_by(place, 0u);
    for (var i = 0u; i < met.count; i++) {
        let collider = collider_met(met, i);
        if collider.kind == MESH {
            let candidate = predict_mesh_contact(collider, node);
            if candidate.inside > found.inside {
                found = contact_record(candidate.predicted, i, candidate.inside);
            }
        }
    }
    return found;
}

/// Predicts contacts with meshes, before predict_contacts.
@compute @workgroup_size(256)
fn predict_mesh_contacts(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&node_groups) || lane >= node_groups[index].count {
        return;
    }
    let node = node_groups[index].first + lane;
    let x = old_position[node];
    if predicted_contacts[node].is_constrained == 0u || !(x.w > 0.0) || substeps[own()].solving.is_adaptive != 0u {
        return;
    }
    let h = substeps[0].h;
    let reach = reach_of(substeps[0].gravity, h);
    let spring_change = x.w * gather_constraint_forces(node) * -h;
    predicted_contacts[node] = deepest_mesh_contact(node, Approach(x.xyz, reach, new_velocity[node].xyz, h, spring_change));
}

/// The same for implicit springs, before predict_contacts_implicit.
@compute @workgroup_size(256)
fn predict_mesh_contacts_implicit(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) || lane >= level_groups[index].count {
        return;
    }
    let node = level_groups[index].first + lane;
    let x = old_position[node];
    if x.w > 0.0 {
        let h = substeps[0].h;
        let reach = reach_of(substeps[0].gravity, h);
        let approach = Approach(x.xyz, reach, new_velocity[node].xyz, h, vector_of(SPRING_CHANGE, node));
        predicted_contacts[node] = deepest_mesh_contact(node, approach);
    }
}
