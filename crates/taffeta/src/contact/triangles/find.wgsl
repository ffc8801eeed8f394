// Which triangles may come near each other, and which of their vertices and edges are in contact.

#import contact/triangles/add.wgsl
#import contact/triangles/closest.wgsl
#import contact/triangles/cones.wgsl
#import contact/triangles/filter.wgsl
#import contact/triangles/impulse.wgsl
#import contact/triangles/leaf_pairs.wgsl
#import contact/triangles/slide.wgsl
#import contact/triangles/surfaces.wgsl
#import contact/triangles/tangle.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl

/// Keeps where nodes are where the sub-step begins.
@compute @workgroup_size(256)
fn keep_places(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let place = node_of(id, lane);
    if place < table(NODE_PLACES) {
        put_place(AT_START, place, old_position[place].xyz);
    }
}

/// Empties lists, each invocation what has its number; then pairs of this kind are listed.
fn empty_lists(number: u32, kind: u32) {
    if number == 0u {
        for (var word = 0u; word < SHORT; word++) {
            if word != FORCES && word != IS_ODD {
                set_counted(word, 0u);
            }
        }
        set_counted(NEAREST, bitcast<u32>(FAR));
        set_counted(LISTED, kind);
    }
    if number < table(NODE_PLACES) {
        set_counted(count_at(number), 0u);
        set_counted(filled_at(number), 0u);
        set_counted(limit_at(number), UNLIMITED);
        set_counted(held_at(number), 0u);
    }
    if number < table(LEAF_COUNT) {
        set_counted(mark_at(number), 0u);
    }
    if number < table(BUCKETS) {
        set_counted(first_force_at(1u - counted(IS_ODD), number), NONE);
    }
}

/// Where the corners of colliders are at the start of the sub-step, and then at its end; NONE if none ever moves, or a place has none.
fn corner_ends(number: u32) -> vec2u {
    let corners = table(ALL_PLACES) - table(NODE_PLACES);
    let first = substeps[own()].first_corner;
    if first == NONE || number < table(NODE_PLACES) || number >= table(ALL_PLACES) {
        return vec2u(NONE);
    }
    let at = first + number - table(NODE_PLACES);
    return vec2u(at, at + corners);
}

/// Takes up the state after the sub-step without contact, and where corners of colliders go.
@compute @workgroup_size(256)
fn take_places(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let number = node_of(id, lane);
    empty_lists(number, NEAR);
    if number < table(NODE_PLACES) {
        put_place(BEFORE, number, place_at(AT_START, number));
        put_place(AFTER, number, new_position[number].xyz);
        put_place(BASE_VELOCITY, number, new_velocity[number].xyz);
    }
    let ends = corner_ends(number);
    if ends.x != NONE {
        put_place(BEFORE, number, surface_corners[ends.x].xyz);
        put_place(AFTER, number, surface_corners[ends.y].xyz);
    }
}

/// Takes up the state before the sub-step, where contacts are looked for that the solver is to know of.
@compute @workgroup_size(256)
fn take_start(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let number = node_of(id, lane);
    empty_lists(number, SOLVED);
    if number < table(NODE_PLACES) {
        put_place(BEFORE, number, place_at(AT_START, number));
        put_place(AFTER, number, place_at(AT_START, number));
    } else if number < table(ALL_PLACES) {
        let ends = corner_ends(number);
        if ends.x != NONE {
            put_place(BEFORE, number, surface_corners[ends.x].xyz);
        }
        let start = place_at(BEFORE, number);
        put_place(AFTER, number, start);
        put_place(TARGET, number, start);
        if ends.x != NONE {
            put_place(TARGET, number, surface_corners[ends.y].xyz);
        }
    }
}

/// The box around the places of a leaf before, and around their motion.
@compute @workgroup_size(256)
fn bound_leaves(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let leaf = node_of(id, lane);
    if leaf >= table(LEAF_COUNT) {
        return;
    }
    var low = vec3f(FAR);
    var high = vec3f(-FAR);
    var least = vec3f(FAR);
    var most = vec3f(-FAR);
    for (var i = 0u; i < leaf_word(leaf, LEAF_NODES); i++) {
        let node = leaf_word(leaf, i);
        let x = place_at(BEFORE, node);
        let way = place_at(AFTER, node) - x;
        low = min(low, x);
        high = max(high, x);
        least = min(least, way);
        most = max(most, way);
    }
    put_box(leaf, low, high, least, most);
}

