// Joints and tethers. Each kernel reads the state after the sub-step; the last one writes over the state before it.

#import attachments/attach.wgsl
#import contact/colliders/resolve_contact_again.wgsl
#import gpu/wgsl/goals.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl
#import motion/pins.wgsl

/// A pair of a seam, or a node and the point of a breakable pin.
struct Joint {
    /// Where the point starts [m], and the track that it follows; NONE: it does not move.
    point: vec3f,
    track: u32,
    /// Its nodes. If the second is NONE, it is the point.
    a: u32,
    b: u32,
    /// Distance at the start, and once closed [m].
    start: f32,
    end: f32,
    /// [m/N]
    compliance: f32,
    /// [N]
    break_force: f32,
    /// Where the goals of a sub-step have the fraction of its closing.
    closing: u32,
    /// Whether it shares free nodes with others.
    grouped: u32,
}

@group(1) @binding(60) var<storage, read> joints: array<Joint>;
/// Where the list of each place begins, or NONE. A list has the number of joints; for each joint, twice its number,
/// plus one at its second node; the number of tethers; for each tether, its anchor, and its length [m] as bits.
@group(1) @binding(61) var<storage, read> attachment_lists: array<u32>;
/// Groups of joints that share free nodes: their number; where the list of each begins, and where the last ends;
/// their joints.
@group(1) @binding(62) var<storage, read> joint_groups: array<u32>;
/// Of each joint, whether it is broken.
@group(3) @binding(60) var<storage, read_write> joint_broken: array<u32>;
/// The correction of each joint, as `JointCorrection`; in w whether it acts.
@group(3) @binding(62) var<storage, read_write> joint_corrections: array<vec4f>;
/// Memory to solve groups: five fields of each joint, as in joints.rs; then a sum for each place.
@group(3) @binding(61) var<storage, read_write> joint_work: array<vec4f>;

/// Where a joint's second end is [m], with its inverse mass [1/kg].
fn second_end(joint: Joint) -> vec4f {
    if joint.b != NONE {
        return old_position[joint.b];
    }
    if joint.track == NONE {
        return vec4f(joint.point, 0.0);
    }
    let motion = motions[substeps[0].first_motion + joint.track];
    return vec4f(affine(motion.x, motion.y, motion.z, joint.point), 0.0);
}

/// Length of a joint now [m].
fn length_of(joint: Joint) -> f32 {
    return joint_length(joint.start, joint.end, goals[substeps[0].first_goal + joint.closing]);
}

/// Sets the correction of a joint, and whether it breaks.
fn note_correction(row: u32, correction: JointCorrection) {
    let h = substeps[0].h;
    let breaks = joint_broken[row] != 0u || correction.size / (h * h) > joints[row].break_force;
    joint_broken[row] = select(0u, 1u, breaks);
    joint_corrections[row] = select(vec4f(correction.shift, 1.0), vec4f(0.0), breaks);
}

/// Solves each joint that shares no free node, and marks those that break.
@compute @workgroup_size(256)
fn solve_joints(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let row = node_of(id, lane);
    if row >= arrayLength(&joints) {
        return;
    }
    let joint = joints[row];
    if joint.grouped != 0u {
        return;
    }
    let a = old_position[joint.a];
    let b = second_end(joint);
    let h = substeps[0].h;
    note_correction(row, solve_joint(a.xyz - b.xyz, length_of(joint), a.w + b.w, joint.compliance / (h * h)));
}

/// Fields of a joint in a group: residual, direction, and their products with the matrix; its line, and in w its
/// softness, or less than 0 if it does not act.
const JOINT_RESIDUAL: u32 = 0u;
const JOINT_DIRECTION: u32 = 1u;
const JOINT_AR: u32 = 2u;
const JOINT_AP: u32 = 3u;
const JOINT_LINE: u32 = 4u;
const JOINT_FIELDS: u32 = 5u;

fn joint_field(row: u32, which: u32) -> vec3f {
    return joint_work[JOINT_FIELDS * row + which].xyz;
}

fn put_joint_field(row: u32, which: u32, value: vec3f) {
    joint_work[JOINT_FIELDS * row + which] = vec4f(value, 0.0);
}

fn is_active_joint(row: u32) -> bool {
    return joint_work[JOINT_FIELDS * row + JOINT_LINE].w >= 0.0;
}

/// The index of a node's sum, or NONE if the node is pinned, or a point.
fn joint_sum_of(end: u32) -> u32 {
    if end == NONE || old_position[end].w <= 0.0 {
        return NONE;
    }
    return JOINT_FIELDS * arrayLength(&joints) + end;
}

