// Colliders that move: what is in their way goes along, before nodes go where they would end.

#import contact/triangles/closest.wgsl
#import contact/triangles/filter.wgsl
#import contact/triangles/leaf_pairs.wgsl
#import contact/triangles/most.wgsl
#import contact/triangles/surfaces.wgsl
#import contact/triangles/tangle.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl

/// Measures how far from the origin places are.
@compute @workgroup_size(256)
fn measure_places(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let place = node_of(id, lane);
    var far = 0.0;
    if place < table(ALL_PLACES) && has_surface(place) {
        let size = abs(place_at(BEFORE, place));
        far = max(size.x, max(size.y, size.z));
    }
    let most = most_of_lanes(lane, vec3f(far, 0.0, 0.0));
    if lane == 0u {
        atomicMax(&surface_work[FARTHEST_PLACE], bitcast<u32>(most.x));
    }
}

/// Sets corners of colliders where they are at both ends of a part of their motion. Nodes are at rest where they have been pushed.
@compute @workgroup_size(256)
fn advance_corners(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let place = node_of(id, lane);
    if place >= table(ALL_PLACES) || !has_surface(place) {
        return;
    }
    let part = counted(CORNER_PART) - 1u;
    let parts = substeps[own()].corner_parts;
    if place < table(NODE_PLACES) {
        let x = place_at(select(AFTER, BEFORE, part == 0u), place);
        put_place(BEFORE, place, x);
        put_place(AFTER, place, x);
        put_place(TARGET, place, vec3f(0.0));
        for (var axis = 0u; axis < 3u; axis++) {
            set_counted(push_at(axis, place), 0u);
        }
        return;
    }
    let corner = place - table(NODE_PLACES);
    let first = substeps[own()].first_corner;
    let start = surface_corners[first + corner].xyz;
    let end = surface_corners[first + table(ALL_PLACES) - table(NODE_PLACES) + corner].xyz;
    let way = end - start;
    let ends = vec2f(f32(part), f32(part + 1u)) / f32(parts);
    put_place(BEFORE, place, select(end, start + way * ends.x, part < parts));
    put_place(AFTER, place, select(end, start + way * ends.y, part + 1u < parts));
}

/// A component of a push as a number that is larger for a longer way, and for one towards + of two that are as long.
fn push_key(way: f32) -> u32 {
    return (bitcast<u32>(abs(way)) << 1u) | select(0u, 1u, way > 0.0);
}

fn way_of(key: u32) -> f32 {
    let length = bitcast<f32>(key >> 1u);
    return select(-length, length, (key & 1u) == 1u);
}

/// Pushes the nodes of all pairs of two leaves that would come too near: those of the side that the other drives. Or has nodes of pairs
/// without a collider stop.
@compute @workgroup_size(64)
fn push_nodes(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let leaves = load_leaves(id, lane);
    let pair = leaves.pair;
    let count = select(leaves.count, 0u, counted(PUSH_PHASE) == PHASE_RESTART);
    for (var number = lane; number < count; number += LEAF_LANES) {
        let one = candidate(number, leaves.counts);
        if matters(one, pair) && rule_of(nodes_of(one.lanes), one.first) == APART {
            push_pair(one, thickness_of(one, leaves.material.x, pair.z > 0u));
        }
    }
}

fn push_pair(one: Candidate, thickness: f32) {
    let x = four_before(one.lanes);
    let ends = four_after(one.lanes);
    let moves = array<vec3f, 4>(ends[0] - x[0], ends[1] - x[1], ends[2] - x[2], ends[3] - x[3]);
    let start = relative_to_last(x, length_of(ZERO));
    let found = closest_of(start, one.first);
    if counted(PUSH_PHASE) == PHASE_STOP {
        stop_sides(one, start, moves, found.apart, thickness);
    } else if any(max(max(abs(moves[0]), abs(moves[1])), max(abs(moves[2]), abs(moves[3]))) != vec3f(0.0)) {
        push_side(one, start, moves, found, thickness);
    }
}

