// The particle stages on meshes, 256 neighbouring places for each workgroup.

#import contact/collider_mesh/no_mesh.wgsl as meshes
#import contact/colliders/response.wgsl
#import elements/spring/mesh.wgsl
#import elements/spring/places.wgsl
#import gpu/wgsl/force.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import solvers/explicit/node.wgsl
#import loads
#import memory
#import resolve_contact

@compute @workgroup_size(256)
fn mesh_springs_all(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let node = node_of(id, lane);
    if is_of_free_mesh(node) {
        let total = add_mesh_springs(force[node].xyz, node, position_of(node), velocity_of(node));
        force[node] = vec4f(total, 0.0);
    }
}

@compute @workgroup_size(256)
fn mesh_particles(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let node = node_of(id, lane);
    if is_of_free_mesh(node) {
        let x = old_position[node];
        let v = old_velocity[node];
        let total = add_mesh_springs(load_on(node, v.xyz, 0u), node, x.xyz, v.xyz);
        let after = resolve_contact(node, integrate(x, v, total, 0u), Origin(x.xyz, true), 0u);
        new_position[node] = after.position;
        new_velocity[node] = after.velocity;
    }
}
