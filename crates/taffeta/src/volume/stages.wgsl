// The stages of bodies that keep their volume. A multiplier needs the forces on all nodes of its body, so the particle
// stages are two kernels here. The measuring kernels read the state of now: that before the sub-step for forces, and the one
// after it to restore volumes.

#import contact/collider_mesh/no_mesh.wgsl as meshes
#import contact/colliders/response.wgsl
#import elements/load/load.wgsl
#import elements/spring/mesh.wgsl
#import elements/spring/places.wgsl
#import elements/spring/spring.wgsl
#import gpu/wgsl/force.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl
#import solvers/explicit/euler.wgsl
#import solvers/explicit/node.wgsl
#import volume/groups.wgsl
#import volume/volume.wgsl
#import memory
#import resolve_contact

/// A walk around a node: Σ rₖ × rₖ₊₁ over its neighbours, where r is the vector to one.
struct Walk {
    first: vec3f,
    last: vec3f,
    sum: vec3f,
}

/// The sum with one triangle more, if it is there. A choice between two numbers keeps compilers from adding the products
/// one by one, which rounds otherwise.
fn with_triangle(walk: Walk, to: vec3f, is_there: bool) -> vec3f {
    return walk.sum + select(vec3f(0.0), cross3(walk.last, to), is_there);
}

/// The walk with one neighbour more; padding, whose rest length is 0, does not count.
fn with_neighbour(walk: Walk, i: u32, to: vec3f, rest_length: f32) -> Walk {
    let is_there = rest_length != 0.0;
    return Walk(select(walk.first, to, i == 0u), select(walk.last, to, is_there), with_triangle(walk, to, is_there));
}

/// Gradient of the volume [m²], at the end of a walk past `count` entries.
fn close(walk: Walk, count: u32) -> vec3f {
    return with_triangle(walk, walk.first, count > 0u) / 6.0;
}

struct Pulled {
    force: vec3f,
    gradient: vec3f,
}

/// The force so far [N] and that of all springs at a node, and the gradient of the volume. A rest length below 0: a
/// neighbour without a spring.
fn add_ring(before: vec3f, node: u32, x: vec3f, v: vec3f) -> Pulled {
    let ring = runs[node / LANES * KINDS];
    var walk = Walk(vec3f(0.0), vec3f(0.0), vec3f(0.0));
    var sum = vec3f(0.0);
    let count = ring.count & ~IS_RING;
    for (var i = 0u; i < count; i++) {
        let entry = entries[ring.start + LANES * i + node % LANES];
        let d = position_of(entry.neighbour) - x;
        let dv = velocity_of(entry.neighbour) - v;
        let factor = spring_factor(d, dv, ring.k, ring.damping, entry.rest_length);
        sum += select(0.0, factor, entry.rest_length > 0.0) * d;
        walk = with_neighbour(walk, i, d, entry.rest_length);
    }
    return Pulled(add_kinds(before + sum, 1u, node, x, v), close(walk, count));
}

/// The gradient alone.
fn ring_gradient(node: u32, x: vec3f) -> vec3f {
    let ring = runs[node / LANES * KINDS];
    var walk = Walk(vec3f(0.0), vec3f(0.0), vec3f(0.0));
    let count = ring.count & ~IS_RING;
    for (var i = 0u; i < count; i++) {
        let entry = entries[ring.start + LANES * i + node % LANES];
        walk = with_neighbour(walk, i, position_of(entry.neighbour) - x, entry.rest_length);
    }
    return close(walk, count);
}

/// What a lane without a node brings: one that is not held and adds nothing.
fn no_volume_node() -> VolumeNode {
    return VolumeNode(vec3f(0.0), 1.0, vec3f(0.0), 0.0, vec3f(0.0), 0.0);
}

