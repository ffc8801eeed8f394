// The systems of springs that are solved for by nodes, set up again in each Newton step: blocks and right side on the finest
// level, blocks and diagonals of the others by lists.

#import contact/colliders/predicted_contact.wgsl
#import couplings
#import gpu/wgsl/force.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl
#import solvers/dual/deepest_contact.wgsl
#import solvers/dual/solve.wgsl
#import solvers/explicit/euler.wgsl
#import solvers/implicit/implicit.wgsl
#import solvers/implicit/levels.wgsl
#import solvers/implicit/second_order.wgsl
#import solvers/implicit/sewn.wgsl

/// Velocities without springs.
@compute @workgroup_size(256)
fn free_nodes(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) || lane >= level_groups[index].count {
        return;
    }
    let node = level_groups[index].first + lane;
    let v = old_velocity[node];
    let inverse_mass = old_position[node].w;
    let free = new_velocity_of(v.xyz, force[node].xyz, inverse_mass, substeps[0].gravity, substeps[0].h);
    new_velocity[node] = vec4f(free, abs(v.w));
}

/// How a node is held: by a pin, or by the surface that the last sub-step's pulls press it against.
fn find_contact(node: u32, x: vec4f, free: vec3f, spring_change: vec3f) -> ContactRecord {
    if !(x.w > 0.0) {
        return contact_record(PredictedContact(vec3f(0.0), 0.0, vec3f(0.0), 0.0), 0u, 0.0);
    }
    if substeps[own()].colliders == 0u {
        return contact_record(no_contact(), 0u, 0.0);
    }
    let h = substeps[0].h;
    let approach = Approach(x.xyz, reach_of(substeps[0].gravity, h), free, h, spring_change);
    return deepest_contact(node, approach, predicted_contacts[node]);
}

/// What holds each node, and where the first Newton step starts.
@compute @workgroup_size(256)
fn predict_contacts_implicit(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) || lane >= level_groups[index].count {
        return;
    }
    let node = level_groups[index].first + lane;
    let x = old_position[node];
    begin_node(node, find_contact(node, x, new_velocity[node].xyz, vector_of(SPRING_CHANGE, node)));
    if lane == 0u && index == level_groups[index].first_group {
        let none = PcgState(0u, 0u, 0u, 0.0, 0.0, 0.0, 0.0);
        let solve = level_groups[index].solve;
        node_solves[solve] = NodeSolve(0u, 0u, 0u, solve, 0.0, none, none);
    }
}

/// Where the first Newton step starts at a node that is held so.
fn begin_node(node: u32, found: ContactRecord) {
    let x = old_position[node];
    let v = old_velocity[node];
    let before = vector_of(SPRING_CHANGE, node);
    predicted_contacts[node] = found;
    let predicted = predicted_in(found);
    let friction = friction_change(predicted);
    let outside = new_velocity[node].xyz;
    let free = begun(node, x, v.xyz, outside, predicted);
    // It goes on as it went, or as a surface that holds it wants; pins as they are moved.
    let total = select(vec3f(0.0), filtered(predicted, v.xyz) + (predicted.velocity - friction) - free, x.w > 0.0);
    let spring_change = before + (outside - free);
    let start = select(vec3f(0.0), filtered(predicted, spring_change - (total - friction)), substeps[own()].solving.is_warm != 0u);
    let off = select(vec3f(0.0), v.xyz - free, x.w > 0.0);
    put_vector(CHANGE, node, vec3f(0.0));
    put_vector(CYCLED, node, start);
    set_trial_state(node, total);
    let mass = substeps[0].solving.mass * abs(v.w);
    vectors[vector_at(RESIDUAL, node)] = vec4f(0.0, 0.0, 0.0, mass);
    vectors[vector_at(TOTAL, node)] = vec4f(total, mass * dot3(off, off));
}

