// Implicit springs: conjugate gradients on all bodies' systems at once, each with steps of its own, preconditioned by a
// multigrid V-cycle. An iteration is a step, the cycle (`level_stages.wgsl`) and a product. Nothing is read
// back in a frame: as many iterations are written down as frames need (`count_left`), and `count_open_systems` keeps workgroups
// away when all systems are done.

#import contact/colliders/met.wgsl
#import contact/colliders/predicted_contact.wgsl
#import contact/colliders/shape.wgsl
#import contacts
#import couplings
#import gpu/wgsl/force.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl
#import solvers/dual/distance.wgsl
#import solvers/dual/solve.wgsl
#import solvers/implicit/levels.wgsl
#import solvers/implicit/second_order.wgsl

/// State of a system after a product, whose sums these are.
fn next_pcg_state(solve: NodeSolve, sums: vec4f) -> PcgState {
    let kept = solve.kept;
    var next = kept;
    next.alpha = 0.0;
    next.beta = 0.0;
    if kept.passes < 2u {
        // What brings the changes to start from nearest to the solution in the norm of the system.
        let helps = sums.x > 0.0 && sums.y > 0.0;
        next.alpha = select(0.0, sums.x / select(1.0, sums.y, helps), helps);
        next.whole = select(sums.z, kept.whole, kept.whole > 0.0);
        return next;
    }
    if is_met_before(solve, sums.x) {
        next.is_done = 1u;
        return next;
    }
    let is_first = kept.iterations == 0u;
    if is_first && solve.before == 0u {
        next.whole = max(sums.x, kept.whole);
    }
    next.error = sums.x;
    let step = conjugate_step(Conjugate(select(kept.error, 0.0, is_first), kept.alpha), sums.x, sums.y);
    if !step.is_there {
        // Nothing is left, or what is left is no number.
        next.is_done = 1u;
        return next;
    }
    next.iterations += 1u;
    next.alpha = step.alpha;
    next.beta = step.beta;
    // The step that was found with the error is taken all the same.
    let is_last = is_solved(next) || next.iterations == substeps[0].solving.most_iterations;
    next.is_done = select(0u, 1u, is_last);
    return next;
}

/// Whether a further Newton step is at its first product, and that says that equations are met well enough where it starts: `left`
/// is r·z. What is no number is left as it is.
fn is_met_before(solve: NodeSolve, left: f32) -> bool {
    let is_further = substeps[0].solving.is_automatic != 0u && solve.steps > 0u;
    let is_first_product = solve.kept.passes >= 2u && solve.kept.iterations == 0u;
    return is_further && is_first_product && !(left > LEFT * solve.motion);
}

/// Whether the error is small enough.
fn is_solved(done: PcgState) -> bool {
    return done.error <= substeps[0].solving.tolerance_squared * done.whole || done.error == 0.0;
}

/// The step of each system, and the first of the cycle after it.
@compute @workgroup_size(256)
fn step_nodes(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) {
        return;
    }
    let group = level_groups[index];
    let solve = node_solves[group.solve];
    if solve.kept.is_done != 0u {
        return;
    }
    let sums = sum_of_rows(lane, sums_of_lane(group, 0u, lane));
    let next = next_pcg_state(solve, sums);
    let is_stuck = next.is_done != 0u && next.iterations == solve.kept.iterations;
    if lane == 0u && index == group.first_group {
        node_solves[group.solve].next = next;
        node_solves[group.solve].is_met = select(0u, 1u, is_met_before(solve, sums.x));
    }
    if is_stuck || lane >= group.count {
        return;
    }
    let node = group.first + lane;
    let mass = mass_of(node);
    let residual = advanced_node(node, next);
    vectors[vector_at(RESIDUAL, node)] = vec4f(residual, mass);
    put_vector(CYCLE, node, jacobi_step(node, residual));
}

/// A node's vectors after the step. Returns the residual.
fn advanced_node(node: u32, step: PcgState) -> vec3f {
    let residual = vector_of(RESIDUAL, node);
    let product = vector_of(PRODUCT, node);
    let change = vector_of(CHANGE, node);
    if step.passes < 2u {
        put_vector(CHANGE, node, change + step.alpha * vector_of(CYCLED, node));
        put_vector(DIRECTION, node, vec3f(0.0));
        put_vector(DIRECTION_PRODUCT, node, vec3f(0.0));
        return residual - step.alpha * product;
    }
    let direction = vector_of(CYCLED, node) + step.beta * vector_of(DIRECTION, node);
    let direction_product = product + step.beta * vector_of(DIRECTION_PRODUCT, node);
    put_vector(DIRECTION, node, direction);
    put_vector(DIRECTION_PRODUCT, node, direction_product);
    put_vector(CHANGE, node, change + step.alpha * direction);
    return residual - step.alpha * direction_product;
}