/// Keeps the gradient of a group's node for later, and gives the node as the sums need it: with the velocity that it would
/// have without the constraint.
fn moving_node(group: VolumeGroup, lane: u32, pulled: Pulled) -> VolumeNode {
    let x = old_position[group.first + lane];
    let v = old_velocity[group.first + lane];
    let weight = force[group.gradients + lane].w;
    force[group.gradients + lane] = vec4f(pulled.gradient, weight);
    let velocity = new_velocity_of(v.xyz, pulled.force, x.w, substeps[0].gravity, substeps[0].h);
    return VolumeNode(x.xyz - position_of(group.origin), x.w, pulled.gradient, abs(v.w), velocity, weight);
}

/// Adds springs to the load on a group's node, and keeps both as its force.
fn pulled_node(group: VolumeGroup, lane: u32, load: vec3f) -> VolumeNode {
    let place = group.first + lane;
    let pulled = add_ring(load, place, position_of(place), velocity_of(place));
    force[place] = vec4f(pulled.force, 0.0);
    return moving_node(group, lane, pulled);
}

/// Wind, drag, springs; gradients and sums.
@compute @workgroup_size(256)
fn volume_forces(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&volume_groups) {
        return;
    }
    let group = volume_groups[index];
    var node = no_volume_node();
    if lane < group.count {
        let place = group.first + lane;
        node = pulled_node(group, lane, wind_and_drag(substeps[0].wind, substeps[0].drag, velocity_of(place)));
    }
    sum_up(index, group, lane, node);
}

/// The same where loads were summed up beforehand.
@compute @workgroup_size(256)
fn volume_forces_given(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&volume_groups) {
        return;
    }
    let group = volume_groups[index];
    var node = no_volume_node();
    if lane < group.count {
        let place = group.first + lane;
        node = pulled_node(group, lane, force[place].xyz);
    }
    sum_up(index, group, lane, node);
}

/// Gradients and sums where all other forces are there.
@compute @workgroup_size(256)
fn volume_gradients(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&volume_groups) {
        return;
    }
    let group = volume_groups[index];
    var node = no_volume_node();
    if lane < group.count {
        let place = group.first + lane;
        node = moving_node(group, lane, Pulled(force[place].xyz, ring_gradient(place, position_of(place))));
    }
    sum_up(index, group, lane, node);
}

/// The force of the constraint, then the particle stages that are left.
@compute @workgroup_size(256)
fn volume_particles(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&volume_groups) {
        return;
    }
    let group = volume_groups[index];
    let found = find_correction(group, lane);
    let lambda = multiplier(group.form, found.sums, found.goal, substeps[0].h);
    if lane < group.count {
        let place = group.first + lane;
        let x = old_position[place];
        let v = old_velocity[place];
        let direction = direction_of(group, found.correction, lane, x.xyz, abs(v.w));
        let total = force[place].xyz + direction * lambda;
        if !(x.w > 0.0) {
            // What a pin has to hold against.
            force[place] = vec4f(total, 0.0);
        }
        let after = resolve_contact(place, integrate(x, v, total, 0u), Origin(x.xyz, true), 0u);
        new_position[place] = after.position;
        new_velocity[place] = after.velocity;
    }
}

/// Gradients and sums over nodes that may still be moved: those that have touched nothing.
@compute @workgroup_size(256)
fn measure_kept_volumes(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&volume_groups) {
        return;
    }
    let group = volume_groups[index];
    if !is_flagged(group, RESTORED) {
        return;
    }
    var node = no_volume_node();
    if lane < group.count {
        let place = group.first + lane;
        let x = old_position[place];
        let signed_mass = old_velocity[place].w;
        let gradient = ring_gradient(place, x.xyz);
        let weight = force[group.gradients + lane].w;
        force[group.gradients + lane] = vec4f(gradient, weight);
        let from_origin = x.xyz - position_of(group.origin);
        let inverse_mass = select(x.w, 0.0, signed_mass < 0.0);
        // In place of the velocity: what makes the flux the response of all nodes.
        let all = gradient * (x.w * weight);
        node = VolumeNode(from_origin, inverse_mass, gradient, abs(signed_mass), all, weight);
    }
    sum_up(index, group, lane, node);
}
