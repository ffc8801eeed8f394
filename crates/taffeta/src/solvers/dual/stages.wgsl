// Implicit constraint enforcement: conjugate gradients on the systems of all bodies at once; each system has its own
// steps. An iteration is two kernels. `solve_nodes` computes the step from the sums of the rows, and the response of
// each node to the residual after that step. `solve_rows` takes the step, and multiplies the residual by the matrix.
// Nothing is read back: all iterations that a sub-step may need are recorded, and `count_systems` sets the workgroups
// to zero when all systems have converged.

#import contact/colliders/met.wgsl
#import contact/colliders/predicted_contact.wgsl
#import contact/colliders/shape.wgsl
#import elements/spring/spring.wgsl
#import gpu/wgsl/force.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl
#import solvers/dual/deepest_contact.wgsl
#import solvers/dual/distance.wgsl
#import solvers/dual/solve.wgsl
#import solvers/explicit/euler.wgsl
#import memory

/// Velocities without constraints, and which nodes have any. Springs that are constraints are subtracted from the
/// force.
@compute @workgroup_size(256)
fn free_velocities(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&node_groups) || lane >= node_groups[index].count {
        return;
    }
    let node = node_groups[index].first + lane;
    let x = old_position[node];
    let v = old_velocity[node];
    var without = force[node].xyz;
    var is_active = false;
    let range = entries_at(node);
    for (var at = range.x; at < range.y && incident[at] != NONE; at += LANES) {
        let constraint = constraints[incident[at] / 2u];
        if constraint.is_active != 0u {
            is_active = true;
            if substeps[own()].solving.is_adaptive != 0u {
                let other = select(constraint.a, constraint.b, constraint.a == node);
                let d = position_of(other) - x.xyz;
                let dv = velocity_of(other) - v.xyz;
                without -= spring_factor(d, dv, constraint.k, constraint.damping, constraint.rest_length) * d;
            }
        }
    }
    force[node] = vec4f(without, 0.0);
    let velocity = new_velocity_of(v.xyz, without, x.w, substeps[0].gravity, substeps[0].h);
    new_velocity[node] = vec4f(velocity, abs(v.w));
    predicted_contacts[node] = contact_record(no_contact(), 0u, 0.0);
    predicted_contacts[node].is_constrained = select(0u, 1u, is_active);
}

/// The softness of a constraint.
fn softness_of(constraint: Constraint) -> Softness {
    let epsilon = substeps[0].solving.epsilon;
    let form = substeps[own()].solving.form;
    if substeps[own()].solving.is_adaptive != 0u {
        return stiff_softness(epsilon, form, substeps[0].h);
    }
    return spring_softness(constraint.k, constraint.damping, epsilon, form, substeps[0].h);
}

/// A row at the start of a sub-step.
struct SetUp {
    row: Row,
    scale: vec2f,
}

/// The row of a constraint, with the force of the last sub-step as warm start. The right side has the part of
/// positions.
fn row_of(constraint: Constraint, multiplier: f32) -> SetUp {
    let a = old_position[constraint.a];
    let b = old_position[constraint.b];
    let softness = softness_of(constraint);
    let row = constraint_row(softness, b.xyz - a.xyz, a.w + b.w, substeps[0].solving.aim * constraint.rest_length);
    let start = select(0.0, multiplier / select(1.0, row.scale, row.scale > 0.0), row.scale > 0.0);
    let noise = row_noise(row, softness.rate, a.xyz);
    return SetUp(Row(row.direction, start, 0.0, noise, row.right, start), vec2f(row.scale, row.compliance));
}

/// Sets up the rows of all constraints; inactive ones are 0.
@compute @workgroup_size(256)
fn set_up_rows(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&constraint_groups) {
        return;
    }
    let group = constraint_groups[index];
    if lane < group.count {
        let number = group.first + lane;
        let multiplier = rows[number].x * row_scales[number].x;
        var found = SetUp(Row(vec3f(0.0), 0.0, 0.0, 0.0, 0.0, 0.0), vec2f(0.0));
        if constraints[number].is_active != 0u {
            found = row_of(constraints[number], multiplier);
        }
        rows[number] = found.row;
        row_scales[number] = found.scale;
    }
    if lane == 0u && index == group.first_group {
        let start = CgState(0u, 0u, 0.0, 0.0, 0.0, 0.0, 0.0);
        solves[group.solve].kept = start;
        solves[group.solve].next = start;
    }
}

