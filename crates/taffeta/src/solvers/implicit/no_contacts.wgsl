// The system without contacts of surfaces: each body has its own.

#import solvers/implicit/levels.wgsl

/// What an invocation adds to the sums of one sort over the nodes of a system.
fn sums_of_lane(group: LevelGroup, sort: u32, lane: u32) -> vec4f {
    var own = vec4f(0.0);
    for (var i = lane; i < group.groups; i += 256u) {
        own += product_sums[sort * arrayLength(&level_groups) + group.first_group + i];
    }
    return own;
}

/// What contacts take back of a vector, on a node.
fn taken_by_contacts(_node: u32) -> vec3f {
    return vec3f(0.0);
}
