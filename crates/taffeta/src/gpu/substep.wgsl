// What a sub-step is told, and which of the workgroups this is.

/// One sub-step. Records lie 256 bytes apart: the largest alignment that a device may ask of a dynamic offset.
struct Substep {
    /// [m/s²]
    gravity: vec3f,
    /// Length [s].
    h: f32,
    /// Force of the wind on each node [N].
    wind: vec3f,
    /// Linear drag [kg/s].
    drag: f32,
    /// Colliders at its end: `colliders` of them from here on.
    first_collider: u32,
    colliders: u32,
    /// Motions at its end, from here on.
    first_motion: u32,
    /// Scales of the loads at its start, from here on.
    first_scale: u32,
    /// Share of the frame that has gone by at its end, and that share's rate [1/s].
    hand_share: f32,
    hand_rate: f32,
    /// Nodes on which the program pushes.
    hand_forces: u32,
    /// Nodes that move.
    pins: u32,
    /// Sub-steps that were handed over with it, from this one on.
    left: u32,
    /// Volumes to keep, or pressures, at its end, from here on.
    first_goal: u32,
    /// Longest way apart of nodes that touch each other, by the thickness.
    @size(184) most_apart: f32,
}

/// The sub-step of this dispatch, and those after it.
@group(0) @binding(0) var<uniform> substeps: array<Substep, 64>;

/// Colliders of all sub-steps of a frame.
@group(0) @binding(1) var<storage, read> colliders: array<Collider>;

/// Workgroups are counted along x, then y: one dimension alone may be too short.
fn workgroup_index(id: vec3u, counts: vec3u) -> u32 {
    return id.x + id.y * counts.x;
}
