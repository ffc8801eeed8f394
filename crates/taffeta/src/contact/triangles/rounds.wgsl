// The rounds in which impulses between surfaces are found, and what is kept of them for the next sub-step.

#import contact/colliders/resolve_contact_again.wgsl
#import contact/triangles/impulse.wgsl
#import contact/triangles/solved.wgsl
#import contact/triangles/surfaces.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl

/// Gives each node in contact room for the list of its parts.
@compute @workgroup_size(256)
fn place_parts(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let number = node_of(id, lane);
    if number < counted(TOUCHED) {
        let node = counted(touched_at(number));
        set_counted(list_start_at(node), atomicAdd(&surface_work[PARTS], counted(count_at(node))));
    }
}

/// Whether a node of a contact has a part in it.
fn takes_part(number: u32, corner: u32) -> bool {
    return surface_contacts[number].weights[corner] != 0.0 && surface_contacts[number].nodes[corner] < table(NODE_PLACES);
}

/// Puts the parts of contacts into the lists of their nodes, in any order.
@compute @workgroup_size(256)
fn fill_parts(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let number = node_of(id, lane);
    if number >= counted(CONTACTS) {
        return;
    }
    for (var corner = 0u; corner < 4u; corner++) {
        if takes_part(number, corner) {
            let node = surface_contacts[number].nodes[corner];
            let at = counted(list_start_at(node)) + atomicAdd(&surface_work[filled_at(node)], 1u);
            set_counted(part_at(at), 4u * number + corner);
        }
    }
}

/// Puts each part where it belongs: behind those of contacts that come before its own.
@compute @workgroup_size(256)
fn sort_parts(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let number = node_of(id, lane);
    if number >= counted(CONTACTS) {
        return;
    }
    let order = surface_contacts[number].order;
    for (var corner = 0u; corner < 4u; corner++) {
        if !takes_part(number, corner) {
            continue;
        }
        let node = surface_contacts[number].nodes[corner];
        let start = counted(list_start_at(node));
        let end = start + counted(count_at(node));
        var rank = start;
        for (var i = start; i < end; i++) {
            let other = surface_contacts[counted(part_at(i)) / 4u].order;
            rank += select(0u, 1u, is_before(other, order));
        }
        set_counted(sorted_part_at(rank), 4u * number + corner);
    }
}

/// The inverse of a contact's part of the mass of one of its nodes [1/kg].
fn inverse_part(node: u32) -> f32 {
    if node >= table(NODE_PLACES) {
        return 0.0;
    }
    return new_position[node].w * f32(counted(count_at(node)));
}

/// Velocity of a place [m/s].
fn velocity_at(place: u32) -> vec3f {
    if place < table(NODE_PLACES) {
        return new_velocity[place].xyz;
    }
    return (place_at(AFTER, place) - place_at(BEFORE, place)) / substeps[0].h;
}

/// How far a collider comes nearer in the sub-step [m].
fn advance_of(one: SurfaceContact) -> f32 {
    var moved = vec3f(0.0);
    for (var i = 0u; i < 4u; i++) {
        let place = one.nodes[i];
        if place >= table(NODE_PLACES) {
            moved += (place_at(AFTER, place) - place_at(BEFORE, place)) * one.weights[i];
        }
    }
    return max(-dot3(one.normal, moved), 0.0);
}

