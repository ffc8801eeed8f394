// Numbers of workgroups, places and nodes.

/// No number.
const NONE: u32 = 0xffffffffu;
/// Places of a slice, whose lists lie side by side.
const LANES: u32 = 16u;

/// Workgroups are counted along x, then y: one dimension alone may be too short.
fn workgroup_index(id: vec3u, counts: vec3u) -> u32 {
    return id.x + id.y * counts.x;
}

/// The place of an invocation.
fn node_of(id: vec3u, counts: vec3u, lane: u32) -> u32 {
    return workgroup_index(id, counts) * 256u + lane;
}
