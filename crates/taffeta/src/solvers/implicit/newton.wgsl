// How many Newton steps a sub-step takes, where the scene leaves it to the solver. Commands of a further step stand between
// iterations; as many workgroups run as are counted here, none as long as an iteration is under way and when all equations are
// met. Whether they are is found with the first product of a step.

#import contacts
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl
#import solvers/dual/solve.wgsl
#import solvers/implicit/levels.wgsl

/// The share of what outer forces do in the sub-step that is motion.
const SHARE_OF_OUTER: f32 = 0.1;

/// Adds up the motion of bodies before the sub-step, behind what products add up: Σ m v and Σ m; then Σ m |v|² and
/// Σ m |v* − v|².
@compute @workgroup_size(256)
fn sum_motion(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    let groups = arrayLength(&level_groups);
    if index >= groups {
        return;
    }
    var momentum = vec4f(0.0);
    var squares = vec4f(0.0);
    if lane < level_groups[index].count {
        let node = level_groups[index].first + lane;
        let mass = mass_of(node);
        let v = select(vector_of(FREE, node), old_velocity[node].xyz, old_position[node].w > 0.0);
        momentum = vec4f(mass * v, mass);
        squares = vec4f(mass * dot3(v, v), vectors[vector_at(TOTAL, node)].w, 0.0, 0.0);
    }
    let momenta = sum_of_rows(lane, momentum);
    workgroupBarrier();
    let sums = sum_of_rows(lane, squares);
    if lane == 0u {
        product_sums[groups + index] = momenta;
        product_sums[2u * groups + index] = sums;
    }
}

/// The sums over the nodes of a system of one sort: 1 and 2, those of the motion.
fn sums_of_sort(group: LevelGroup, sort: u32, lane: u32) -> vec4f {
    let sum = sum_of_rows(lane, sums_of_lane(group, sort, lane));
    // The lanes are free for the next sum.
    workgroupBarrier();
    return sum;
}

/// The motion of bodies, twice its energy [J]: a share of what outer forces do in the sub-step, and what is about the mean
/// velocity. Outer forces are there at rest, too, where errors of their size would keep bodies in motion.
@compute @workgroup_size(256)
fn weigh_motion(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) || index != level_groups[index].first_group {
        return;
    }
    let group = level_groups[index];
    let momentum = sums_of_sort(group, 1u, lane);
    let squares = sums_of_sort(group, 2u, lane);
    if lane > 0u {
        return;
    }
    let mass = momentum.w;
    let mean = select(0.0, dot3(momentum.xyz, momentum.xyz) / select(1.0, mass, mass > 0.0), mass > 0.0);
    node_solves[group.solve].motion = SHARE_OF_OUTER * squares.y + (squares.x - mean);
}

/// Workgroups of a further Newton step: none as long as iterations go on, or where none is needed.
@compute @workgroup_size(256)
fn count_next_step(@builtin(local_invocation_index) lane: u32) {
    var open = 0u;
    var waiting = 0u;
    for (var i = lane; i < arrayLength(&node_solves); i += 256u) {
        let solve = node_solves[i];
        open += select(0u, 1u, solve.kept.is_done == 0u);
        waiting += select(0u, 1u, may_go_on(solve));
    }
    let all_open = count_of_lanes(lane, open);
    let all_waiting = count_of_lanes(lane, waiting);
    put_counts(lane, BEGUN, all_open == 0u && all_waiting > 0u);
}