/// Has what holds one node of a point hold all of them, the first surface where none is pinned; and has them end up in the same
/// place, where the system starts from.
@compute @workgroup_size(256)
fn begin_points(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let number = node_of(id, lane);
    if number + 1u >= arrayLength(&sewn_starts) {
        return;
    }
    let first = sewn_starts[number];
    let end = sewn_starts[number + 1u];
    var holder = NONE;
    var is_pinned = false;
    for (var i = first; i < end; i++) {
        let node = sewn_nodes[i];
        is_pinned = is_pinned || !(old_position[node].w > 0.0);
        holder = select(holder, node, holder == NONE && in_contact(predicted_at(node)));
    }
    if holder != NONE && !is_pinned {
        let found = predicted_contacts[holder];
        for (var i = first; i < end; i++) {
            begin_node(sewn_nodes[i], found);
        }
    }
    var sum = vec3f(0.0);
    var weights = 0.0;
    for (var i = first; i < end; i++) {
        let node = sewn_nodes[i];
        let weight = select(mass_of(node), select(0.0, 1.0, !(old_position[node].w > 0.0)), is_pinned);
        sum += vector_of(DIRECTION, node) * weight;
        weights += weight;
    }
    let middle = sum * (1.0 / weights);
    for (var i = first; i < end; i++) {
        if old_position[sewn_nodes[i]].w > 0.0 {
            begin_at(sewn_nodes[i], middle);
        }
    }
}

/// Has a node end up in a place where the first Newton step starts.
fn begin_at(node: u32, place: vec3f) {
    let velocity = (place - vector_of(START, node)) * (1.0 / substeps[0].solving.inner);
    let free = vector_of(FREE, node);
    let before = vectors[vector_at(TOTAL, node)];
    let warm = filtered(predicted_at(node), vector_of(CYCLED, node) + before.xyz + free - velocity);
    put_vector(CYCLED, node, select(vec3f(0.0), warm, substeps[own()].solving.is_warm != 0u));
    vectors[vector_at(TOTAL, node)] = vec4f(velocity - free, before.w);
    put_vector(DIRECTION, node, place);
    put_vector(DIRECTION_PRODUCT, node, velocity);
}

/// From where a node's system starts; returns its velocity without springs. Outer forces alone would make it `outside` in
/// Euler's step.
fn begun(node: u32, x: vec4f, v: vec3f, outside: vec3f, predicted: PredictedContact) -> vec3f {
    let scheme = substeps[own()].solving;
    var start = x.xyz;
    var free = outside;
    if !(x.w > 0.0) {
        start += (substeps[0].h - scheme.inner) * outside;
        put_vector(RATE, node, vec3f(0.0));
    } else if scheme.is_second != 0u {
        let motion = motion_of(predicted, v, vector_of(RATE, node));
        start += scheme.place_of_velocity * motion.velocity + scheme.place_of_rate * motion.rate;
        free = motion.velocity + scheme.velocity_of_rate * motion.rate + scheme.outer * (outside - v);
    }
    put_vector(START, node, start);
    put_vector(FREE, node, free);
    return free;
}

/// Position and velocity at which the system is linearised: with a change `total` of the velocity without springs.
fn set_trial_state(node: u32, total: vec3f) {
    let velocity = vector_of(FREE, node) + total;
    put_vector(TOTAL, node, total);
    put_vector(DIRECTION, node, new_position_of(vector_of(START, node), velocity, substeps[0].solving.inner));
    put_vector(DIRECTION_PRODUCT, node, velocity);
}

/// Begins another Newton step where the last one ends.
@compute @workgroup_size(256)
fn next_newton_step(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) || lane >= level_groups[index].count {
        return;
    }
    let node = level_groups[index].first + lane;
    let total = vector_of(TOTAL, node) + vector_of(CHANGE, node);
    put_vector(CHANGE, node, vec3f(0.0));
    put_vector(CYCLED, node, vec3f(0.0));
    set_trial_state(node, total);
    if lane == 0u && index == level_groups[index].first_group {
        let last = node_solves[level_groups[index].solve];
        let is_over = substeps[0].solving.is_automatic != 0u && !may_go_on(last);
        let is_met = select(last.is_met, 1u, is_over);
        let again = PcgState(0u, is_met, 0u, last.next.whole, last.next.error, 0.0, 0.0);
        let before = last.before + last.next.iterations;
        let solve = NodeSolve(last.steps + 1u, before, is_met, last.first, last.motion, again, again);
        node_solves[level_groups[index].solve] = solve;
    }
}

