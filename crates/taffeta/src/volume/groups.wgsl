// Bodies that keep their volume, a group of 256 nodes for each workgroup. Groups are summed up by halves, and the groups of
// a body the same way, as the CPU does (cpu.rs): nothing depends on which workgroup comes first, and any number of
// bodies shares a dispatch.

#import gpu/wgsl/force.wgsl
#import gpu/wgsl/goals.wgsl
#import gpu/wgsl/substep.wgsl
#import volume/volume.wgsl
#import memory

/// Some nodes of one body, 256 at most.
struct VolumeGroup {
    /// Its first node, and how many it has.
    first: u32,
    count: u32,
    /// Where its gradients begin in `force`.
    gradients: u32,
    /// The body's first node, from which places are counted.
    origin: u32,
    /// The body's first group, and how many it has.
    first_group: u32,
    groups: u32,
    /// Which of a sub-step's volumes is the body's.
    goal: u32,
    form: u32,
    /// WEIGHTED, RESTORED.
    flags: u32,
}

/// In a group's flags: its nodes have weights.
const WEIGHTED: u32 = 1u;
/// In a group's flags: nodes are moved after contact.
const RESTORED: u32 = 2u;

@group(1) @binding(12) var<storage, read> volume_groups: array<VolumeGroup>;
/// What groups have summed up, part after part, each for all groups. First 3 V, Σ g·v*, D, and the body's goal in w at its
/// first group; then from where places are counted, there alone; then what weights need.
@group(3) @binding(12) var<storage, read_write> volume_sums: array<vec4f>;

/// Parts of `volume_sums`: those of `VolumeSums` in their order, with the origin behind the first.
const VOLUME_PARTS: u32 = 7u;

var<workgroup> volume_lanes: array<vec4f, 256>;

/// The sum over all lanes: the upper half is added to the lower, again and again.
fn sum_of_lanes(lane: u32, own: vec4f) -> vec4f {
    volume_lanes[lane] = own;
    for (var half = 128u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            volume_lanes[lane] += volume_lanes[lane + half];
        }
    }
    workgroupBarrier();
    let sum = volume_lanes[0];
    // The lanes are free for the next sum.
    workgroupBarrier();
    return sum;
}

/// Whether the group has a flag.
fn is_flagged(group: VolumeGroup, flag: u32) -> bool {
    return (group.flags & flag) != 0u;
}

fn put_part(part: u32, index: u32, lane: u32, own: vec4f) {
    let sum = sum_of_lanes(lane, own);
    if lane == 0u {
        volume_sums[part * arrayLength(&volume_groups) + index] = sum;
    }
}

/// Sums up a group; lanes past its nodes bring a node that adds nothing.
fn sum_up(index: u32, group: VolumeGroup, lane: u32, node: VolumeNode) {
    let is_first = index == group.first_group && lane == 0u;
    let goal = select(0.0, goals[substeps[0].first_goal + group.goal], is_first);
    if !is_flagged(group, WEIGHTED) {
        put_part(0u, index, lane, vec4f(volume_terms(node), goal));
        return;
    }
    let terms = weighted_terms(node);
    put_part(0u, index, lane, vec4f(terms.plain, goal));
    put_part(2u, index, lane, vec4f(terms.moment, terms.mass));
    put_part(3u, index, lane, vec4f(terms.diagonal, terms.held));
    put_part(4u, index, lane, vec4f(terms.other, 0.0));
    put_part(5u, index, lane, vec4f(terms.weighted_gradient, 0.0));
    put_part(6u, index, lane, vec4f(terms.turn, 0.0));
    if is_first {
        volume_sums[arrayLength(&volume_groups) + index] = vec4f(position_of(group.origin), 0.0);
    }
}

/// A part of the sums over the body to which a group belongs.
fn part_of_body(part: u32, group: VolumeGroup, lane: u32) -> vec4f {
    let first = part * arrayLength(&volume_groups) + group.first_group;
    if group.groups == 1u {
        return volume_sums[first];
    }
    var own = vec4f(0.0);
    for (var i = lane; i < group.groups; i += 256u) {
        own += volume_sums[first + i];
    }
    return sum_of_lanes(lane, own);
}

/// What moves a body: its push, its sums 3 V, Σ g·v* and D, and its goal.
struct Found {
    correction: VolumeCorrection,
    sums: vec3f,
    goal: f32,
}

/// What moves the body to which a group belongs; λ is still to be found.
fn find_correction(group: VolumeGroup, lane: u32) -> Found {
    let plain = part_of_body(0u, group, lane);
    if !is_flagged(group, WEIGHTED) {
        return Found(VolumeCorrection(vec3f(0.0), 0.0, vec3f(0.0), vec3f(0.0)), plain.xyz, plain.w);
    }
    let moment = part_of_body(2u, group, lane);
    let diagonal = part_of_body(3u, group, lane);
    let sums = VolumeSums(
        plain.xyz, moment.w, moment.xyz, diagonal.xyz, diagonal.w,
        part_of_body(4u, group, lane).xyz, part_of_body(5u, group, lane).xyz, part_of_body(6u, group, lane).xyz,
    );
    return Found(rigid_correction(sums), plain.xyz, plain.w);
}

/// −u of a node at `x` with the mass `mass`.
fn direction_of(group: VolumeGroup, correction: VolumeCorrection, lane: u32, x: vec3f, mass: f32) -> vec3f {
    let gradient = force[group.gradients + lane];
    if !is_flagged(group, WEIGHTED) {
        return -gradient.xyz;
    }
    let origin = volume_sums[arrayLength(&volume_groups) + group.first_group].xyz;
    return correction_direction(correction, x - origin, gradient.xyz, gradient.w, mass);
}
