// The filter: how far each node may go.

#import contact/colliders/met.wgsl
#import contact/colliders/shape.wgsl
#import contact/triangles/most.wgsl
#import contact/triangles/slide.wgsl
#import contact/triangles/surfaces.wgsl
#import contact/triangles/tangle.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl

/// Sets where nodes end, and measures their motion. A later round of the filter begins where the last one ended.
@compute @workgroup_size(256)
fn measure_ways(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let place = node_of(id, lane);
    var found = vec3f(0.0);
    if place < table(ALL_PLACES) && has_surface(place) {
        let is_later = counted(FILTER_ROUND) > 0u;
        let is_node = place < table(NODE_PLACES);
        if is_node && is_later {
            put_place(BEFORE, place, new_position[place].xyz);
        }
        let start = place_at(BEFORE, place);
        let size = abs(start);
        found.z = max(size.x, max(size.y, size.z));
        if is_node {
            let to = select(new_position[place].xyz, place_at(TARGET, place), is_later);
            let way = to - start;
            let change = to - place_at(AFTER, place);
            put_place(AFTER, place, to);
            found.x = dot3(way, way);
            found.y = dot3(change, change);
        }
    }
    let most = most_of_lanes(lane, found);
    if lane == 0u {
        atomicMax(&surface_work[WAY], bitcast<u32>(most.x));
        atomicMax(&surface_work[CHANGE_OF_WAY], bitcast<u32>(most.y));
        atomicMax(&surface_work[FARTHEST_PLACE], bitcast<u32>(most.z));
    }
}

/// Has nodes that go far go a part of their way, and keeps where they would end.
@compute @workgroup_size(256)
fn go_part(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let place = node_of(id, lane);
    if place >= table(NODE_PLACES) || !has_surface(place) {
        return;
    }
    if counted(FILTER_ROUND) == 0u {
        put_place(TARGET, place, new_position[place].xyz);
        put_place(TARGET_VELOCITY, place, new_velocity[place].xyz);
    }
    let start = place_at(BEFORE, place);
    let target_place = place_at(TARGET, place);
    let way = target_place - start;
    let length = norm3(way);
    let most = length_of(LONGEST_WAY);
    let is_far = length > most;
    let to = select(target_place, start + way * (most / select(1.0, length, is_far)), is_far);
    new_position[place] = vec4f(to, new_position[place].w);
    put_place(AFTER, place, to);
}

/// Marks nodes that the filter holds back and did not before, and their leaves.
@compute @workgroup_size(256)
fn mark_held(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let place = node_of(id, lane);
    if place >= table(NODE_PLACES) || !has_surface(place) {
        return;
    }
    let stamp = counted(JAM) + 1u;
    let is_held = counted(limit_at(place)) != UNLIMITED;
    if !is_held || counted(held_at(place)) > counted(FILTER_ROUND) * STAMPS {
        return;
    }
    set_counted(held_at(place), stamp);
    let starts = table(LEAVES_OF_AT) + place;
    for (var i = surface_tables[starts]; i < surface_tables[starts + 1u]; i++) {
        set_counted(mark_at(surface_tables[table(LEAF_ITEMS_AT) + i]), stamp);
    }
    atomicAdd(&surface_work[HELD], 1u);
}

/// Holds back nodes; where nodes go in several rounds, all of them. Who may slide goes on in another round.
@compute @workgroup_size(256)
fn hold_back(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let place = node_of(id, lane);
    var most = vec3f(0.0);
    if place < table(NODE_PLACES) && has_surface(place) {
        let in_rounds = counted(IN_ROUNDS) != 0u;
        let limit = counted(limit_at(place));
        if limit == UNLIMITED && !in_rounds {
            put_place(TARGET, place, new_position[place].xyz);
            put_place(TARGET_VELOCITY, place, new_velocity[place].xyz);
        } else {
            set_counted(limit_at(place), UNLIMITED);
            most = hold_node(place, limit, in_rounds);
        }
    }
    most = most_of_lanes(lane, most);
    if lane == 0u {
        atomicMax(&surface_work[PROGRESS], bitcast<u32>(most.x));
        atomicMax(&surface_work[WAY_TAKEN], bitcast<u32>(most.y));
        atomicMax(&surface_work[MOST_WAY_TAKEN], bitcast<u32>(most.z));
    }
}

/// Has a node go in a round as far as the word that limits it says. Returns how far it came, or will come along a plane, if that is a
/// reason for another round; what is left of its way, and what no round gives back; squared [m²].
fn hold_node(place: u32, limit: u32, in_rounds: bool) -> vec3f {
    let start = place_at(BEFORE, place);
    let wanted = new_position[place].xyz;
    let is_held = limit != UNLIMITED;
    let to = select(wanted, start + (wanted - start) * part_of_way(limit), is_held);
    let goal = select(wanted, place_at(TARGET, place), in_rounds);
    let speed = select(new_velocity[place].xyz, place_at(TARGET_VELOCITY, place), in_rounds);
    let arrives = in_rounds && all(to == goal);
    // Who is held goes where its pin goes, however short the steps are.
    let is_free = new_position[place].w > 0.0;
    let left = wanted - to;
    let lift = select(vec3f(0.0), lift_of(left, limit), is_held && is_free && !arrives);
    let slides = any(lift != vec3f(0.0));
    var new_goal = goal;
    if slides {
        new_goal = out_of_solids(place, goal + lift, norm3(left));
    }
    let at_start = place_at(AT_START, place);
    let h = substeps[0].h;
    new_position[place] = vec4f(to, new_position[place].w);
    new_velocity[place] = vec4f(select((to - at_start) / h, speed, arrives), new_velocity[place].w);
    put_place(TARGET, place, new_goal);
    put_place(TARGET_VELOCITY, place, select(speed, (new_goal - at_start) / h, slides));
    let is_far = bitcast<f32>(counted(WAY)) > length_of(SQUARED_WAY);
    let way = to - start;
    let slid = left + lift;
    let farther = select(0.0, dot3(way, way), is_far && !arrives);
    let along = select(0.0, dot3(slid, slid), slides);
    let rest = new_goal - to;
    return vec3f(max(farther, along), select(0.0, dot3(rest, rest), is_free && !arrives), dot3(lift, lift));
}

/// A position of a node, moved out of the convex colliders that it meets and that are no deeper there than `most` [m]: in what is
/// deeper, it was before. Who is led out of colliders is not thrown out.
fn out_of_solids(place: u32, start: vec3f, most: f32) -> vec3f {
    var x = start;
    let met = met_by(place, 0u);
    let is_led = surface_knots[KNOT_WORDS * place + KNOT_LED] != 0u;
    for (var i = 0u; i < select(met.count, 0u, is_led); i++) {
        let collider = collider_met(met, i);
        if collider.kind != MESH {
            let inside = depth_and_normal(collider, x);
            x = select(x, x + inside.normal * inside.depth, inside.depth > 0.0 && inside.depth <= most);
        }
    }
    return x;
}