/// Predicts the contact of each node from the constraint forces of the last sub-step. Then computes the velocity
/// without constraints, divided by the sub-step, in the directions in which the node is free to move. Adaptive
/// constraints predict no contacts: the forces of the last active ones say too little about the next contacts, and
/// contact alone is more accurate.
@compute @workgroup_size(256)
fn predict_contacts(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&node_groups) || lane >= node_groups[index].count {
        return;
    }
    let node = node_groups[index].first + lane;
    if predicted_contacts[node].is_constrained == 0u {
        return;
    }
    let x = old_position[node];
    let h = substeps[0].h;
    let free = new_velocity[node].xyz;
    var rate = free / h;
    if substeps[own()].colliders > 0u && substeps[own()].solving.is_adaptive == 0u {
        if x.w > 0.0 {
            let reach = reach_of(substeps[0].gravity, h);
            let approach = Approach(x.xyz, reach, free, h, x.w * gather_constraint_forces(node) * -h);
            predicted_contacts[node] = deepest_contact(node, approach, predicted_contacts[node]);
        }
        let predicted = predicted_at(node);
        rate = filtered(predicted, rate) + predicted.velocity * (1.0 / h);
    }
    response[node] = vec4f(rate, 0.0);
}

/// Adds the part of velocities to the right side.
@compute @workgroup_size(256)
fn start_rows(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&constraint_groups) || lane >= constraint_groups[index].count {
        return;
    }
    let number = constraint_groups[index].first + lane;
    let constraint = constraints[number];
    if constraint.is_active != 0u {
        let rate = response[constraint.b].xyz - response[constraint.a].xyz;
        rows[number].p += dot3(rate, rows[number].direction);
    }
    if substeps[own()].solving.is_warm == 0u {
        // These forces have predicted the contacts.
        rows[number].x = 0.0;
        rows[number].r = 0.0;
    }
}

/// Workgroups of the next iterations: none if all systems have converged.
@compute @workgroup_size(256)
fn count_systems(@builtin(local_invocation_index) lane: u32) {
    var open = 0u;
    for (var i = lane; i < arrayLength(&solves); i += 256u) {
        open += select(0u, 1u, solves[i].active_constraints > 0u && solves[i].kept.is_done == 0u);
    }
    let all = count_of_lanes(lane, open);
    if lane < 2u {
        let groups = select(arrayLength(&node_groups), arrayLength(&constraint_groups), lane == 1u);
        let across = select(0u, min(groups, GROUPS_IN_ROW), all > 0u);
        solve_counts[3u * lane] = across;
        solve_counts[3u * lane + 1u] = (groups + GROUPS_IN_ROW - 1u) / GROUPS_IN_ROW;
        solve_counts[3u * lane + 2u] = 1u;
    }
}

/// The state of a system after a pass over its rows, from their sums.
fn next_state(kept: CgState, sums: vec4f) -> CgState {
    var next = kept;
    next.alpha = 0.0;
    next.beta = 0.0;
    if kept.passes == 1u {
        next.right = sums.x;
        next.limit = max(substeps[0].solving.tolerance_squared * sums.x, sums.y);
        // The factor by which the warm start is closest to the solution in the norm of the system. Unscaled, the
        // forces of a sub-step that was cut short can be worse than none.
        let helps = sums.z > 0.0 && sums.w > 0.0;
        next.alpha = select(0.0, sums.z / select(1.0, sums.w, helps), helps);
    }
    if kept.passes < 2u {
        return next;
    }
    next.gamma = sums.x;
    let step = conjugate_step(Conjugate(kept.gamma, kept.alpha), sums.x, sums.y);
    let is_left = sums.x > next.limit && kept.passes - 2u < substeps[0].solving.most_iterations;
    // A NaN ends the iterations.
    next.is_done = select(1u, 0u, is_left && step.is_there);
    next.alpha = step.alpha;
    next.beta = step.beta;
    return next;
}

/// Computes the step of each system, and the response of each node to the residual after it.
@compute @workgroup_size(256)
fn solve_nodes(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&node_groups) {
        return;
    }
    let group = node_groups[index];
    let active_count = solves[group.solve].active_constraints;
    let kept = solves[group.solve].kept;
    if active_count == 0u || kept.is_done != 0u {
        return;
    }
    let next = next_state(kept, sums_of_body(group.first_group, active_count, lane));
    if group.is_first != 0u && lane == 0u {
        solves[group.solve].next = next;
    }
    if next.is_done != 0u || lane >= group.count {
        return;
    }
    let node = group.first + lane;
    if predicted_contacts[node].is_constrained == 0u {
        return;
    }
    var sum = vec3f(0.0);
    let range = entries_at(node);
    for (var at = range.x; at < range.y && incident[at] != NONE; at += LANES) {
        let row = rows[incident[at] / 2u];
        let left = row.r - next.alpha * (row.w + next.beta * row.s);
        let first = row.p - next.alpha * row.w;
        sum += sign_at(incident[at]) * (row.direction * select(left, first, kept.passes == 1u));
    }
    response[node] = vec4f(filtered(predicted_at(node), old_position[node].w * sum), 0.0);
}

