// Joints and tethers. Each kernel reads the state after the sub-step; the last one writes it anew, where that before was.

/// A pair of a seam, or a node at the point of a pin that can break.
struct Joint {
    /// Where the point starts [m], and the track that it follows; NONE: it rests.
    point: vec3f,
    track: u32,
    /// Its nodes; the second NONE: the point.
    a: u32,
    b: u32,
    /// Distance at the start, and once closed [m].
    start: f32,
    end: f32,
    /// [m/N]
    compliance: f32,
    /// [N]
    break_force: f32,
    /// Where in the goals of a sub-step the share is of its closing that has gone by.
    @size(8) closing: u32,
}

@group(1) @binding(60) var<storage, read> joints: array<Joint>;
/// Where the list of each place begins, or NONE. A list: how many joints; twice the number of each, one more at its second
/// node; how many tethers; the anchor of each, and its length [m] as bits.
@group(1) @binding(61) var<storage, read> attached: array<u32>;
/// Of each joint, whether it is broken.
@group(3) @binding(60) var<storage, read_write> joint_broken: array<u32>;
/// Joints that each place has left.
@group(3) @binding(61) var<storage, read_write> joints_left: array<u32>;
/// What each joint does to its first node, as `Pull`; in w whether it does anything.
@group(3) @binding(62) var<storage, read_write> pulls: array<vec4f>;

/// Counts the joints that each place has left.
@compute @workgroup_size(256)
fn count_joints(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let node = node_of(id, counts, lane);
    if node >= arrayLength(&joints_left) {
        return;
    }
    let list = attached[node];
    if list == NONE {
        return;
    }
    let end = list + 1u + attached[list];
    var left = 0u;
    for (var at = list + 1u; at < end; at++) {
        left += 1u - joint_broken[attached[at] / 2u];
    }
    joints_left[node] = left;
}

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

/// Finds what each joint does, and which of them break.
@compute @workgroup_size(256)
fn pull_joints(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let row = node_of(id, counts, lane);
    if row >= arrayLength(&joints) {
        return;
    }
    let joint = joints[row];
    let a = old_position[joint.a];
    let b = second_end(joint);
    let left = vec2u(joints_left[joint.a], joints_left[select(joint.b, joint.a, joint.b == NONE)]);
    let h = substeps[0].h;
    let goal = joint_length(joint.start, joint.end, goals[substeps[0].first_goal + joint.closing]);
    let pull = pull_of(a.xyz - b.xyz, goal, give_of(vec2f(a.w, b.w), left), joint.compliance / (h * h));
    let breaks = joint_broken[row] != 0u || pull.size / (h * h) > joint.break_force;
    joint_broken[row] = select(0u, 1u, breaks);
    pulls[row] = select(vec4f(pull.shift, 1.0), vec4f(0.0), breaks);
}

/// A node after its tethers, whose list begins at `list`. What they lead to is held, and stays where it is.
fn held_near(x: vec3f, v: vec3f, list: u32) -> Tethered {
    var at = x;
    var shift = vec3f(0.0);
    var taut = 0u;
    let tethers = attached[list];
    for (var round = 0u; round < TETHER_ROUNDS; round++) {
        var moved = false;
        for (var i = 0u; i < tethers; i++) {
            let anchor = attached[list + 1u + 2u * i];
            let back = put_back(at, old_position[anchor].xyz, bitcast<f32>(attached[list + 2u + 2u * i]));
            at = back.x;
            shift = select(shift, shift + back.way, back.moved);
            taut = select(taut, taut | (1u << i), back.moved);
            moved = moved || back.moved;
        }
        if !moved || tethers == 1u {
            break;
        }
    }
    if taut == 0u {
        return Tethered(x, v);
    }
    var sum = vec3f(0.0);
    for (var i = 0u; i < tethers; i++) {
        sum = select(sum, sum + old_velocity[attached[list + 1u + 2u * i]].xyz, ((taut >> i) & 1u) != 0u);
    }
    var speed = undone(v, shift, sum / f32(countOneBits(taut)), substeps[0].h);
    for (var i = 0u; i < tethers; i++) {
        let anchor = attached[list + 1u + 2u * i];
        let kept = kept_taut(speed, at - old_position[anchor].xyz, old_velocity[anchor].xyz);
        speed = select(speed, kept, ((taut >> i) & 1u) != 0u);
    }
    return Tethered(at, speed);
}

/// Gives nodes that are joined or tethered their new velocities and places, and keeps those that it moves out of colliders
/// again; the others stay as they are.
@compute @workgroup_size(256)
fn attach_nodes(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let node = node_of(id, counts, lane);
    if node >= arrayLength(&old_position) {
        return;
    }
    let x = old_position[node];
    let v = old_velocity[node];
    new_position[node] = x;
    new_velocity[node] = v;
    let list = attached[node];
    if list == NONE {
        return;
    }
    var at = list + 1u;
    var sum = vec3f(0.0);
    let end = at + attached[list];
    for (; at < end; at++) {
        let one = pulls[attached[at] / 2u];
        sum = select(sum, sum + one.xyz * select(1.0, -1.0, attached[at] % 2u == 1u), one.w != 0.0);
    }
    var now = Tethered(x.xyz + sum * x.w, v.xyz + sum * (x.w / substeps[0].h));
    if x.w > 0.0 {
        now = held_near(now.x, now.v, end);
    }
    if all(now.x == x.xyz) && all(now.v == v.xyz) {
        return;
    }
    touch_again(node, x, v, now.x, now.v);
}
