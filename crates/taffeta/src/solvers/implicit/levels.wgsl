// Implicit springs on the device: multigrid levels of nodes, 256 for each workgroup, and the state of each body's solve.
// Nodes of all levels have numbers of one sort: places first, then those of each coarser level, bodies one after the other.
// A body's nodes are in groups of their own, so that any number of bodies shares a dispatch. Kernels of a level find its groups
// alone in `level_groups`.

#import gpu/wgsl/index.wgsl
#import gpu/wgsl/substep.wgsl
#import solvers/implicit/implicit.wgsl

/// Some nodes of one body on a level, 256 at most.
struct LevelGroup {
    first: u32,
    count: u32,
    /// Which of the systems is the body's.
    solve: u32,
    /// The body's first group here, and how many it has.
    first_group: u32,
    groups: u32,
}

/// The spring of a slot; of one that has none, nothing.
struct SlotSpring {
    /// Stiffness [N/m], damping [kg/s], length at rest [m].
    k: f32,
    damping: f32,
    rest_length: f32,
}

/// The nodes that a node follows on the next coarser level, and how much; of those there are not, weights are 0.
struct Parents {
    nodes: vec4u,
    weights: vec4f,
}

/// An edge of a coarser level: its slots, counted from the first of all coarser levels, and which of the weights of finer
/// blocks are its own.
struct CoarseEdge {
    slots: vec2u,
    first: u32,
    count: u32,
}

/// An index and its weight.
struct WeightedIndex {
    at: u32,
    weight: f32,
}

/// The block of a node with itself: what is not of edges, and the inverse of all.
struct Diagonal {
    own: Symmetric,
    inverse: Symmetric,
}

/// State of preconditioned conjugate gradients on a system.
struct PcgState {
    /// Times that the system was applied.
    passes: u32,
    is_done: u32,
    /// In this Newton step.
    iterations: u32,
    /// What errors are measured by: the larger of Σ m |v* − v|² and the first r·z.
    whole: f32,
    /// r·z of the residual r, by the preconditioner z ≈ A⁻¹ r: about eᵀ A e of the error e.
    error: f32,
    /// Of the step: its length, the share of the last direction. At first, the length is by how much the changes to start
    /// from are multiplied.
    alpha: f32,
    beta: f32,
}

/// The system of a body.
struct NodeSolve {
    /// Newton steps that are done, and their iterations; whether the equations are met, so that no other step follows.
    steps: u32,
    before: u32,
    is_met: u32,
    /// The first of the systems that contacts and seams join with it.
    first: u32,
    /// Of it and of what is joined with it, twice its energy [J].
    motion: f32,
    /// As products left it, and as steps have found it since.
    kept: PcgState,
    next: PcgState,
}

/// What elements give a node: impulse [N s], and the sum of their blocks.
struct ElementSums {
    impulse: vec3f,
    diagonal: Symmetric,
}

@group(1) @binding(40) var<storage, read> level_groups: array<LevelGroup>;
/// Where here the first slot of the coarser levels is; for each slice of 16 nodes where its slots begin, and where the last
/// one's end; then the node at the other end of each slot, that of entry `i` of a lane at start + 16·i + lane. Slots without
/// an edge lead to the node itself.
@group(1) @binding(41) var<storage, read> slots: array<u32>;
/// By slot of the finest level.
@group(1) @binding(42) var<storage, read> slot_springs: array<SlotSpring>;
@group(1) @binding(43) var<storage, read> parents: array<Parents>;
/// For each node where here its children begin, in `at`, and where the last one's end; then children, nodes of the finer
/// level.
@group(1) @binding(44) var<storage, read> children: array<WeightedIndex>;
/// Edges of one level.
@group(1) @binding(45) var<storage, read> coarse_edges: array<CoarseEdge>;
/// Slots of the finer level, counted from its sort's first.
@group(1) @binding(46) var<storage, read> edge_weights: array<WeightedIndex>;
/// What is counted: how many workgroups there are, and when they run. First by level those of iterations, those of the tail last.
@group(1) @binding(47) var<storage, read> level_sizes: array<vec2u>;
/// By slot of the finest level: q, and the stiffness across in w.
@group(3) @binding(40) var<storage, read_write> spring_blocks: array<vec4f>;
/// By slot of coarser levels.
@group(3) @binding(41) var<storage, read_write> coarse_blocks: array<Symmetric>;
@group(3) @binding(42) var<storage, read_write> diagonals: array<Diagonal>;
/// Vectors by node, one sort behind the other.
@group(3) @binding(43) var<storage, read_write> vectors: array<vec4f>;
@group(3) @binding(44) var<storage, read_write> node_solves: array<NodeSolve>;
/// Of each group: z·r and z·A z; at first, with the changes z to start from, and then Σ m |v* − v|². Behind those of all groups
/// two more sorts, the motion (newton.wgsl).
@group(3) @binding(45) var<storage, read_write> product_sums: array<vec4f>;
/// Workgroups of what comes next, as in `level_sizes`; three words each.
@group(3) @binding(46) var<storage, read_write> level_counts: array<u32>;

/// Newton steps in a sub-step at most.
const MOST_STEPS: u32 = 8u;
/// Energy that Newton steps may leave, relative to that of the motion.
const LEFT: f32 = 0.01;

/// Whether the solver, where it finds how many Newton steps it takes, may take a further one for a system: not after one that ran out
/// of iterations.
fn may_go_on(solve: NodeSolve) -> bool {
    let has_iterations = solve.next.iterations < substeps[0].solving.most_iterations;
    return solve.is_met == 0u && has_iterations && solve.steps < MOST_STEPS - 1u;
}