fn put_box(number: u32, low: vec3f, high: vec3f, least: vec3f, most: vec3f) {
    surface_boxes[4u * number] = vec4f(low, 0.0);
    surface_boxes[4u * number + 1u] = vec4f(high, 0.0);
    surface_boxes[4u * number + 2u] = vec4f(least, 0.0);
    surface_boxes[4u * number + 3u] = vec4f(most, 0.0);
}

/// The boxes of a level, each around up to sixteen of the level below.
@compute @workgroup_size(256)
fn bound_level(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let level = surface_part[0];
    let number = node_of(id, lane);
    if number >= table(LEVEL_BOXES + 2u * level + 1u) {
        return;
    }
    let below = table(LEVEL_BOXES + 2u * level - 2u);
    let first = number * LEAF_GROUP;
    let end = min(first + LEAF_GROUP, table(LEVEL_BOXES + 2u * level - 1u));
    var low = vec3f(FAR);
    var high = vec3f(-FAR);
    var least = vec3f(FAR);
    var most = vec3f(-FAR);
    for (var i = first; i < end; i++) {
        let at = 4u * (below + i);
        low = min(low, surface_boxes[at].xyz);
        high = max(high, surface_boxes[at + 1u].xyz);
        least = min(least, surface_boxes[at + 2u].xyz);
        most = max(most, surface_boxes[at + 3u].xyz);
    }
    put_box(table(LEVEL_BOXES + 2u * level) + number, low, high, least, most);
}

/// What a contact had before: the force in the last sub-step [N], and the impulse that the solver has given it in this one [N·s], if
/// it has.
struct LastForce {
    force: vec3f,
    solved: vec3f,
    is_solved: bool,
}

fn last_force(order: vec3u) -> LastForce {
    var number = counted(first_force_at(counted(IS_ODD), bucket_of(order)));
    while number != NONE {
        let record = surface_forces[3u * number];
        if all(record.xyz == order) {
            let force = bitcast<vec3f>(surface_forces[3u * number + 1u].xyz);
            return LastForce(force, bitcast<vec3f>(surface_forces[3u * number + 2u].xyz), record.w != 0u);
        }
        number = counted(next_force_at(number));
    }
    return LastForce(vec3f(0.0), vec3f(0.0), false);
}

/// The contacts of two leaves.
@compute @workgroup_size(64)
fn find_surface_contacts(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let leaves = load_leaves(id, lane);
    let pair = leaves.pair;
    let for_solver = counted(LISTED) == SOLVED;
    let within = select(1.0, NEARBY, for_solver);
    for (var number = lane; number < leaves.count; number += LEAF_LANES) {
        let one = candidate(number, leaves.counts);
        if !matters(one, pair) {
            continue;
        }
        let rule = rule_of(nodes_of(one.lanes), one.first);
        let order = vec3u(pair.xy, one.order);
        if rule == APART && gives_way(one) {
            add_contact(one, order, leaves.material, pair.z > 0u, within);
        } else if rule != APART && rule != IGNORED && (for_solver || table(IS_SOLVED) == 0u) {
            // In an implicit step the solver leads back what passes through a surface.
            lead_back(one, order, thickness_of(one, leaves.material.x, pair.z > 0u), rule == ABOVE, within);
        }
    }
}

/// Adds a pair to the contacts, if it would end as near as is asked, relative to its thickness. One that carried a force remains one a
/// little longer.
fn add_contact(one: Candidate, order: vec3u, material: vec2f, has_ring: bool, within: f32) {
    let x = four_before(one.lanes);
    let found = closest_of(relative_to_last(x, length_of(ZERO)), one.first);
    let distance = norm3(found.apart);
    let ends = relative_to_last(four_after(one.lanes), length_of(ZERO));
    let then = ends[0] * found.weights.x + ends[1] * found.weights.y + ends[2] * found.weights.z;
    let along = dot3(then, found.apart * (1.0 / select(1.0, distance, distance > TINY)));
    let thickness = thickness_of(one, material.x, has_ring);
    if !(along < max(within, KEEPS) * thickness && distance > 0.0) {
        return;
    }
    let last = last_force(order);
    let is_new = all(last.force == vec3f(0.0)) && !last.is_solved;
    if is_new && !(along < within * thickness) {
        return;
    }
    if !is_in_cones(nodes_of(one.lanes), one.first, found, !is_new) {
        return;
    }
    let normal = found.apart / distance;
    let grip = select(0.0, grip_of(last.solved, normal, material.y), last.is_solved);
    // What the solver has given is there already.
    let impulse = last.force * select(substeps[0].h, 0.0, last.is_solved);
    put_contact(SurfaceContact(
        nodes_of(one.lanes), found.weights, normal, distance - thickness, impulse, 0.0, last.force, thickness, order, material.y,
        last.solved, 0.0, 0u, grip,
    ));
}