/// The first residual, and the system times the initial guess.
@compute @workgroup_size(256)
fn start_nodes(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) {
        return;
    }
    let group = level_groups[index];
    if lane == 0u && index == group.first_group && node_solves[group.solve].is_met == 0u {
        node_solves[group.solve].kept.passes = 1u;
    }
    var terms = vec4f(0.0);
    if lane < group.count {
        terms = started(group.first + lane);
    }
    let sum = sum_of_rows(lane, terms);
    if lane == 0u {
        product_sums[index] = sum;
    }
}

/// A node at the start. Returns what it adds to the sums.
fn started(node: u32) -> vec4f {
    let predicted = predicted_at(node);
    let mass = mass_of(node);
    let residual = filtered(predicted, vector_of(RESIDUAL, node));
    vectors[vector_at(RESIDUAL, node)] = vec4f(residual, mass);
    let product = filtered(predicted, system_times(mass, CYCLED, node));
    put_vector(PRODUCT, node, product);
    let start = vector_of(CYCLED, node);
    return vec4f(dot3(start, residual), dot3(start, product), vectors[vector_at(TOTAL, node)].w, 0.0);
}

/// The system times the preconditioned residual, and sums of it.
@compute @workgroup_size(256)
fn apply_nodes(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) {
        return;
    }
    let group = level_groups[index];
    let next = node_solves[group.solve].next;
    if lane == 0u && index == group.first_group {
        node_solves[group.solve].kept = next;
        node_solves[group.solve].kept.passes = next.passes + 1u;
    }
    if next.is_done != 0u {
        return;
    }
    var terms = vec4f(0.0);
    if lane < group.count {
        terms = applied(group.first + lane);
    }
    let sum = sum_of_rows(lane, terms);
    if lane == 0u {
        product_sums[index] = sum;
    }
}

/// The same at a node. Returns what it adds to the sums.
fn applied(node: u32) -> vec4f {
    let product = filtered(predicted_at(node), system_times(mass_of(node), CYCLED, node));
    put_vector(PRODUCT, node, product);
    let cycled = vector_of(CYCLED, node);
    return vec4f(dot3(cycled, vector_of(RESIDUAL, node)), dot3(cycled, product), 0.0, 0.0);
}

/// Workgroups of the next iterations: none where all systems are done.
@compute @workgroup_size(256)
fn count_open_systems(@builtin(local_invocation_index) lane: u32) {
    var open = 0u;
    for (var i = lane; i < arrayLength(&node_solves); i += 256u) {
        open += select(0u, 1u, node_solves[i].kept.is_done == 0u);
    }
    let any = count_of_lanes(lane, open) > 0u;
    put_counts(lane, ITERATED, any);
    if lane == 0u {
        written_steps[PLACE] += 1u;
        written_steps[OPEN_AT] = select(written_steps[OPEN_AT], written_steps[PLACE], any);
    }
}

/// Notes how far a solve came, after the steps that are written down.
@compute @workgroup_size(256)
fn count_left(@builtin(local_invocation_index) lane: u32) {
    var left = 0u;
    for (var i = lane; i < arrayLength(&node_solves); i += 256u) {
        let solve = node_solves[i];
        let waits = substeps[0].solving.is_automatic != 0u && may_go_on(solve);
        left += select(0u, 1u, waits || solve.next.is_done == 0u);
    }
    let all_left = count_of_lanes(lane, left);
    if lane == 0u {
        written_steps[PLACE] = 0u;
        written_steps[MOST_OPEN_AT] = max(written_steps[MOST_OPEN_AT], written_steps[OPEN_AT]);
        written_steps[OPEN_AT] = 0u;
        written_steps[IS_LEFT] |= min(all_left, 1u);
    }
}

