// The forces on nodes that pins hold: reactions are made of them.

#import gpu/wgsl/force.wgsl
#import gpu/wgsl/index.wgsl

@group(1) @binding(60) var<storage, read> held_nodes: array<u32>;
/// The force on each of them [N].
@group(3) @binding(60) var<storage, read_write> held_forces: array<vec4f>;

@compute @workgroup_size(256)
fn keep_held_forces(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id) * 256u + lane;
    if index < arrayLength(&held_nodes) {
        held_forces[index] = vec4f(force[held_nodes[index]].xyz, 0.0);
    }
}
