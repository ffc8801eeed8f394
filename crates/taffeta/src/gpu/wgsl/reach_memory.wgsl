// Nodes as springs reach them: in memory.

#import gpu/wgsl/state.wgsl

fn position_of(node: u32) -> vec3f {
    return old_position[node].xyz;
}

fn velocity_of(node: u32) -> vec3f {
    return old_velocity[node].xyz;
}
