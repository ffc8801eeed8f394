// Wind, drag, point loads, torques, hinges and panels, summed up by node.

/// For each place, where its row in `node_elements` begins; one more than there are places.
@group(1) @binding(6) var<storage, read> node_starts: array<u32>;
/// Loads (marked by the highest bit), then where forces of elements are: corners of hinges, 4·hinge + corner, then panels.
@group(1) @binding(7) var<storage, read> node_elements: array<u32>;
/// Forces by the program [N] in xyz, the node's number in w; nodes ascend.
@group(0) @binding(3) var<storage, read> input_forces: array<vec4f>;

const IS_LOAD: u32 = 0x80000000u;

/// The first of the program's forces on a node, or on one after it.
fn first_of_input(node: u32, count: u32) -> u32 {
    var low = 0u;
    var high = count;
    while low < high {
        let middle = (low + high) / 2u;
        if bitcast<u32>(input_forces[middle].w) < node {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

fn load_force(index: u32, x: vec3f) -> vec3f {
    let load = loads[index];
    if load.kind == TORQUE {
        return lever(x, load.vector, load.about) * load.factor;
    }
    return load.vector * load.factor;
}

@compute @workgroup_size(256)
fn loads_all(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let node = workgroup_index(id, counts) * 256u + lane;
    if node >= arrayLength(&old_position) {
        return;
    }
    let x = position_of(node);
    var total = wind_and_drag(substeps[0].wind, substeps[0].drag, velocity_of(node));
    var at = node_starts[node];
    let end = node_starts[node + 1u];
    for (; at < end && (node_elements[at] & IS_LOAD) != 0u; at++) {
        total += load_force(node_elements[at] & ~IS_LOAD, x);
    }
    let of_user = substeps[0].input_forces;
    for (var i = first_of_input(node, of_user); i < of_user && bitcast<u32>(input_forces[i].w) == node; i++) {
        total += input_forces[i].xyz;
    }
    var of_elements = vec3f(0.0);
    for (; at < end; at++) {
        of_elements += element_forces[node_elements[at]].xyz;
    }
    force[node] = vec4f(total + of_elements, 0.0);
}