/// Sets up a joint of a group.
fn begin_joint(row: u32) {
    let joint = joints[row];
    let a = old_position[joint.a];
    let b = second_end(joint);
    let d = a.xyz - b.xyz;
    let distance = sqrt(dot3(d, d));
    let goal = length_of(joint);
    let any_line = goal <= 0.0;
    let h = substeps[0].h;
    let has_line = distance > 0.0 && (distance >= goal || goal == joint.end);
    let links = joint_broken[row] == 0u && a.w + b.w > 0.0 && (any_line || has_line);
    let line = d / distance;
    let softness = select(-1.0, joint.compliance / (h * h), links);
    joint_work[JOINT_FIELDS * row + JOINT_LINE] = vec4f(select(line, vec3f(0.0), any_line || !links), softness);
    put_joint_field(row, JOINT_RESIDUAL, select(line * (goal - distance), -d, any_line));
    joint_corrections[row] = vec4f(0.0);
}

/// Multiplies a field of a group by the matrix.
fn apply_matrix(first: u32, end: u32, given: u32, made: u32) {
    for (var at = first; at < end; at++) {
        let joint = joints[joint_groups[at]];
        let sums = vec2u(joint_sum_of(joint.a), joint_sum_of(joint.b));
        if sums.x != NONE {
            joint_work[sums.x] = vec4f(0.0);
        }
        if sums.y != NONE {
            joint_work[sums.y] = vec4f(0.0);
        }
    }
    for (var at = first; at < end; at++) {
        let row = joint_groups[at];
        if !is_active_joint(row) {
            continue;
        }
        let value = vec4f(joint_field(row, given), 0.0);
        let sums = vec2u(joint_sum_of(joints[row].a), joint_sum_of(joints[row].b));
        if sums.x != NONE {
            joint_work[sums.x] += value;
        }
        if sums.y != NONE {
            joint_work[sums.y] -= value;
        }
    }
    for (var at = first; at < end; at++) {
        let row = joint_groups[at];
        if !is_active_joint(row) {
            continue;
        }
        let both = moved_by_joints(joints[row].a) - moved_by_joints(joints[row].b);
        let line = joint_work[JOINT_FIELDS * row + JOINT_LINE];
        let kept = select(both, line.xyz * dot3(line.xyz, both), dot3(line.xyz, line.xyz) > 0.0);
        put_joint_field(row, made, kept + joint_field(row, given) * line.w);
    }
}

/// The motion of a joint's end by its sum.
fn moved_by_joints(end: u32) -> vec3f {
    let sum = joint_sum_of(end);
    if sum == NONE {
        return vec3f(0.0);
    }
    return joint_work[sum].xyz * old_position[end].w;
}

/// Sum of the products of two fields of a group, in the order of its joints.
fn joint_product(first: u32, end: u32, a: u32, b: u32) -> f32 {
    var sum = 0.0;
    for (var at = first; at < end; at++) {
        let row = joint_groups[at];
        if is_active_joint(row) {
            sum += dot3(joint_field(row, a), joint_field(row, b));
        }
    }
    return sum;
}

/// Most iterations of a group.
const GROUP_ROUNDS: u32 = 64u;

/// Solves each group of joints, and marks those that break.
@compute @workgroup_size(256)
fn solve_joint_groups(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let group = node_of(id, lane);
    if group >= joint_groups[0] {
        return;
    }
    let first = joint_groups[1u + group];
    let end = joint_groups[2u + group];
    for (var at = first; at < end; at++) {
        begin_joint(joint_groups[at]);
    }
    solve_group(first, end);
    for (var at = first; at < end; at++) {
        let row = joint_groups[at];
        let shift = joint_corrections[row].xyz;
        note_correction(row, JointCorrection(shift, sqrt(dot3(shift, shift))));
    }
}

