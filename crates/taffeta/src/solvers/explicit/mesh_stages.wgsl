// The particle stages on meshes, 256 neighbouring places for each workgroup.

/// In a run's count: the slice belongs to a grid.
const NOT_A_MESH: u32 = 0xffffffffu;

/// In a run's count: its entries are a ring of a body that keeps its volume, which has kernels of its own. A grid's count
/// has this bit as well.
const IS_RING: u32 = 0x80000000u;

/// Whether a place belongs to a mesh.
fn is_of_mesh(node: u32) -> bool {
    return node < arrayLength(&old_position) && runs[node / LANES * KINDS].count != NOT_A_MESH;
}

/// Whether it belongs to a mesh that keeps no volume.
fn is_of_free_mesh(node: u32) -> bool {
    return node < arrayLength(&old_position) && (runs[node / LANES * KINDS].count & IS_RING) == 0u;
}

@compute @workgroup_size(256)
fn mesh_springs_all(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let node = node_of(id, counts, lane);
    if is_of_free_mesh(node) {
        let total = add_mesh_springs(force[node].xyz, node, position_of(node), velocity_of(node));
        force[node] = vec4f(total, 0.0);
    }
}

@compute @workgroup_size(256)
fn mesh_particles(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let node = node_of(id, counts, lane);
    if is_of_free_mesh(node) {
        let x = old_position[node];
        let v = old_velocity[node];
        let total = add_mesh_springs(load_on(node, v.xyz, 0u), node, x.xyz, v.xyz);
        let after = touch(integrate(x, v, total, 0u), Origin(x.xyz, true), 0u);
        new_position[node] = after.position;
        new_velocity[node] = after.velocity;
    }
}
