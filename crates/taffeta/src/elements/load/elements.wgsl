// Elements that several nodes share: hinges and torques. Nothing scatters; nodes gather in loads.wgsl.

/// A hinge: corners a, b, left, right; fold angle [rad] and Σ|∇θ|² [rad²/m²] at rest; stiffness [N·m/rad] and damping
/// [N·m·s/rad].
struct Hinge {
    corners: vec4u,
    rest_angle: f32,
    rest_steepness: f32,
    k: f32,
    damping: f32,
}

/// A force on some nodes, or a torque that they share.
struct Load {
    /// Force on each node [N], or unit axis.
    vector: vec3f,
    kind: u32,
    /// A point on the axis [m].
    about: vec3f,
    /// Moment [N·m].
    torque: f32,
    /// Where its nodes begin, and how many it has.
    first: u32,
    count: u32,
    /// What the vector, or each node's lever [N/m], is multiplied by in this sub-step.
    factor: f32,
}

const FORCE: u32 = 0u;
const TORQUE: u32 = 1u;

@group(0) @binding(2) var<storage, read> scales: array<f32>;
@group(1) @binding(4) var<storage, read> hinges: array<Hinge>;
@group(1) @binding(5) var<storage, read> load_nodes: array<u32>;
@group(3) @binding(2) var<storage, read_write> loads: array<Load>;
/// Force on each corner of each hinge [N], in xyz; then on all corners of each panel (air_stages.wgsl).
@group(3) @binding(3) var<storage, read_write> element_forces: array<vec4f>;

var<workgroup> lane_sums: array<f32, 256>;

fn fold_at(corners: vec4u) -> Fold {
    return fold_of(position_of(corners.x), position_of(corners.y), position_of(corners.z), position_of(corners.w));
}

@compute @workgroup_size(256)
fn bend_hinges(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = workgroup_index(id, counts) * 256u + lane;
    if index >= arrayLength(&hinges) {
        return;
    }
    let hinge = hinges[index];
    let fold = fold_at(hinge.corners);
    let rate = dot3(fold.at_a, velocity_of(hinge.corners.x)) + dot3(fold.at_b, velocity_of(hinge.corners.y))
        + dot3(fold.at_c, velocity_of(hinge.corners.z)) + dot3(fold.at_d, velocity_of(hinge.corners.w));
    let moment = hinge_moment(fold, rate, hinge.k, hinge.damping, hinge.rest_angle, hinge.rest_steepness);
    element_forces[4u * index] = vec4f(fold.at_a * -moment, 0.0);
    element_forces[4u * index + 1u] = vec4f(fold.at_b * -moment, 0.0);
    element_forces[4u * index + 2u] = vec4f(fold.at_c * -moment, 0.0);
    element_forces[4u * index + 3u] = vec4f(fold.at_d * -moment, 0.0);
}

/// A workgroup for each load: what its vector or its levers are multiplied by.
@compute @workgroup_size(256)
fn scale_loads(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = workgroup_index(id, counts);
    if index >= arrayLength(&loads) {
        return;
    }
    let scale = scales[substeps[0].first_scale + index];
    var sum = 0.0;
    if loads[index].kind == TORQUE {
        for (var i = lane; i < loads[index].count; i += 256u) {
            let x = position_of(load_nodes[loads[index].first + i]);
            let arm = lever(x, loads[index].vector, loads[index].about);
            sum += dot3(arm, arm);
        }
    }
    lane_sums[lane] = sum;
    for (var half = 128u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            lane_sums[lane] += lane_sums[lane + half];
        }
    }
    if lane == 0u {
        let torque = loads[index].torque * scale;
        loads[index].factor = select(scale, torque_factor(torque, lane_sums[0]), loads[index].kind == TORQUE);
    }
}
