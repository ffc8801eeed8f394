// A V-cycle of multigrid with one damped step of Jacobi's iteration on each level on the way down and one on the way up.
//
// Source: Trottenberg, Oosterlee, Schüller, "Multigrid", 2001, §2.4. The first step on the finest level is `step_nodes`' own.
// Levels of few nodes are a body's tail: one workgroup does all of them, as no dispatch is shorter than its start.

#import contact/colliders/predicted_contact.wgsl
#import couplings
#import solvers/dual/solve.wgsl
#import solvers/implicit/levels.wgsl

/// The residual on the finest level, after its first step.
@compute @workgroup_size(256)
fn residual_of_nodes(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) || lane >= level_groups[index].count
        || node_solves[level_groups[index].solve].next.is_done != 0u {
        return;
    }
    let node = level_groups[index].first + lane;
    let residual = vector_of(RESIDUAL, node) - system_times(mass_of(node), CYCLE, node);
    put_vector(CYCLED, node, filtered(predicted_at(node), residual));
}

/// The right side of a coarser level, and the first step there.
fn restrict_to(node: u32) {
    let right = sum_of_children(node);
    put_vector(RESIDUAL, node, right);
    put_vector(CYCLE, node, jacobi_step(node, right));
}

@compute @workgroup_size(256)
fn restrict_level(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) || lane >= level_groups[index].count
        || node_solves[level_groups[index].solve].next.is_done != 0u {
        return;
    }
    restrict_to(level_groups[index].first + lane);
}

/// The residual of a vector on a coarser level.
fn residual_on_level(which: u32, node: u32) -> vec3f {
    return vector_of(RESIDUAL, node) - level_times(which, node);
}

@compute @workgroup_size(256)
fn residual_of_level(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) || lane >= level_groups[index].count
        || node_solves[level_groups[index].solve].next.is_done != 0u {
        return;
    }
    let node = level_groups[index].first + lane;
    put_vector(CYCLED, node, residual_on_level(CYCLE, node));
}

/// All levels of few nodes, one group each, down and up.
@compute @workgroup_size(256)
fn cycle_tail(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) {
        return;
    }
    let group = level_groups[index];
    if index != group.first_group || node_solves[group.solve].next.is_done != 0u {
        return;
    }
    for (var level = 0u; level < group.groups; level++) {
        let node = level_groups[index + level].first + lane;
        let is_there = lane < level_groups[index + level].count;
        if is_there {
            restrict_to(node);
        }
        storageBarrier();
        if is_there && level + 1u < group.groups {
            put_vector(CYCLED, node, residual_on_level(CYCLE, node));
        }
        storageBarrier();
    }
    sweep_coarsest(level_groups[index + group.groups - 1u], lane);
    for (var level = 1u; level < group.groups; level++) {
        let here = level_groups[index + group.groups - 1u - level];
        let node = here.first + lane;
        if lane < here.count {
            put_vector(CYCLE, node, vector_of(CYCLE, node) + sum_of_parents(node));
        }
        storageBarrier();
        if lane < here.count {
            smooth_on_level(CYCLE, CYCLED, node);
        }
        storageBarrier();
    }
}

/// Steps of Jacobi's iteration on the coarsest level.
fn sweep_coarsest(group: LevelGroup, lane: u32) {
    let node = group.first + lane;
    for (var sweep = 0u; sweep < SWEEPS; sweep++) {
        if lane < group.count {
            smooth_on_level(CYCLE, CYCLED, node);
        }
        storageBarrier();
        if lane < group.count && sweep + 1u < SWEEPS {
            smooth_on_level(CYCLED, CYCLE, node);
        }
        storageBarrier();
    }
}

/// A step of Jacobi's iteration on a coarser level.
fn smooth_on_level(before: u32, after: u32, node: u32) {
    put_vector(after, node, vector_of(before, node) + jacobi_step(node, residual_on_level(before, node)));
}

/// Prolongation: adds to a level the correction of the coarser one.
@compute @workgroup_size(256)
fn prolong_level(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) || lane >= level_groups[index].count
        || node_solves[level_groups[index].solve].next.is_done != 0u {
        return;
    }
    let node = level_groups[index].first + lane;
    var correction = sum_of_parents(node);
    if node < arrayLength(&predicted_contacts) {
        // The finest level, where nodes may be held.
        correction = filtered(predicted_at(node), correction);
    }
    put_vector(CYCLE, node, vector_of(CYCLE, node) + correction);
}

@compute @workgroup_size(256)
fn smooth_level(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) || lane >= level_groups[index].count
        || node_solves[level_groups[index].solve].next.is_done != 0u {
        return;
    }
    smooth_on_level(CYCLE, CYCLED, level_groups[index].first + lane);
}

/// The same from the other vector back.
@compute @workgroup_size(256)
fn smooth_level_back(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) || lane >= level_groups[index].count
        || node_solves[level_groups[index].solve].next.is_done != 0u {
        return;
    }
    smooth_on_level(CYCLED, CYCLE, level_groups[index].first + lane);
}

/// The last step of the cycle.
@compute @workgroup_size(256)
fn smooth_nodes(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) || lane >= level_groups[index].count
        || node_solves[level_groups[index].solve].next.is_done != 0u {
        return;
    }
    let node = level_groups[index].first + lane;
    let residual = vector_of(RESIDUAL, node) - system_times(mass_of(node), CYCLE, node);
    put_vector(CYCLED, node, vector_of(CYCLE, node) + jacobi_step(node, residual));
}