/// Blocks of a node's springs, and their sums.
fn add_up_springs(node: u32) -> ElementSums {
    let x = vector_of(DIRECTION, node);
    let v = vector_of(DIRECTION_PRODUCT, node);
    let h = substeps[0].solving.inner;
    var sum = ElementSums(vec3f(0.0), Symmetric(vec3f(0.0), vec3f(0.0)));
    let range = slots_of(node);
    let first = slots[1];
    for (var at = range.x; at < range.y; at += LANES) {
        let spring = slot_springs[at - first];
        let d = vector_of(DIRECTION, slots[at]) - x;
        let dv = vector_of(DIRECTION_PRODUCT, slots[at]) - v;
        let linear = linear_spring(spring.k, spring.damping, h, d, spring.rest_length);
        spring_blocks[at - first] = vec4f(linear.q, linear.across);
        sum.impulse += linear.along * (h * (linear.pull + spring.damping * dot3(dv, linear.along)));
        sum.diagonal = add_block(sum.diagonal, linear.q, linear.across);
    }
    return sum;
}

/// The blocks of a node with itself: `all` of its springs, and the mass.
fn diagonal_of(all: Symmetric, mass: f32, predicted: PredictedContact) -> Diagonal {
    let own = Symmetric(vec3f(mass), vec3f(0.0));
    let none = Symmetric(vec3f(0.0), vec3f(0.0));
    if predicted.slides == 0.0 {
        return Diagonal(sum_of(own, all), none);
    }
    if in_contact(predicted) {
        return Diagonal(sum_of(own, held_block(all, predicted.normal)), inverse_along(all, predicted.normal));
    }
    return Diagonal(own, inverse_of(all));
}

/// Blocks of springs, diagonals and right side: springs' impulse and inertia.
@compute @workgroup_size(256)
fn set_up_nodes(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) || lane >= level_groups[index].count {
        return;
    }
    let node = level_groups[index].first + lane;
    let springs = add_up_springs(node);
    let others = given_by_elements(node);
    let given = ElementSums(springs.impulse + others.impulse, sum_of(springs.diagonal, others.diagonal));
    keep_sum(node, given.diagonal);
    let mass = mass_of(node);
    let predicted = predicted_at(node);
    let all = Symmetric(given.diagonal.diagonal + mass, given.diagonal.mixed);
    diagonals[node] = diagonal_of(all, mass, predicted);
    put_vector(IMPULSE, node, given.impulse);
    vectors[vector_at(RESIDUAL, node)] = vec4f(given.impulse - mass * (vector_of(TOTAL, node) - friction_change(predicted)), mass);
}

/// Blocks of the edges of the first coarser level, in the slots at both ends.
@compute @workgroup_size(256)
fn coarsen_springs(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id) * 256u + lane;
    if index >= arrayLength(&coarse_edges) {
        return;
    }
    let edge = coarse_edges[index];
    var sum = Symmetric(vec3f(0.0), vec3f(0.0));
    for (var i = edge.first; i < edge.first + edge.count; i++) {
        let linear = spring_blocks[edge_weights[i].at];
        sum = sum_of(sum, scaled(block_of(linear.xyz, linear.w), edge_weights[i].weight));
    }
    coarse_blocks[edge.slots.x] = sum;
    coarse_blocks[edge.slots.y] = sum;
}

/// Blocks of the edges of another level, in the slots at both ends.
@compute @workgroup_size(256)
fn coarsen_edges(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id) * 256u + lane;
    if index >= arrayLength(&coarse_edges) {
        return;
    }
    let edge = coarse_edges[index];
    var sum = Symmetric(vec3f(0.0), vec3f(0.0));
    for (var i = edge.first; i < edge.first + edge.count; i++) {
        sum = sum_of(sum, scaled(coarse_blocks[edge_weights[i].at], edge_weights[i].weight));
    }
    coarse_blocks[edge.slots.x] = sum;
    coarse_blocks[edge.slots.y] = sum;
}

/// Diagonals of a coarser level.
@compute @workgroup_size(256)
fn coarsen_nodes(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) || lane >= level_groups[index].count {
        return;
    }
    let node = level_groups[index].first + lane;
    let own = own_of_children(node);
    var all = own;
    let range = slots_of(node);
    let first = slots[0];
    for (var at = range.x; at < range.y; at += LANES) {
        // Those of slots without an edge are 0: nothing writes them.
        all = sum_of(all, coarse_blocks[at - first]);
    }
    diagonals[node] = Diagonal(own, inverse_of(all));
}