/// Impulses of springs [N s] with the changes that a Newton step found. Those of a body that takes no further one stay: with
/// them, as the system has them, all of momentum is there.
@compute @workgroup_size(256)
fn spring_impulses(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) || lane >= level_groups[index].count {
        return;
    }
    let node = level_groups[index].first + lane;
    if node_solves[level_groups[index].solve].is_met == 0u {
        put_vector(GIVEN, node, vector_of(IMPULSE, node) - system_times(0.0, CHANGE, node));
    }
}

/// Adds the force of implicit springs to that on each node.
@compute @workgroup_size(256)
fn add_implicit_forces(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) || lane >= level_groups[index].count {
        return;
    }
    let node = level_groups[index].first + lane;
    let inverse_mass = old_position[node].w;
    if !(inverse_mass > 0.0) {
        // What a pin has to hold against.
        force[node] = vec4f(force[node].xyz + vector_of(GIVEN, node) * (1.0 / substeps[0].solving.inner), 0.0);
        return;
    }
    let predicted = predicted_at(node);
    let spring_change = velocity_change(node, predicted, inverse_mass);
    put_vector(SPRING_CHANGE, node, spring_change);
    var change = spring_change;
    if in_contact(predicted) {
        let free = new_velocity[node].xyz;
        let collider = colliders[met_by(node, 0u).own + predicted_contacts[node].collider];
        change = velocity_after(predicted, free, spring_change, collider) - free;
    }
    force[node] = vec4f(force[node].xyz + change * (abs(old_velocity[node].w) / substeps[0].h), 0.0);
}

/// Keeps the acceleration of a node whose velocity has changed by `found` of that without springs; returns what has changed of
/// the velocity by outer forces alone.
fn keep_rate(node: u32, predicted: PredictedContact, found: vec3f) -> vec3f {
    let scheme = substeps[own()].solving;
    if scheme.is_second == 0u {
        return found;
    }
    let u = vector_of(FREE, node) + found;
    let motion = motion_of(predicted, old_velocity[node].xyz, vector_of(RATE, node));
    let friction = select(vec3f(0.0), friction_change(predicted), in_contact(predicted));
    let rate = scheme.rate_of_change * (u - friction - motion.velocity) + scheme.rate_kept * motion.rate;
    put_vector(RATE, node, select(rate, filtered(predicted, rate), in_contact(predicted)));
    return u - new_velocity[node].xyz;
}

/// Puts nodes where steps of second order take them.
@compute @workgroup_size(256)
fn place_implicit_nodes(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) || lane >= level_groups[index].count {
        return;
    }
    let node = level_groups[index].first + lane;
    let x = new_position[node];
    if old_position[node].w > 0.0 && substeps[own()].solving.is_second != 0u {
        let at = vector_of(START, node) + substeps[0].solving.inner * new_velocity[node].xyz;
        new_position[node] = vec4f(at, x.w);
    }
}

/// What springs change of a node's velocity [m/s]: what was solved for, and what they press on a surface.
fn velocity_change(node: u32, predicted: PredictedContact, inverse_mass: f32) -> vec3f {
    let found = keep_rate(node, predicted, vector_of(TOTAL, node) + vector_of(CHANGE, node));
    if !in_contact(predicted) {
        return found;
    }
    let springs = (substeps[0].solving.whole * inverse_mass) * vector_of(GIVEN, node);
    if predicted.slides == 0.0 {
        return springs;
    }
    let along = found - friction_change(predicted);
    return along + predicted.normal * dot3(springs - along, predicted.normal);
}

/// Adds iterations and residuals of all systems to the statistics of the frame.
@compute @workgroup_size(256)
fn record_implicit_statistics(@builtin(local_invocation_index) lane: u32) {
    var capped = 0u;
    var most = vec4f(0.0);
    for (var i = lane; i < arrayLength(&node_solves); i += 256u) {
        let done = node_solves[i].next;
        capped += select(1u, 0u, is_solved(done));
        let all = f32(node_solves[i].before + done.iterations);
        let share = done.error / select(1.0, done.whole, done.whole > 0.0);
        most = max(most, vec4f(all, select(0.0, share, done.whole > 0.0), 0.0, 0.0));
    }
    let count = count_of_lanes(lane, capped);
    most = most_of_rows(lane, most);
    if lane == 0u {
        statistics[0].iterations = max(statistics[0].iterations, u32(most.x));
        statistics[0].capped += min(count, 1u);
        statistics[0].active_fraction = 1.0;
        statistics[0].residual = max(statistics[0].residual, most.y);
    }
}
