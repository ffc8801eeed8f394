// The particle stages on a grid, a tile of nodes for each workgroup.

#import contact/collider_mesh/no_mesh.wgsl as meshes
#import contact/colliders/response.wgsl
#import elements/spring/grid.wgsl
#import elements/spring/tiles.wgsl
#import gpu/wgsl/force.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import solvers/explicit/node.wgsl
#import loads
#import memory
#import resolve_contact

@compute @workgroup_size(256)
fn grid_springs_all(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&tiles) {
        return;
    }
    let tile = tiles[index];
    let cell = cell_of(tile, lane);
    if cell.row >= 0 {
        let node = u32(cell.place);
        let springs = grid_springs(cell, position_of(node), velocity_of(node));
        force[node] = vec4f(force[node].xyz + springs, 0.0);
    }
}

@compute @workgroup_size(256)
fn grid_particles(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&tiles) {
        return;
    }
    let tile = tiles[index];
    let cell = cell_of(tile, lane);
    if cell.row >= 0 {
        let node = u32(cell.place);
        let x = old_position[node];
        let v = old_velocity[node];
        let total = load_on(node, v.xyz, 0u) + grid_springs(cell, x.xyz, v.xyz);
        let after = resolve_contact(node, integrate(x, v, total, 0u), Origin(x.xyz, true), 0u);
        new_position[node] = after.position;
        new_velocity[node] = after.velocity;
    }
}
