// Wind, drag, point loads, torques and elements, summed up by node.

#import elements/forces.wgsl
#import elements/load/load.wgsl
#import gpu/wgsl/force.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl
#import memory

/// A force on some nodes, or a torque that they share.
struct Load {
    /// Force on each node [N], or unit axis.
    vector: vec3f,
    kind: u32,
    /// A point on the axis [m].
    about: vec3f,
    /// Moment [N·m].
    torque: f32,
    /// Where its nodes begin, and how many it has.
    first: u32,
    count: u32,
    /// What the vector, or each node's lever [N/m], is multiplied by in this sub-step.
    factor: f32,
}

const FORCE: u32 = 0u;
const TORQUE: u32 = 1u;

@group(0) @binding(2) var<storage, read> scales: array<f32>;
@group(1) @binding(5) var<storage, read> load_nodes: array<u32>;
@group(3) @binding(2) var<storage, read_write> loads: array<Load>;

var<workgroup> lane_sums: array<f32, 256>;

/// A workgroup for each load: what its vector or its levers are multiplied by.
@compute @workgroup_size(256)
fn scale_loads(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&loads) {
        return;
    }
    let scale = scales[substeps[0].first_scale + index];
    var sum = 0.0;
    if loads[index].kind == TORQUE {
        for (var i = lane; i < loads[index].count; i += 256u) {
            let x = position_of(load_nodes[loads[index].first + i]);
            let arm = lever(x, loads[index].vector, loads[index].about);
            sum += dot3(arm, arm);
        }
    }
    lane_sums[lane] = sum;
    for (var half = 128u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            lane_sums[lane] += lane_sums[lane + half];
        }
    }
    if lane == 0u {
        let torque = loads[index].torque * scale;
        loads[index].factor = select(scale, torque_factor(torque, lane_sums[0]), loads[index].kind == TORQUE);
    }
}

/// For each place, where its row in `node_elements` begins; one more than there are places.
@group(1) @binding(6) var<storage, read> node_starts: array<u32>;
/// Loads (marked by the highest bit), then where its forces of elements are.
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
fn loads_all(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let node = workgroup_index(id) * 256u + lane;
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
    let of_user = substeps[own()].input_forces;
    for (var i = first_of_input(node, of_user); i < of_user && bitcast<u32>(input_forces[i].w) == node; i++) {
        total += input_forces[i].xyz;
    }
    var of_elements = vec3f(0.0);
    for (; at < end; at++) {
        of_elements += element_forces[node_elements[at]].xyz;
    }
    force[node] = vec4f(total + of_elements, 0.0);
}
