// Each particle stage on its own, for the boundary between CPU and GPU and for comparisons.

/// Force on each node [N], in xyz.
@group(3) @binding(1) var<storage, read_write> force: array<vec4f>;

fn node_of(id: vec3u, counts: vec3u, lane: u32) -> u32 {
    return workgroup_index(id, counts) * 256u + lane;
}

@compute @workgroup_size(256)
fn integrate_all(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let node = node_of(id, counts, lane);
    if node < arrayLength(&old_position) {
        let after = integrate(old_position[node], old_velocity[node], force[node].xyz, 0u);
        new_position[node] = after.position;
        new_velocity[node] = after.velocity;
    }
}

@compute @workgroup_size(256)
fn contact_all(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let node = node_of(id, counts, lane);
    if node < arrayLength(&new_position) {
        let after = touch(Node(new_position[node], new_velocity[node]), Origin(old_position[node].xyz, true), 0u);
        new_position[node] = after.position;
        new_velocity[node] = after.velocity;
    }
}
