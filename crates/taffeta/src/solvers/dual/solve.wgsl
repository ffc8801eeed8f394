// Springs as constraints on the device: the rows of all bodies' systems, 256 in each workgroup, and the state of each
// solve. The rows and nodes of a body are in groups of their own, so that any number of bodies shares a dispatch and
// each system has its own steps. Groups are summed up by halves, and the groups of a body the same way.

#import contact/colliders/predicted_contact.wgsl
#import gpu/wgsl/index.wgsl

/// A spring that is a constraint, always or when it is too long.
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
    /// The number of the body's system.
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

/// A row of the system with the vectors of the iteration, all scaled by the row's scale.
struct Row {
    direction: vec3f,
    /// The residual; at first the warm start.
    r: f32,
    w: f32,
    /// At first the noise.
    s: f32,
    /// At first the right side.
    p: f32,
    x: f32,
}

/// The predicted contact of a node.
struct ContactRecord {
    normal: vec3f,
    slides: f32,
    velocity: vec3f,
    collider: u32,
    /// Whether any constraint acts on it: 1, else 0.
    is_constrained: u32,
    /// Predicted depth in a mesh; 0 for any other collider [m].
    inside: f32,
    /// Velocity of the surface [m/s] in the direction in which the node slides.
    @size(8) surface_speed: f32,
}

/// The state of conjugate gradients on a system.
struct CgState {
    /// Number of products with the matrix.
    passes: u32,
    is_done: u32,
    /// Squared residual at which it has converged, and that of the right side.
    limit: f32,
    right: f32,
    /// Of the step: r·r, its length, the factor of the last direction. At first, the length is the factor of the warm
    /// start.
    gamma: f32,
    alpha: f32,
    beta: f32,
}

/// The system of a body.
struct Solve {
    /// Its constraints, and those that are active.
    constraints: u32,
    active_constraints: u32,
    /// As the rows left it, and as the nodes have computed it since.
    kept: CgState,
    next: CgState,
}

/// Statistics of the solves of a partition in this frame.
struct SolveStatistics {
    /// Most iterations, and sub-steps in which they did not suffice for some system.
    iterations: u32,
    capped: u32,
    /// Largest fraction of active constraints, and largest squared residual relative to the right side.
    active_fraction: f32,
    residual: f32,
}

@group(1) @binding(20) var<storage, read> constraint_groups: array<ConstraintGroup>;
@group(1) @binding(21) var<storage, read> node_groups: array<NodeGroup>;
/// For each slice of 16 places where its entries begin, then the entries: 2·constraint + end. Entry `i` of a lane is
/// at start + 16·i + lane; NONE ends it.
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
/// Of each group: r·r and r·A r. At first, with the right side b and the warm start x: b·b, the noise, x·b and x·A x.
@group(3) @binding(26) var<storage, read_write> row_sums: array<vec4f>;
/// The velocity change of each node by constraint forces, divided by the sub-step [m/s²]; at first the velocity
/// without them.
@group(3) @binding(27) var<storage, read_write> response: array<vec4f>;
/// Workgroups of the next iterations: over groups of nodes, over groups of constraints.
@group(3) @binding(28) var<storage, read_write> solve_counts: array<u32, 6>;
@group(3) @binding(29) var<storage, read_write> statistics: array<SolveStatistics>;
@group(3) @binding(30) var<storage, read_write> predicted_contacts: array<ContactRecord>;

var<workgroup> row_lanes: array<vec4f, 256>;
var<workgroup> count_lanes: array<u32, 256>;

/// The sum over all lanes: the upper half is added to the lower, repeatedly.
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

/// The maximum over all lanes, of each number.
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

/// The number of active lanes up to this one, inclusive.
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

/// Where the entries of a node begin, and where the slice of the node ends.
fn entries_at(node: u32) -> vec2u {
    let slice = node / 16u;
    return vec2u(incident[slice] + node % 16u, incident[slice + 1u]);
}

fn predicted_in(record: ContactRecord) -> PredictedContact {
    return PredictedContact(record.normal, record.slides, record.velocity, record.surface_speed);
}

/// The record of a predicted contact with a collider, at a node with constraints.
fn contact_record(predicted: PredictedContact, collider: u32, inside: f32) -> ContactRecord {
    return ContactRecord(predicted.normal, predicted.slides, predicted.velocity, collider, 1u, inside, predicted.surface_speed);
}

/// The predicted contact of a node.
fn predicted_at(node: u32) -> PredictedContact {
    return predicted_in(predicted_contacts[node]);
}

/// The sign of a constraint force at the first or second end.
fn sign_at(entry: u32) -> f32 {
    return select(-1.0, 1.0, entry % 2u == 1u);
}

/// The velocity change of a node by constraint forces, divided by the sub-step and its inverse mass.
fn gather_constraint_forces(node: u32) -> vec3f {
    var sum = vec3f(0.0);
    let range = entries_at(node);
    for (var at = range.x; at < range.y && incident[at] != NONE; at += LANES) {
        let row = rows[incident[at] / 2u];
        sum += sign_at(incident[at]) * (row.direction * row.x);
    }
    return sum;
}