/// Conjugate residuals, as in joints.rs.
fn solve_group(first: u32, end: u32) {
    apply_matrix(first, end, JOINT_RESIDUAL, JOINT_AR);
    for (var at = first; at < end; at++) {
        let row = joint_groups[at];
        put_joint_field(row, JOINT_DIRECTION, joint_field(row, JOINT_RESIDUAL));
        put_joint_field(row, JOINT_AP, joint_field(row, JOINT_AR));
    }
    var slope = joint_product(first, end, JOINT_RESIDUAL, JOINT_AR);
    let enough = slope * (EPSILON * EPSILON);
    for (var round = 0u; round < GROUP_ROUNDS; round++) {
        let squared = joint_product(first, end, JOINT_AP, JOINT_AP);
        if slope <= enough || squared <= 0.0 {
            break;
        }
        let alpha = slope / squared;
        for (var at = first; at < end; at++) {
            let row = joint_groups[at];
            if is_active_joint(row) {
                joint_corrections[row] += vec4f(joint_field(row, JOINT_DIRECTION) * alpha, 0.0);
                put_joint_field(row, JOINT_RESIDUAL, joint_field(row, JOINT_RESIDUAL) - joint_field(row, JOINT_AP) * alpha);
            }
        }
        apply_matrix(first, end, JOINT_RESIDUAL, JOINT_AR);
        let next = joint_product(first, end, JOINT_RESIDUAL, JOINT_AR);
        let beta = next / slope;
        slope = next;
        for (var at = first; at < end; at++) {
            let row = joint_groups[at];
            if is_active_joint(row) {
                let direction = joint_field(row, JOINT_RESIDUAL) + joint_field(row, JOINT_DIRECTION) * beta;
                put_joint_field(row, JOINT_DIRECTION, direction);
                put_joint_field(row, JOINT_AP, joint_field(row, JOINT_AR) + joint_field(row, JOINT_AP) * beta);
            }
        }
    }
}

/// The ball of a tether of a list, by its number.
fn ball_of(list: u32, number: u32) -> Ball {
    let center = old_position[attachment_lists[list + 1u + 2u * number]].xyz;
    return Ball(center, bitcast<f32>(attachment_lists[list + 2u + 2u * number]));
}

/// Moves a node into one ball of a list after the other, in rounds.
fn project_in_turn(x: vec3f, list: u32) -> HeldBack {
    var held = HeldBack(x, vec3f(0.0), 0u);
    let tethers = attachment_lists[list];
    for (var round = 0u; round < TETHER_ROUNDS; round++) {
        var moved = false;
        for (var i = 0u; i < tethers; i++) {
            let ball = ball_of(list, i);
            if excess(held.x, ball) > 0.0 {
                let back = project_to_sphere(held.x, ball);
                held = HeldBack(back.x, held.shift + back.shift, held.taut | (1u << i));
                moved = true;
            }
        }
        if !moved {
            break;
        }
    }
    return held;
}

/// A node after its tethers, whose list begins at `list`. Their anchors are pinned, and stay where they are.
fn apply_tethers(x: vec3f, v: vec3f, list: u32) -> Tethered {
    let tethers = attachment_lists[list];
    var held = HeldBack(x, vec3f(0.0), 0u);
    if tethers > 2u {
        held = project_in_turn(x, list);
    } else if tethers > 0u {
        held = project_to_two(x, ball_of(list, 0u), ball_of(list, tethers - 1u), tethers == 2u);
    }
    let at = held.x;
    let shift = held.shift;
    let taut = held.taut;
    if taut == 0u {
        return Tethered(x, v);
    }
    var sum = vec3f(0.0);
    for (var i = 0u; i < tethers; i++) {
        sum = select(sum, sum + old_velocity[attachment_lists[list + 1u + 2u * i]].xyz, ((taut >> i) & 1u) != 0u);
    }
    var speed = without_lost_motion(v, shift, sum / f32(countOneBits(taut)), substeps[0].h);
    for (var i = 0u; i < tethers; i++) {
        let anchor = attachment_lists[list + 1u + 2u * i];
        let kept = without_stretching(speed, at - old_position[anchor].xyz, old_velocity[anchor].xyz);
        speed = select(speed, kept, ((taut >> i) & 1u) != 0u);
    }
    return Tethered(at, speed);
}

/// Gives nodes that are joined or tethered their new velocities and places, and keeps those that it moves out of colliders
/// again; the others stay as they are.
@compute @workgroup_size(256)
fn apply_attachments(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let node = node_of(id, lane);
    if node >= arrayLength(&old_position) {
        return;
    }
    let x = old_position[node];
    let v = old_velocity[node];
    new_position[node] = x;
    new_velocity[node] = v;
    let list = attachment_lists[node];
    if list == NONE {
        return;
    }
    var at = list + 1u;
    var sum = vec3f(0.0);
    let end = at + attachment_lists[list];
    for (; at < end; at++) {
        let one = joint_corrections[attachment_lists[at] / 2u];
        sum = select(sum, sum + one.xyz * select(1.0, -1.0, attachment_lists[at] % 2u == 1u), one.w != 0.0);
    }
    var now = Tethered(x.xyz + sum * x.w, v.xyz + sum * (x.w / substeps[0].h));
    if x.w > 0.0 {
        now = apply_tethers(now.x, now.v, end);
    }
    if all(now.x == x.xyz) && all(now.v == v.xyz) {
        return;
    }
    resolve_contact_again(node, x, v, now.x, now.v);
}