/// Steps that are written down: at how many places this solve has counted open systems, and at which there were some last; the last
/// such place of all solves of a frame; whether one had systems left that more steps would have gone on with.
@group(3) @binding(49) var<storage, read_write> written_steps: array<u32>;
const PLACE: u32 = 0u;
const OPEN_AT: u32 = 1u;
const MOST_OPEN_AT: u32 = 2u;
const IS_LEFT: u32 = 3u;

/// Number of sorts of vectors.
const VECTORS: u32 = 15u;
/// The residual, filtered by what holds nodes; mass [kg] in w.
const RESIDUAL: u32 = 0u;
/// The V-cycle's two vectors, by turns: CYCLED is the preconditioned residual after it, and before the first one the initial
/// guess.
const CYCLE: u32 = 1u;
const CYCLED: u32 = 2u;
/// Change of velocity [m/s] in this Newton step.
const CHANGE: u32 = 3u;
/// Direction of the step, and the system times it; while the system is set up, place and velocity that it starts from.
const DIRECTION: u32 = 4u;
const DIRECTION_PRODUCT: u32 = 5u;
/// The system times the preconditioned residual.
const PRODUCT: u32 = 6u;
/// Impulse of springs where the Newton step starts [N s].
const IMPULSE: u32 = 7u;
/// Change of velocity [m/s], from that without springs to that where the Newton step starts; at first with m |v* − v|² in w.
const TOTAL: u32 = 8u;
/// Change of velocity [m/s] by springs in the last sub-step: the warm start.
const SPRING_CHANGE: u32 = 9u;
/// Where the node comes to without velocity [m], and its velocity without springs [m/s].
const START: u32 = 10u;
const FREE: u32 = 11u;
/// Acceleration [m/s²], at second order.
const RATE: u32 = 12u;
/// Impulse of springs with what the Newton step changes [N s].
const GIVEN: u32 = 13u;
/// What contacts of surfaces take back of a vector.
const TAKEN: u32 = 14u;

/// When workgroups run that are counted: in iterations; where a further Newton step begins.
const ITERATED: u32 = 0u;
const BEGUN: u32 = 1u;

/// Damping of Jacobi's iteration: no eigenvalue of a graph's matrix is beyond 2 by its diagonal.
const DAMPING: f32 = 0.7;
/// Steps of Jacobi's iteration on the coarsest level, by two.
const SWEEPS: u32 = 4u;

/// Workgroups of one sort: all or none.
fn put_counts(lane: u32, when: u32, any: bool) {
    for (var i = lane; i < arrayLength(&level_sizes); i += 256u) {
        if level_sizes[i].y == when {
            let groups = level_sizes[i].x;
            level_counts[3u * i] = select(0u, min(groups, GROUPS_IN_ROW), any);
            level_counts[3u * i + 1u] = (groups + GROUPS_IN_ROW - 1u) / GROUPS_IN_ROW;
            level_counts[3u * i + 2u] = 1u;
        }
    }
}

/// Where a vector's number of a node is.
fn vector_at(which: u32, node: u32) -> u32 {
    return which * (arrayLength(&vectors) / VECTORS) + node;
}

/// A vector at a node.
fn vector_of(which: u32, node: u32) -> vec3f {
    return vectors[vector_at(which, node)].xyz;
}

fn put_vector(which: u32, node: u32, v: vec3f) {
    vectors[vector_at(which, node)] = vec4f(v, 0.0);
}

/// Where the slots of a node begin, and where those of its slice end.
fn slots_of(node: u32) -> vec2u {
    let slice = node / 16u;
    return vec2u(slots[1u + slice] + node % 16u, slots[2u + slice]);
}

/// Mass of a node on the finest level [kg].
fn mass_of(node: u32) -> f32 {
    return vectors[vector_at(RESIDUAL, node)].w;
}

/// Masses and springs of the finest level times a vector, at a node; nothing holds it.
fn springs_times(mass: f32, which: u32, node: u32) -> vec3f {
    let own = vector_of(which, node);
    var sum = mass * own;
    let range = slots_of(node);
    let first = slots[1];
    for (var at = range.x; at < range.y; at += LANES) {
        let linear = spring_blocks[at - first];
        sum = add_block_times(sum, linear.xyz, linear.w, own - vector_of(which, slots[at]));
    }
    return sum;
}

/// A damped step of Jacobi's iteration for a residual.
fn jacobi_step(node: u32, residual: vec3f) -> vec3f {
    return times(diagonals[node].inverse, DAMPING * residual);
}

/// What a node's children give it of their diagonals, beside edges and couplings.
fn own_of_children(node: u32) -> Symmetric {
    let last = children[node + 1u].at;
    var own = Symmetric(vec3f(0.0), vec3f(0.0));
    for (var i = children[node].at; i < last; i++) {
        own = sum_of(own, scaled(diagonals[children[i].at].own, children[i].weight));
    }
    return own;
}

/// Restriction: the right side of a node, from the residuals of its children.
fn sum_of_children(node: u32) -> vec3f {
    let last = children[node + 1u].at;
    var sum = vec3f(0.0);
    for (var i = children[node].at; i < last; i++) {
        sum += children[i].weight * vector_of(CYCLED, children[i].at);
    }
    return sum;
}

/// What a node follows of the coarser level's answer.
fn sum_of_parents(node: u32) -> vec3f {
    let above = parents[node];
    return above.weights.x * vector_of(CYCLED, above.nodes.x)
        + above.weights.y * vector_of(CYCLED, above.nodes.y)
        + above.weights.z * vector_of(CYCLED, above.nodes.z)
        + above.weights.w * vector_of(CYCLED, above.nodes.w);
}
