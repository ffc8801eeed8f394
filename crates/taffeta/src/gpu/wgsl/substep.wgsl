// What a sub-step is told, and which of the workgroups this is.

#import elements/aero/aero.wgsl

/// How constraints are solved.
struct Solving {
    /// Squared stretch from which on a spring becomes a constraint, and down to which it stays one.
    activation: f32,
    release: f32,
    /// Stretch that constraints aim at.
    aim: f32,
    /// Compliance by the diagonal, and which equations.
    epsilon: f32,
    form: u32,
    /// Squared residual, by that of the right side, and iterations at which a system is done.
    tolerance_squared: f32,
    most_iterations: u32,
    /// Whether springs act as well, and constraints only where they are too long.
    is_adaptive: u32,
    /// Whether pulls start from those of the last sub-step.
    is_warm: u32,
    /// Of springs by nodes (scheme.rs): the step of their system [s], what masses are multiplied by in it, and the share that
    /// outer forces have.
    inner: f32,
    mass: f32,
    outer: f32,
    /// At second order: what the place without velocity has of the velocity [s] and of the acceleration [s²], and what the
    /// velocity without springs has of the acceleration [s].
    place_of_velocity: f32,
    place_of_rate: f32,
    velocity_of_rate: f32,
    /// What the next acceleration has of the change of velocity [1/s] and of the last acceleration; the whole step by that of
    /// the system.
    rate_of_change: f32,
    rate_kept: f32,
    whole: f32,
    /// Whether it is of second order; whether Newton steps are as many as the equations need.
    is_second: u32,
    is_automatic: u32,
}

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
    frame_fraction: f32,
    frame_rate: f32,
    /// Nodes on which the program pushes.
    input_forces: u32,
    /// Nodes that move.
    pins: u32,
    solving: Solving,
    /// Sub-steps that were handed over with it, from this one on.
    left: u32,
    /// Volumes to keep, or pressures, at its end, from here on.
    first_goal: u32,
    /// Longest way apart of nodes that touch each other, by the thickness.
    max_separation: f32,
    /// 0: its place among the records that its dispatch sees.
    own: u32,
    /// What is on its way around triangles.
    air: Air,
    /// Corners of colliders: those at its start from here on, and then those at its end; none where no collider ever moves.
    first_corner: u32,
    /// In how many parts they go: 0 if they stand still.
    corner_parts: u32,
    /// The longest way along each axis that nodes are pushed in one of them [m].
    longest_push: f32,
    /// Where in `mesh_data` it stands which nodes are led out of colliders, a bit each; NONE if none are.
    led_out: u32,
    /// Ranges of places that have a list of colliders each.
    collider_ranges: u32,
    /// Length of the longest of its frame [s].
    longest_step: f32,
    /// Whether surfaces may hold back nodes that pins move: 1, else 0.
    pins_may_lag: u32,
}

/// The sub-step of this dispatch, and those after it.
@group(0) @binding(0) var<uniform> substeps: array<Substep, 64>;

/// Where the dispatch's own record is. Loops and branches read what they depend on through it: of uniforms at places that a
/// kernel's text alone tells, lavapipe makes constants, and compiles the kernel again for every dispatch.
fn own() -> u32 {
    return substeps[0].own;
}

