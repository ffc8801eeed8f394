// Springs as constraints, on the device: the rows of all bodies' systems, 256 for each workgroup, and how far each system
// is. A body's rows and nodes are in groups of their own, so that any number of bodies shares a dispatch and each has steps of
// its own. Groups are summed up by halves, and the groups of a body the same way.

#import contact/colliders/predicted_contact.wgsl
#import gpu/wgsl/index.wgsl

/// A spring that is a constraint, always or where it is too long.
struct Constraint {
    a: u32,
    b: u32,
    /// Stiffness [N/m], damping [kg/s], length at rest [m].
    k: f32,
    damping: f32,
    rest_length: f32,
    /// Whether it is a constraint now: 1, else 0.
    is_active: u32,
}

/// Some constraints of one body, 256 at most.
struct ConstraintGroup {
    first: u32,
    count: u32,
    /// Which of the systems is the body's.
    solve: u32,
    /// The body's first group, and how many it has.
    first_group: u32,
    groups: u32,
}

/// Some nodes of one body, 256 at most.
struct NodeGroup {
    first: u32,
    count: u32,
    solve: u32,
    /// Where the body's groups of constraints begin.
    first_group: u32,
    /// 1 in the first group of a body, else 0.
    is_first: u32,
}

/// A row of the system with the vectors of the iteration, all by the row's scale.
struct Row {
    direction: vec3f,
    /// What is left of the right side; at first the pull to start from.
    r: f32,
    w: f32,
    /// At first the noise.
    s: f32,
    /// At first the right side.
    p: f32,
    x: f32,
}

/// A node, as constraints find it: how a surface holds it, and which of the colliders.
struct ContactRecord {
    normal: vec3f,
    slides: f32,
    velocity: vec3f,
    collider: u32,
    /// Whether any constraint acts on it: 1, else 0.
    is_constrained: u32,
    /// By how much it would be inside, if the surface is that of a mesh; else 0 [m].
    inside: f32,
    /// Velocity of the surface [m/s] in the direction in which the node slides.
    @size(8) surface_speed: f32,
}

/// How far a system is.
struct CgState {
    /// Times that the system was applied.
    passes: u32,
    is_done: u32,
    /// Squared residual at which it is done, and that of the right side.
    limit: f32,
    right: f32,
    /// Of the step: r·r, its length, the share of the last direction. At first, the length is by how much the pulls to start
    /// from are multiplied.
    gamma: f32,
    alpha: f32,
    beta: f32,
}

/// The system of a body.
struct Solve {
    /// Its constraints, and those that are active.
    constraints: u32,
    active_constraints: u32,
    /// As the rows left it, and as the nodes have found it since.
    kept: CgState,
    next: CgState,
}

/// What the systems of a segment have taken in this frame.
struct SolveStatistics {
    /// Most iterations, and sub-steps in which they were not enough for some system.
    iterations: u32,
    capped: u32,
    /// Largest share of constraints that were active, and largest squared residual by that of the right side.
    active_fraction: f32,
    residual: f32,
}

@group(1) @binding(20) var<storage, read> constraint_groups: array<ConstraintGroup>;
@group(1) @binding(21) var<storage, read> node_groups: array<NodeGroup>;
/// For each slice of 16 places where its entries begin, then those: 2·constraint + end, entry `i` of a lane at
/// start + 16·i + lane; NONE: no more.
@group(1) @binding(22) var<storage, read> incident: array<u32>;
@group(3) @binding(20) var<storage, read_write> constraints: array<Constraint>;
@group(3) @binding(21) var<storage, read_write> rows: array<Row>;
/// Scale and compliance of each row.
@group(3) @binding(22) var<storage, read_write> row_scales: array<vec2f>;
/// Active constraints of each body, from its first one's number on.
@group(3) @binding(23) var<storage, read_write> active_constraints: array<u32>;
/// Active constraints of each group.
@group(3) @binding(24) var<storage, read_write> active_counts: array<u32>;
@group(3) @binding(25) var<storage, read_write> solves: array<Solve>;
/// Of each group: r·r and r·A r; at first, with the right side b and the pulls x to start from, b·b, the noise, x·b
/// and x·A x.
@group(3) @binding(26) var<storage, read_write> row_sums: array<vec4f>;
/// What pulls do to each node's velocity, by the step [m/s²]; at first the velocity without them.
@group(3) @binding(27) var<storage, read_write> response: array<vec4f>;
/// Workgroups of the next iterations: over groups of nodes, over groups of constraints.
@group(3) @binding(28) var<storage, read_write> solve_counts: array<u32, 6>;
@group(3) @binding(29) var<storage, read_write> statistics: array<SolveStatistics>;
@group(3) @binding(30) var<storage, read_write> predicted_contacts: array<ContactRecord>;