fn push_side(one: Candidate, start: array<vec3f, 4>, moves: array<vec3f, 4>, found: Closest, thickness: f32) {
    let far = bitcast<f32>(counted(FARTHEST_PLACE));
    let squeezed = counted(PUSH_PHASE) == PHASE_SQUEEZE;
    let push = push_apart(start, moves, one.first, found.apart, thickness, far, squeezed);
    if all(push == vec3f(0.0)) {
        return;
    }
    var of_first = vec3f(0.0);
    var of_second = vec3f(0.0);
    for (var i = 0u; i < 4u; i++) {
        if i < one.first {
            of_first += moves[i] * found.weights[i];
        } else {
            of_second += moves[i] * -found.weights[i];
        }
    }
    let nodes = nodes_of(one.lanes);
    // A collider always does.
    let first_drives = nodes[0] >= table(NODE_PLACES)
        || nodes[3] < table(NODE_PLACES) && -dot3(of_first, found.apart) > dot3(of_second, found.apart);
    var last = 0u;
    var is_pinned = false;
    for (var i = 0u; i < 4u; i++) {
        if (i < one.first) == first_drives {
            continue;
        }
        last = max(last, nodes[i]);
        if new_position[nodes[i]].w > 0.0 {
            push_node(nodes[i], select(push, -push, first_drives));
        } else {
            is_pinned = true;
        }
    }
    if !is_pinned {
        atomicMax(&surface_work[WAITING], last + 1u);
    }
}

/// Notes the part of its way that a node may make as a number that is larger for a smaller one, in place of a push along x.
fn stop_sides(one: Candidate, start: array<vec3f, 4>, moves: array<vec3f, 4>, apart: vec3f, thickness: f32) {
    let nodes = nodes_of(one.lanes);
    if max(max(nodes[0], nodes[1]), max(nodes[2], nodes[3])) >= table(NODE_PLACES) {
        return;
    }
    let far = bitcast<f32>(counted(FARTHEST_PLACE));
    // In the last round all stop that might meet.
    let together = counted(PUSH_ROUND) + 1u < PUSHES;
    let parts = limits_of(start, moves, one.first, apart, thickness, far, together);
    for (var i = 0u; i < 4u; i++) {
        if parts[i] < 1.0 {
            atomicMax(&surface_work[push_at(0u, nodes[i])], bitcast<u32>(1.0) - bitcast<u32>(parts[i]));
        }
    }
}

fn push_node(node: u32, push: vec3f) {
    for (var axis = 0u; axis < 3u; axis++) {
        atomicMax(&surface_work[push_at(axis, node)], push_key(push[axis]));
    }
}

/// Has nodes go on along each axis by the most that was sent to them; or puts them back, or has them stop.
@compute @workgroup_size(256)
fn take_pushes(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let place = node_of(id, lane);
    if place >= table(NODE_PLACES) || !has_surface(place) {
        return;
    }
    let sent = vec3u(counted(push_at(0u, place)), counted(push_at(1u, place)), counted(push_at(2u, place)));
    for (var axis = 0u; axis < 3u; axis++) {
        set_counted(push_at(axis, place), 0u);
    }
    let way = place_at(TARGET, place);
    let phase = counted(PUSH_PHASE);
    var new_way = vec3f(0.0);
    if phase == PHASE_STOP {
        new_way = way * bitcast<f32>(bitcast<u32>(1.0) - sent.x);
        if sent.x != 0u {
            set_counted(PUSHED, 1u);
        }
    } else if phase != PHASE_RESTART {
        let push = vec3f(way_of(sent.x), way_of(sent.y), way_of(sent.z));
        let most = vec3f(substeps[own()].longest_push);
        new_way = max(min(way + push, most), -most);
        if any(new_way != way) {
            set_counted(PUSHED, 1u);
        }
    }
    put_place(TARGET, place, new_way);
    put_place(AFTER, place, place_at(BEFORE, place) + new_way);
}
