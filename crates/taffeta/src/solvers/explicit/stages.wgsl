// Each particle stage on its own, for the boundary between CPU and GPU and for comparisons.

#import contact/colliders/response.wgsl
#import gpu/wgsl/force.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import solvers/explicit/node.wgsl
#import meshes
#import resolve_contact

@compute @workgroup_size(256)
fn integrate_all(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let node = node_of(id, lane);
    if node < arrayLength(&old_position) {
        let after = integrate(old_position[node], old_velocity[node], force[node].xyz, 0u);
        new_position[node] = after.position;
        new_velocity[node] = after.velocity;
    }
}

@compute @workgroup_size(256)
fn contact_all(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let node = node_of(id, lane);
    if node < arrayLength(&new_position) && !is_led_out(node) {
        let after = resolve_contact(node, Node(new_position[node], new_velocity[node]), Origin(old_position[node].xyz, true), 0u);
        new_position[node] = after.position;
        new_velocity[node] = after.velocity;
    }
}