/// Corrects impulses for the velocities that those of the round before gave; the first ones are guesses.
@compute @workgroup_size(256)
fn correct_impulses(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let number = node_of(id, lane);
    if number >= counted(CONTACTS) {
        return;
    }
    let one = surface_contacts[number];
    let nodes = one.nodes;
    let h = substeps[0].h;
    if counted(ROUND) == 0u {
        let inverse = vec4f(inverse_part(nodes.x), inverse_part(nodes.y), inverse_part(nodes.z), inverse_part(nodes.w));
        let mobility = mobility_by(abs(one.weights), inverse);
        surface_contacts[number].mobility = mobility;
        surface_contacts[number].impulse = first_impulse(one);
        surface_contacts[number].push = push_of(one, mobility, h, advance_of(one));
        return;
    }
    let anchor = velocity_at(nodes.w);
    let velocity = (velocity_at(nodes.x) - anchor) * one.weights.x
        + (velocity_at(nodes.y) - anchor) * one.weights.y + (velocity_at(nodes.z) - anchor) * one.weights.z;
    // Bits of positive numbers have the order of the numbers.
    atomicMax(&surface_work[SINKS], bitcast<u32>(max(sinks_by(one, velocity, h), 0.0)));
    surface_contacts[number].impulse = corrected_impulse(one, velocity, h);
}

/// Gives nodes in contact the state that impulses lead to, and keeps them out of colliders again.
@compute @workgroup_size(256)
fn apply_impulses(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let number = node_of(id, lane);
    if number >= counted(TOUCHED) {
        return;
    }
    let node = counted(touched_at(number));
    let start = counted(list_start_at(node));
    let end = start + counted(count_at(node));
    let is_first = counted(ROUND) == 0u;
    var push = select(place_at(PUSH, node), vec3f(0.0), is_first);
    var sum = vec3f(0.0);
    for (var i = start; i < end; i++) {
        let part = counted(sorted_part_at(i));
        let contact = part / 4u;
        let weight = surface_contacts[contact].weights[part % 4u];
        sum += surface_contacts[contact].impulse * weight;
        if is_first {
            push += (surface_contacts[contact].normal * surface_contacts[contact].push) * weight;
        }
    }
    put_place(PUSH, node, push);
    let x = new_position[node];
    let v = new_velocity[node];
    let change = sum * x.w;
    let moved_to = place_at(AFTER, node) + change * substeps[0].h + push * x.w;
    resolve_contact_again(node, x, v, moved_to, place_at(BASE_VELOCITY, node) + change);
}

/// Keeps the forces for the next sub-step. That of a short one counts by its part of the longest.
@compute @workgroup_size(256)
fn note_forces(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let contact = node_of(id, lane);
    if contact >= counted(CONTACTS) {
        return;
    }
    let one = surface_contacts[contact];
    let h = substeps[0].h;
    let longest = substeps[0].longest_step;
    // The quotient may be rounded: what is as long leaves nothing.
    let old = select(0.0, 1.0 - h / longest, h < longest);
    var force = one.force * old + (one.solved + one.impulse) * (1.0 / max(h, longest));
    if table(IS_SOLVED) != 0u {
        force = sustained(force, one.force);
    }
    if any(force != vec3f(0.0)) && one.leads == 0u {
        keep_force(one.order, force, vec3f(0.0), false);
    }
}

fn keep_force(order: vec3u, force: vec3f, solved: vec3f, is_solved: bool) {
    let number = atomicAdd(&surface_work[FORCES], 1u);
    surface_forces[3u * number] = vec4u(order, select(0u, 1u, is_solved));
    surface_forces[3u * number + 1u] = vec4u(bitcast<vec3u>(force), 0u);
    surface_forces[3u * number + 2u] = vec4u(bitcast<vec3u>(solved), 0u);
    let next = atomicExchange(&surface_work[first_force_at(1u - counted(IS_ODD), bucket_of(order))], number);
    set_counted(next_force_at(number), next);
}

/// Keeps the impulses that the solver has found, for the rounds after it.
@compute @workgroup_size(256)
fn keep_solved(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let contact = node_of(id, lane);
    if contact >= counted(CONTACTS) || surface_contacts[contact].leads != 0u {
        return;
    }
    let force = surface_contacts[contact].force;
    let is_solved = solved_contacts[contact].system != NONE;
    let solved = select(vec3f(0.0), solved_contacts[contact].applied, is_solved);
    if any(select(force, solved, is_solved) != vec3f(0.0)) {
        keep_force(surface_contacts[contact].order, force, solved, is_solved);
    }
}
