// Contacts of surfaces as part of the system: what they add to it, and which bodies they join. The bodies that contacts join share one
// system: each takes the sums of all of them.

#import contact/triangles/solved.wgsl
#import contact/triangles/surfaces.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl
#import solvers/implicit/implicit.wgsl
#import solvers/implicit/joined_systems.wgsl
#import solvers/implicit/levels.wgsl

/// By place, which of the systems its body has; NONE without.
@group(1) @binding(49) var<storage, read> systems: array<u32>;

/// Parts systems that were joined.
@compute @workgroup_size(256)
fn part_systems(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let system = node_of(id, lane);
    if system < arrayLength(&joins) {
        atomicStore(&joins[system], system);
    }
}

/// Takes up the contacts that may come about, and joins the bodies between which they are.
@compute @workgroup_size(256)
fn take_contacts(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let number = node_of(id, lane);
    if number >= counted(CONTACTS) {
        return;
    }
    let one = surface_contacts[number];
    var system = NONE;
    var is_part = true;
    for (var corner = 0u; corner < 4u; corner++) {
        let place = one.nodes[corner];
        if one.weights[corner] == 0.0 || place >= table(NODE_PLACES) {
            continue;
        }
        is_part = is_part && systems[place] != NONE;
        system = min(system, systems[place]);
    }
    if is_part && system != NONE {
        for (var corner = 0u; corner < 4u; corner++) {
            let place = one.nodes[corner];
            if one.weights[corner] != 0.0 && place < table(NODE_PLACES) {
                join(system, systems[place]);
            }
        }
    }
    let lead = select(0.0, lead_of(one, substeps[0].h), one.leads != 0u);
    let first = one.force * substeps[0].solving.inner;
    solved_contacts[number] = SolvedContact(
        one.nodes, one.weights, one.normal, one.gap, first, lead, vec3f(0.0), 0.0, vec3f(0.0), 0.0, one.friction, 0.0,
        select(NONE, system, is_part), 0u,
    );
}

/// Notes which systems are joined.
@compute @workgroup_size(256)
fn name_systems(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let system = node_of(id, lane);
    if system < arrayLength(&joins) {
        node_solves[system].first = first_of(system);
    }
}

/// How a place moves in the step, as the Newton step has it [m]; and its velocity there [m/s].
struct Motion {
    way: vec3f,
    velocity: vec3f,
}

fn motion_of_place(place: u32) -> Motion {
    if place < table(NODE_PLACES) {
        return Motion(vector_of(DIRECTION, place) - place_at(AT_START, place), vector_of(DIRECTION_PRODUCT, place));
    }
    // Corners of colliders.
    let way = place_at(TARGET, place) - place_at(BEFORE, place);
    return Motion(way, way / substeps[0].h);
}

/// The inverse mass of a place [1/kg], and the inverse of its diagonal block.
fn inverse_mass_of(place: u32) -> f32 {
    if place >= table(NODE_PLACES) {
        return 0.0;
    }
    return old_position[place].w;
}

/// Whether a collider holds a node: what coarser levels see of a free one is its mass alone.
fn is_held(place: u32) -> bool {
    if place >= table(NODE_PLACES) {
        return false;
    }
    let own = diagonals[place].own;
    return any(own.diagonal != own.diagonal.yzx) || any(own.mixed != vec3f(0.0));
}

fn inverse_block_of(place: u32) -> Symmetric {
    if place >= table(NODE_PLACES) {
        return Symmetric(vec3f(0.0), vec3f(0.0));
    }
    return diagonals[place].inverse;
}

/// Finds the impulses of contacts where a Newton step starts.
@compute @workgroup_size(256)
fn linearise_contacts(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let number = node_of(id, lane);
    if number >= counted(CONTACTS) {
        return;
    }
    var one = solved_contacts[number];
    if one.system == NONE {
        return;
    }
    let solve = node_solves[one.system];
    if solve.is_met != 0u || solve.kept.passes != 0u {
        // Its system takes no further step, or is in the middle of one.
        return;
    }
    let nodes = one.nodes;
    if solve.steps == 0u {
        let inverse_mass = vec4f(
            inverse_mass_of(nodes.x), inverse_mass_of(nodes.y), inverse_mass_of(nodes.z), inverse_mass_of(nodes.w),
        );
        one = stiffened(one, inverse_mass, array<Symmetric, 4>(
            inverse_block_of(nodes.x), inverse_block_of(nodes.y), inverse_block_of(nodes.z), inverse_block_of(nodes.w),
        ), vec4<bool>(is_held(nodes.x), is_held(nodes.y), is_held(nodes.z), is_held(nodes.w)));
    }
    let anchor = motion_of_place(nodes.w);
    let x = motion_of_place(nodes.x);
    let y = motion_of_place(nodes.y);
    let z = motion_of_place(nodes.z);
    let way = (x.way - anchor.way) * one.weights.x + (y.way - anchor.way) * one.weights.y + (z.way - anchor.way) * one.weights.z;
    let velocity = (x.velocity - anchor.velocity) * one.weights.x + (y.velocity - anchor.velocity) * one.weights.y
        + (z.velocity - anchor.velocity) * one.weights.z;
    solved_contacts[number] = linearised(one, one.gap + dot3(way, one.normal), velocity, substeps[0].solving.inner);
}

