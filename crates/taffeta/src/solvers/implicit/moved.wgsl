// Nodes as elements reach them that are solved for: where the Newton step starts.

#import solvers/implicit/levels.wgsl

fn position_of(node: u32) -> vec3f {
    return vector_of(DIRECTION, node);
}

fn velocity_of(node: u32) -> vec3f {
    return vector_of(DIRECTION_PRODUCT, node);
}
