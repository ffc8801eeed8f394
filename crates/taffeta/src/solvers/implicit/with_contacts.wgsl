// The system with contacts of surfaces, which join bodies (contacts.wgsl).

#import solvers/implicit/levels.wgsl

/// What an invocation adds to the sums of one sort over the nodes of all systems that are joined with one.
fn sums_of_lane(group: LevelGroup, sort: u32, lane: u32) -> vec4f {
    let first = node_solves[group.solve].first;
    var own = vec4f(0.0);
    for (var i = lane; i < arrayLength(&level_groups); i += 256u) {
        if node_solves[level_groups[i].solve].first == first {
            own += product_sums[sort * arrayLength(&level_groups) + i];
        }
    }
    return own;
}

/// What contacts take back of a vector, on a node: that which was multiplied last.
fn taken_by_contacts(node: u32) -> vec3f {
    return vector_of(TAKEN, node);
}
