// Adaptive constraints: which springs are constraints because they are too long, and their list in ascending order.

#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl
#import solvers/dual/solve.wgsl

/// Whether a spring is a constraint in this sub-step.
fn becomes_active(constraint: Constraint) -> bool {
    let a = old_position[constraint.a];
    let b = old_position[constraint.b];
    let d = b.xyz - a.xyz;
    let squared = dot3(d, d);
    let rest = constraint.rest_length * constraint.rest_length;
    let is_long = squared > substeps[0].solving.activation * rest;
    let stays = constraint.is_active != 0u && squared > substeps[0].solving.release * rest;
    return (a.w > 0.0 || b.w > 0.0) && (is_long || stays);
}

/// Decides which springs are constraints in this sub-step, and counts those of each group.
@compute @workgroup_size(256)
fn mark_active(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&constraint_groups) {
        return;
    }
    let group = constraint_groups[index];
    var own = 0u;
    if lane < group.count {
        own = select(0u, 1u, becomes_active(constraints[group.first + lane]));
        constraints[group.first + lane].is_active = own;
    }
    let count = count_of_lanes(lane, own);
    if lane == 0u {
        active_counts[index] = count;
    }
}

/// Lists the active constraints of each body in ascending order: each group counts those of the groups before it.
@compute @workgroup_size(256)
fn list_active(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&constraint_groups) {
        return;
    }
    let group = constraint_groups[index];
    var earlier = 0u;
    for (var i = group.first_group + lane; i < index; i += 256u) {
        earlier += active_counts[i];
    }
    let before = count_of_lanes(lane, earlier);
    var own = 0u;
    if lane < group.count {
        own = constraints[group.first + lane].is_active;
    }
    let up_to = count_up_to(lane, own);
    if own != 0u {
        active_constraints[constraint_groups[group.first_group].first + before + up_to - 1u] = group.first + lane;
    }
    if lane == 255u && index + 1u == group.first_group + group.groups {
        solves[group.solve].active_constraints = before + up_to;
    }
}