var<workgroup> row_lanes: array<vec4f, 256>;
var<workgroup> count_lanes: array<u32, 256>;

/// Workgroups along x where they are counted on the device.
const COUNTED_ROW: u32 = 32768u;

/// The sum over all lanes: the upper half is added to the lower, again and again.
fn sum_of_rows(lane: u32, own: vec4f) -> vec4f {
    row_lanes[lane] = own;
    for (var half = 128u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            row_lanes[lane] += row_lanes[lane + half];
        }
    }
    workgroupBarrier();
    return row_lanes[0];
}

/// The larger of all lanes, each number for itself.
fn most_of_rows(lane: u32, own: vec4f) -> vec4f {
    row_lanes[lane] = own;
    for (var half = 128u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            row_lanes[lane] = max(row_lanes[lane], row_lanes[lane + half]);
        }
    }
    workgroupBarrier();
    return row_lanes[0];
}

/// The sums over the rows of a body.
fn sums_of_body(first_group: u32, active_count: u32, lane: u32) -> vec4f {
    var own = vec4f(0.0);
    for (var i = lane; i * 256u < active_count; i += 256u) {
        own += row_sums[first_group + i];
    }
    return sum_of_rows(lane, own);
}

/// The active ones among the lanes up to and with this one.
fn count_up_to(lane: u32, own: u32) -> u32 {
    count_lanes[lane] = own;
    for (var reach = 1u; reach < 256u; reach *= 2u) {
        workgroupBarrier();
        let before = select(0u, count_lanes[max(lane, reach) - reach], lane >= reach);
        workgroupBarrier();
        count_lanes[lane] += before;
    }
    workgroupBarrier();
    return count_lanes[lane];
}

/// The sum over all lanes.
fn count_of_lanes(lane: u32, own: u32) -> u32 {
    count_lanes[lane] = own;
    for (var half = 128u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            count_lanes[lane] += count_lanes[lane + half];
        }
    }
    workgroupBarrier();
    let sum = count_lanes[0];
    // The lanes are free for the next count.
    workgroupBarrier();
    return sum;
}

/// The number of a workgroup where they are counted on the device.
fn counted_index(id: vec3u) -> u32 {
    return id.x + id.y * COUNTED_ROW;
}

/// Where the entries of a node begin, and where those of its slice end.
fn entries_at(node: u32) -> vec2u {
    let slice = node / 16u;
    return vec2u(incident[slice] + node % 16u, incident[slice + 1u]);
}

fn predicted_in(record: ContactRecord) -> PredictedContact {
    return PredictedContact(record.normal, record.slides, record.velocity, record.surface_speed);
}

/// What is kept of a press by one of the colliders, on a node that constraints act on.
fn contact_record(predicted: PredictedContact, collider: u32, inside: f32) -> ContactRecord {
    return ContactRecord(predicted.normal, predicted.slides, predicted.velocity, collider, 1u, inside, predicted.surface_speed);
}

/// How a surface holds a node.
fn predicted_at(node: u32) -> PredictedContact {
    return predicted_in(predicted_contacts[node]);
}

/// The sign of a pull at the first or second end.
fn sign_at(entry: u32) -> f32 {
    return select(-1.0, 1.0, entry % 2u == 1u);
}

/// What pulls do to the velocity of a node, by the step and its inverse mass.
fn gather_constraint_forces(node: u32) -> vec3f {
    var sum = vec3f(0.0);
    let range = entries_at(node);
    for (var at = range.x; at < range.y && incident[at] != NONE; at += LANES) {
        let row = rows[incident[at] / 2u];
        sum += sign_at(incident[at]) * (row.direction * row.x);
    }
    return sum;
}