/// Takes the step, and multiplies the residual by the matrix; at first the warm start.
@compute @workgroup_size(256)
fn solve_rows(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&constraint_groups) {
        return;
    }
    let group = constraint_groups[index];
    let active_count = solves[group.solve].active_constraints;
    let next = solves[group.solve].next;
    let is_first = index == group.first_group && lane == 0u;
    if is_first {
        solves[group.solve].kept = next;
        solves[group.solve].kept.passes = next.passes + 1u;
    }
    let in_body = 256u * (index - group.first_group) + lane;
    if active_count == 0u || next.is_done != 0u || in_body - lane >= active_count {
        return;
    }
    var terms = vec4f(0.0);
    if in_body < active_count {
        let number = active_constraints[constraint_groups[group.first_group].first + in_body];
        terms = advanced(number, next);
    }
    let sum = sum_of_rows(lane, terms);
    if lane == 0u {
        row_sums[index] = sum;
    }
}

/// Advances a row by the step. Returns its terms of the sums.
fn advanced(number: u32, step: CgState) -> vec4f {
    var row = rows[number];
    if step.passes == 1u {
        row.r = row.p - step.alpha * row.w;
        row.x *= step.alpha;
        row.p = 0.0;
        row.s = 0.0;
    } else if step.passes > 1u {
        row.p = row.r + step.beta * row.p;
        row.s = row.w + step.beta * row.s;
        row.x += step.alpha * row.p;
        row.r -= step.alpha * row.s;
    }
    let constraint = constraints[number];
    let apart = response[constraint.b].xyz - response[constraint.a].xyz;
    row.w = dot3(apart, row.direction) + row_scales[number].y * row.r;
    rows[number] = row;
    if step.passes == 0u {
        return vec4f(row.p * row.p, row.s * row.s, row.x * row.p, row.x * row.w);
    }
    return vec4f(row.r * row.r, row.r * row.w, 0.0, 0.0);
}

/// The constraint force on a node in contact.
fn with_contact(node: u32, node_force: vec3f) -> vec3f {
    let predicted = predicted_at(node);
    if !in_contact(predicted) {
        return node_force;
    }
    let x = old_position[node];
    let free = new_velocity[node].xyz;
    let kick = substeps[0].h * x.w;
    let collider = colliders[met_by(node, 0u).own + predicted_contacts[node].collider];
    let after = velocity_after(predicted, free, node_force * kick, collider);
    return (after - free) * (1.0 / kick);
}

/// Adds all constraint forces to the force on each node.
@compute @workgroup_size(256)
fn apply_constraint_forces(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&node_groups) || lane >= node_groups[index].count {
        return;
    }
    let node = node_groups[index].first + lane;
    if predicted_contacts[node].is_constrained == 0u {
        return;
    }
    let node_force = with_contact(node, -gather_constraint_forces(node));
    force[node] = vec4f(force[node].xyz + node_force, 0.0);
}

/// Adds up the statistics of all systems for the frame's report.
@compute @workgroup_size(256)
fn record_statistics(@builtin(local_invocation_index) lane: u32) {
    var all = 0u;
    var active_count = 0u;
    var capped = 0u;
    var most = vec4f(0.0);
    for (var i = lane; i < arrayLength(&solves); i += 256u) {
        let solve = solves[i];
        all += solve.constraints;
        active_count += solve.active_constraints;
        if solve.active_constraints > 0u {
            let done = solve.next;
            let right = max(done.right, done.limit / substeps[0].solving.tolerance_squared);
            capped += select(0u, 1u, done.gamma > done.limit);
            let taken_by = f32(max(done.passes, 2u) - 2u);
            most = max(most, vec4f(taken_by, select(0.0, done.gamma / right, right > 0.0), 0.0, 0.0));
        }
    }
    let count = vec3u(count_of_lanes(lane, all), count_of_lanes(lane, active_count), count_of_lanes(lane, capped));
    most = most_of_rows(lane, most);
    if lane == 0u {
        statistics[0].iterations = max(statistics[0].iterations, u32(most.x));
        statistics[0].capped += min(count.z, 1u);
        statistics[0].active_fraction = max(statistics[0].active_fraction, f32(count.y) / f32(max(count.x, 1u)));
        statistics[0].residual = max(statistics[0].residual, most.y);
    }
}