/// Adds a vertex on the wrong side of a triangle, or just back, as a contact that leads it to the side where it belongs.
fn lead_back(one: Candidate, order: vec3u, thickness: f32, above: bool, within: f32) {
    let x = four_before(one.lanes);
    let found = closest_of(relative_to_last(x, length_of(ZERO)), one.first);
    let normal = cross3(x[2] - x[1], x[3] - x[1]);
    let length = norm3(normal);
    if !(norm3(found.apart) < max(within, KEEPS) * thickness) || length <= TINY {
        return;
    }
    let towards = normal * (select(-1.0, 1.0, above) / length);
    let gap = dot3(towards, x[0] - x[1]) - thickness;
    add_lead(nodes_of(one.lanes), found.weights, towards, vec2f(gap, thickness), order);
}

/// The limits of the nodes of all pairs of two leaves: of those that come near each other, if all nodes go all their way; of those
/// around nodes that are held back, by planes that stand still.
@compute @workgroup_size(64)
fn limit_ways(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let leaves = load_leaves(id, lane);
    let pair = leaves.pair;
    let kind = counted(LISTED);
    let far = bitcast<f32>(counted(FARTHEST_PLACE));
    for (var number = lane; number < leaves.count; number += LEAF_LANES) {
        let one = candidate(number, leaves.counts);
        let nodes = nodes_of(one.lanes);
        if !matters(one, pair) || (kind == AROUND && !any_held(nodes)) || rule_of(nodes, one.first) != APART {
            continue;
        }
        let thickness = thickness_of(one, leaves.material.x, pair.z > 0u);
        limit_nodes(one, nodes, four_before(one.lanes), thickness, far, kind == NEAR);
    }
}

/// Whether all nodes of a pair are pinned, and have kept their distances of the start before and after: pins move them as one, and none
/// of them lags.
fn are_pinned_as_one(nodes: vec4u, before: array<vec3f, 4>, after: array<vec3f, 4>) -> bool {
    for (var i = 0u; i < 4u; i++) {
        if nodes[i] >= table(NODE_PLACES) || new_position[nodes[i]].w > 0.0 {
            return false;
        }
    }
    let starts = starts_of(nodes);
    return keeps_shape(starts, before) && keeps_shape(starts, after);
}

/// Whether a node was held back in the last round of jams.
fn any_held(nodes: vec4u) -> bool {
    var any = false;
    for (var i = 0u; i < 4u; i++) {
        any = any || (nodes[i] < table(NODE_PLACES) && counted(held_at(nodes[i])) == counted(JAM));
    }
    return any;
}

fn limit_nodes(one: Candidate, nodes: vec4u, x: array<vec3f, 4>, thickness: f32, far: f32, together: bool) {
    let ends = four_after(one.lanes);
    let moves = array<vec3f, 4>(ends[0] - x[0], ends[1] - x[1], ends[2] - x[2], ends[3] - x[3]);
    let start = relative_to_last(x, length_of(ZERO));
    let apart = closest_of(start, one.first).apart;
    let parts = limits_of(start, moves, one.first, apart, thickness, far, together);
    if all(parts >= vec4f(1.0)) || together && are_pinned_as_one(nodes, x, ends) {
        return;
    }
    for (var i = 0u; i < 4u; i++) {
        if parts[i] < 1.0 && nodes[i] < table(NODE_PLACES) {
            atomicMin(&surface_work[limit_at(nodes[i])], limit_word(parts[i], select(-apart, apart, i < one.first)));
        }
    }
}