/// The contacts of a node, whose parts are sorted: where they begin and end.
fn parts_of(node: u32) -> vec2u {
    let count = counted(count_at(node));
    if count == 0u {
        return vec2u(0u);
    }
    let start = counted(list_start_at(node));
    return vec2u(start, start + count);
}

/// Adds contacts to the system that a Newton step has set up on the finest level.
@compute @workgroup_size(256)
fn add_contacts(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) || lane >= level_groups[index].count {
        return;
    }
    let node = level_groups[index].first + lane;
    let range = parts_of(node);
    if range.x == range.y {
        return;
    }
    var impulse = vec3f(0.0);
    var all = diagonals[node];
    for (var i = range.x; i < range.y; i++) {
        let part = counted(sorted_part_at(i));
        let one = solved_contacts[part / 4u];
        if one.system == NONE {
            continue;
        }
        impulse += one.impulse * one.weights[part % 4u];
        all.inverse = softened(one, part % 4u, all.inverse);
        if one.is_held != 0u {
            all.own = with_share(one, part % 4u, all.own);
        }
    }
    diagonals[node] = all;
    put_vector(IMPULSE, node, vector_of(IMPULSE, node) + impulse);
    let right = vectors[vector_at(RESIDUAL, node)];
    vectors[vector_at(RESIDUAL, node)] = vec4f(right.xyz + impulse, right.w);
}

/// A vector at a place; that of colliders is 0.
fn vector_of_place(which: u32, place: u32) -> vec3f {
    if place >= table(NODE_PLACES) {
        return vec3f(0.0);
    }
    return vector_of(which, place);
}

fn taken_of(one: SolvedContact, which: u32) -> vec3f {
    let anchor = vector_of_place(which, one.nodes.w);
    let relative = (vector_of_place(which, one.nodes.x) - anchor) * one.weights.x
        + (vector_of_place(which, one.nodes.y) - anchor) * one.weights.y
        + (vector_of_place(which, one.nodes.z) - anchor) * one.weights.z;
    return taken_back(one, relative);
}

/// Notes what contacts take back of a vector, on a node.
fn multiply(which: u32, node: u32) {
    var sum = vec3f(0.0);
    let range = parts_of(node);
    for (var i = range.x; i < range.y; i++) {
        let part = counted(sorted_part_at(i));
        let one = solved_contacts[part / 4u];
        if one.along > 0.0 {
            sum += taken_of(one, which) * one.weights[part % 4u];
        }
    }
    put_vector(TAKEN, node, sum);
}

/// The product of contacts with the vector on which the cycle works.
@compute @workgroup_size(256)
fn multiply_cycle(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index < arrayLength(&level_groups) && lane < level_groups[index].count
        && node_solves[level_groups[index].solve].next.is_done == 0u {
        multiply(CYCLE, level_groups[index].first + lane);
    }
}

/// The product with what the cycle has found, or at first with the changes to start from.
@compute @workgroup_size(256)
fn multiply_cycled(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index < arrayLength(&level_groups) && lane < level_groups[index].count {
        multiply(CYCLED, level_groups[index].first + lane);
    }
}

/// The product with the changes of the Newton step.
@compute @workgroup_size(256)
fn multiply_change(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index < arrayLength(&level_groups) && lane < level_groups[index].count {
        multiply(CHANGE, level_groups[index].first + lane);
    }
}

/// Notes what impulses have become by the last Newton step.
@compute @workgroup_size(256)
fn apply_contacts(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let number = node_of(id, lane);
    if number >= counted(CONTACTS) {
        return;
    }
    let one = solved_contacts[number];
    if one.system != NONE && node_solves[one.system].is_met == 0u {
        solved_contacts[number].applied = one.impulse - taken_of(one, CHANGE);
    }
}
