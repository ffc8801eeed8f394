// The kernels of self-collision. They read the state after the sub-step, and the last one writes over the state
// before it.

#import contact/collider_mesh/no_mesh.wgsl as meshes
#import contact/colliders/shape.wgsl
#import contact/colliders/resolve_contact_again.wgsl
#import contact/nodes/cells.wgsl
#import contact/nodes/pair.wgsl
#import contact/nodes/broad_phase.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl
#import memory

/// Empties all buckets.
@compute @workgroup_size(256)
fn clear_cells(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let bucket = node_of(id, lane);
    if bucket < buckets_in(arrayLength(&contact_work)) {
        contact_work[bucket] = NONE;
    }
}

/// Inserts each node into the list of its bucket. A NaN is in no list.
@compute @workgroup_size(256)
fn fill_cells(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let node = node_of(id, lane);
    if node >= arrayLength(&old_position) {
        return;
    }
    let number = surface_number(node);
    let x = position_of(node);
    if number == NONE || are_odd(x) {
        return;
    }
    let buckets = buckets_in(arrayLength(&cell_links));
    let cell = cell_at(x, surfaces[number].cells_a_metre);
    let bucket = (row_of_cells(cell.y, cell.z) + bitcast<u32>(cell.x)) & (buckets - 1u);
    let next = atomicExchange(&cell_links[bucket], node);
    atomicStore(&cell_links[buckets + node], next);
}

/// Counts the contacts of each place, and finds the nearest.
@compute @workgroup_size(256)
fn find_self_contacts(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let places = arrayLength(&old_position);
    let node = node_of(id, lane);
    if node >= places {
        return;
    }
    let number = surface_number(node);
    let x = position_of(node);
    var count = 0u;
    var nearest = FAR;
    var least = select(0u, NONE, number == NONE || are_odd(x));
    while least != NONE {
        let some = neighbours_from(node, number, x, least);
        for (var i = 0u; i < 16u && number_in(some, i) != NONE; i++) {
            let other = number_in(some, i);
            if !may_collide(node, number, other) {
                continue;
            }
            let d = x - position_of(other);
            let reach = contact_distance(surfaces[number], surfaces[surface_number(other)]);
            let fraction = dot3(d, d) / (reach * reach);
            nearest = select(nearest, fraction, fraction < nearest);
            count++;
        }
        least = select(some.d.w + 1u, NONE, some.d.w == NONE);
    }
    let buckets = buckets_in(arrayLength(&contact_work));
    contact_work[buckets + places + node] = count;
    contact_work[buckets + 2u * places + node] = bitcast<u32>(nearest);
}

/// The response of a node to another one in contact.
fn response_from(node: u32, number: u32, other: u32) -> Exchange {
    let a = min(node, other);
    let b = max(node, other);
    let material = combine_materials(surfaces[number].material, surfaces[surface_number(other)].material);
    let mobility =
        mobility_of(vec2f(old_position[a].w, old_position[b].w), vec2u(contacts_of(a), contacts_of(b)));
    let done = exchange(
        position_of(a) - position_of(b), velocity_of(a) - velocity_of(b), mobility, material,
        substeps[0].h, substeps[0].max_separation,
    );
    let sign = select(-1.0, 1.0, node == a);
    return Exchange(done.impulse * sign, done.shift * sign);
}

/// Gives nodes in contact their new velocities and positions, and keeps them out of colliders again. The others do
/// not change.
@compute @workgroup_size(256)
fn resolve_self_contacts(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let node = node_of(id, lane);
    if node >= arrayLength(&old_position) {
        return;
    }
    let x = old_position[node];
    let v = old_velocity[node];
    if contacts_of(node) == 0u {
        new_position[node] = x;
        new_velocity[node] = v;
        return;
    }
    let number = surface_number(node);
    var sum = Exchange(vec3f(0.0), vec3f(0.0));
    var least = 0u;
    while least != NONE {
        let some = neighbours_from(node, number, x.xyz, least);
        for (var i = 0u; i < 16u && number_in(some, i) != NONE; i++) {
            let other = number_in(some, i);
            if may_collide(node, number, other) {
                let one = response_from(node, number, other);
                sum = Exchange(sum.impulse + one.impulse, sum.shift + one.shift);
            }
        }
        least = select(some.d.w + 1u, NONE, some.d.w == NONE);
    }
    resolve_contact_again(node, x, v, x.xyz + sum.shift * x.w, v.xyz + sum.impulse * x.w);
}

/// For each workgroup over nodes: contacts, and the least squared distance relative to the thickness, as bits.
@group(3) @binding(19) var<storage, read_write> contact_sums: array<vec2u>;

var<workgroup> contact_lanes: array<vec2u, 256>;

@compute @workgroup_size(256)
fn measure_self_contacts(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let places = arrayLength(&old_position);
    let first = buckets_in(arrayLength(&contact_work)) + places;
    // Bits of positive numbers have the order of the numbers.
    var found = vec2u(0u, bitcast<u32>(FAR));
    for (var node = id.x * 256u + lane; node < places; node += counts.x * 256u) {
        found = vec2u(found.x + contact_work[first + node], min(found.y, contact_work[first + places + node]));
    }
    contact_lanes[lane] = found;
    for (var half = 128u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            let other = contact_lanes[lane + half];
            contact_lanes[lane] = vec2u(contact_lanes[lane].x + other.x, min(contact_lanes[lane].y, other.y));
        }
    }
    if lane == 0u {
        contact_sums[id.x] = contact_lanes[0];
    }
}
