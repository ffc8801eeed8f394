// Points of nodes that are sewn to each other, in the system; an invocation for each point.

#import contact/colliders/predicted_contact.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import solvers/dual/solve.wgsl
#import solvers/implicit/joined_systems.wgsl
#import solvers/implicit/levels.wgsl
#import solvers/implicit/sewn.wgsl

/// Systems that points join, two by two.
@group(1) @binding(82) var<storage, read> sewn_links: array<vec2u>;

/// Joins the systems of nodes that are sewn to each other.
@compute @workgroup_size(256)
fn join_sewn_systems(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let number = node_of(id, lane);
    if number < arrayLength(&sewn_links) {
        join(sewn_links[number].x, sewn_links[number].y);
    }
}

/// Finds the weights of the nodes of each point.
@compute @workgroup_size(256)
fn weigh_points(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let number = node_of(id, lane);
    if number + 1u >= arrayLength(&sewn_starts) {
        return;
    }
    let first = sewn_starts[number];
    var those_before = diagonals[sewn_nodes[first]].inverse;
    for (var i = first + 1u; i < sewn_starts[number + 1u]; i++) {
        let both = parallel(those_before, diagonals[sewn_nodes[i]].inverse);
        sewn_weights[i] = both.weight;
        those_before = both.together;
    }
}

/// Distributes the residual of each point among its nodes, and takes the first step of the cycle there.
@compute @workgroup_size(256)
fn distribute_residuals(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let number = node_of(id, lane);
    if number + 1u >= arrayLength(&sewn_starts) {
        return;
    }
    let first = sewn_starts[number];
    let end = sewn_starts[number + 1u];
    var left = vec3f(0.0);
    for (var i = first; i < end; i++) {
        left += vector_of(RESIDUAL, sewn_nodes[i]);
    }
    for (var i = end; i > first; i--) {
        let node = sewn_nodes[i - 1u];
        var others = vec3f(0.0);
        if i - 1u > first {
            others = transposed_times(sewn_weights[i - 1u], left);
        }
        let residual = left - others;
        vectors[vector_at(RESIDUAL, node)] = vec4f(residual, mass_of(node));
        put_vector(CYCLE, node, jacobi_step(node, residual));
        left = others;
    }
}

/// Averages what the cycle has found over the nodes of each point.
@compute @workgroup_size(256)
fn average_points(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let number = node_of(id, lane);
    if number + 1u >= arrayLength(&sewn_starts) {
        return;
    }
    let first = sewn_starts[number];
    let end = sewn_starts[number + 1u];
    var all = vector_of(CYCLED, sewn_nodes[first]);
    for (var i = first + 1u; i < end; i++) {
        let one = vector_of(CYCLED, sewn_nodes[i]);
        all = one + weight_times(sewn_weights[i], all - one);
    }
    for (var i = first; i < end; i++) {
        put_vector(CYCLED, sewn_nodes[i], all);
    }
}

/// Has the nodes of a point that something holds press on it together: a pin bears what the nodes that are sewn to its own
/// lack, a surface as much by each node as it has of the mass.
@compute @workgroup_size(256)
fn pool_impulses(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let number = node_of(id, lane);
    if number + 1u >= arrayLength(&sewn_starts) {
        return;
    }
    let first = sewn_starts[number];
    let end = sewn_starts[number + 1u];
    var pin = NONE;
    for (var i = end; i > first; i--) {
        pin = select(pin, sewn_nodes[i - 1u], !(old_position[sewn_nodes[i - 1u]].w > 0.0));
    }
    if pin != NONE {
        var sum = vector_of(GIVEN, pin);
        for (var i = first; i < end; i++) {
            let node = sewn_nodes[i];
            let total = vector_of(TOTAL, node) + vector_of(CHANGE, node);
            let lacks = vector_of(GIVEN, node) - total * mass_of(node);
            sum += select(vec3f(0.0), lacks, old_position[node].w > 0.0);
        }
        put_vector(GIVEN, pin, sum);
    } else if in_contact(predicted_at(sewn_nodes[first])) {
        var sum = vec3f(0.0);
        var mass = 0.0;
        for (var i = first; i < end; i++) {
            sum += vector_of(GIVEN, sewn_nodes[i]);
            mass += abs(old_velocity[sewn_nodes[i]].w);
        }
        for (var i = first; i < end; i++) {
            put_vector(GIVEN, sewn_nodes[i], sum * (abs(old_velocity[sewn_nodes[i]].w) / mass));
        }
    }
}
