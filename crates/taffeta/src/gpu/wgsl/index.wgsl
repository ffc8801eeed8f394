// Numbers of workgroups, places and nodes.

/// No number.
const NONE: u32 = 0xffffffffu;
/// Places of a slice, whose lists lie side by side.
const LANES: u32 = 16u;

/// Workgroups along x; more are in further rows along y, for one dimension may be too short. Those of a dispatch have the same
/// numbers whether the host gives their count or a kernel does.
const GROUPS_IN_ROW: u32 = 32768u;

/// The number of a workgroup.
fn workgroup_index(id: vec3u) -> u32 {
    return id.x + id.y * GROUPS_IN_ROW;
}

/// The place of an invocation.
fn node_of(id: vec3u, lane: u32) -> u32 {
    return workgroup_index(id) * 256u + lane;
}
