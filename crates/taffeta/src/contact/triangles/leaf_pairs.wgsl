// Two leaves, and the pairs of their triangles, edges and vertices that may come near each other.

#import contact/triangles/closest.wgsl
#import contact/triangles/surfaces.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/vector.wgsl

/// Thickness of neighbours along the surface, at most, relative to their distance at the start.
const NEIGHBOURS: f32 = 0.5;

/// Invocations that look at a pair of leaves. Most pairs have little that is near, and in narrow workgroups fewer wait for the others.
const LEAF_LANES: u32 = 64u;

/// Two leaves at which a workgroup looks: their words, and their nodes' places before and after.
var<workgroup> leaf_words: array<u32, 112>;
var<workgroup> ring_words: array<u32, 16>;
var<workgroup> before: array<vec3f, 32>;
var<workgroup> after: array<vec3f, 32>;
/// Vertices, triangles and edges of each that are near the box around the other, in any order: how many, and their numbers.
var<workgroup> near_counts: array<atomic<u32>, 6>;
var<workgroup> near_numbers: array<u32, 96>;

/// A pair of a vertex and a triangle, or of two edges, of two leaves: its nodes by lanes, those of the second leaf from 16 on; which
/// lanes of each leaf are among them; how many are its first side, and what it is in the order of contacts.
struct Candidate {
    lanes: vec4u,
    bits: vec2u,
    first: u32,
    order: u32,
}

/// A pair of leaves, the numbers of its pairs of each kind, thickness and friction, and how many pairs there are to look at.
struct LeafPair {
    pair: vec4u,
    counts: vec3u,
    material: vec2f,
    count: u32,
}

/// Loads the pair of leaves of a workgroup. All its invocations call it; those in rows of workgroups beyond the last pair look at
/// none.
fn load_leaves(id: vec3u, lane: u32) -> LeafPair {
    let index = min(workgroup_index(id), counted(PAIRS) - 1u);
    let pair = surface_pairs[index];
    for (var word = lane; word < 2u * LEAF_WORDS; word += LEAF_LANES) {
        leaf_words[word] = leaf_word(select(pair.x, pair.y, word >= LEAF_WORDS), word % LEAF_WORDS);
    }
    if lane >= 32u && lane < 48u {
        ring_words[lane - 32u] = surface_tables[table(RINGS_AT) + 16u * pair.z + lane - 32u];
    }
    if lane < 32u {
        let node = leaf_word(select(pair.x, pair.y, lane >= 16u), lane % 16u);
        before[lane] = place_at(BEFORE, node);
        after[lane] = place_at(AFTER, node);
    }
    workgroupBarrier();
    for (var slot = lane; slot < 96u; slot += LEAF_LANES) {
        list_near(slot / 48u, slot % 48u, select(pair.x, pair.y, slot < 48u), bitcast<f32>(pair.w));
    }
    workgroupBarrier();
    let counts = candidate_count(pair.x == pair.y);
    let material = material_of(leaf_words[LEAF_MATERIAL], leaf_words[LEAF_WORDS + LEAF_MATERIAL]);
    let count = select(0u, counts.x + counts.y + counts.z, index == workgroup_index(id));
    return LeafPair(pair, counts, material, count);
}

/// Where the numbers of a leaf's vertices (0), triangles (1) and edges (2) begin.
fn near_at(second: u32, kind: u32) -> u32 {
    return 48u * second + select(8u + 8u * kind, 0u, kind == 0u);
}

/// Lists a vertex, a triangle or an edge of a leaf, if it is near the box around another leaf.
fn list_near(second: u32, slot: u32, other: u32, reach: f32) {
    let counts = counts_in(second);
    let kind = select(select(2u, 1u, slot < 24u), 0u, slot < 16u);
    let number = slot - near_at(0u, kind);
    if number >= select(select(counts.y, counts.x, kind == 1u), counts.z, kind == 0u) {
        return;
    }
    var lanes = vec3u(vertex_in(second, number % 16u));
    if kind == 1u {
        lanes = triangle_in(second, number);
    } else if kind == 2u {
        lanes = edge_in(second, number).xyy;
    }
    lanes += 16u * second;
    let low = min(before[lanes.x], min(before[lanes.y], before[lanes.z]));
    let high = max(before[lanes.x], max(before[lanes.y], before[lanes.z]));
    let gap = max(max(surface_boxes[4u * other].xyz - high, low - surface_boxes[4u * other + 1u].xyz), vec3f(0.0));
    if dot3(gap, gap) < reach * reach {
        near_numbers[near_at(second, kind) + atomicAdd(&near_counts[3u * second + kind], 1u)] = number;
    }
}

/// One of them.
fn near_number(second: u32, kind: u32, index: u32) -> u32 {
    return near_numbers[near_at(second, kind) + index];
}

fn near_count(second: u32, kind: u32) -> u32 {
    return atomicLoad(&near_counts[3u * second + kind]);
}

/// How many triangles, edges and vertices a leaf has, the first or the second.
fn counts_in(second: u32) -> vec3u {
    let at = second * LEAF_WORDS + LEAF_COUNTS;
    let packed = leaf_words[at];
    return vec3u(packed & 255u, (packed >> 8u) & 255u, packed >> 16u);
}

/// Lanes of a vertex, a triangle or an edge of a leaf.
fn vertex_in(second: u32, number: u32) -> u32 {
    return (leaf_words[second * LEAF_WORDS + LEAF_VERTICES + number / 4u] >> (8u * (number % 4u))) & 255u;
}

fn triangle_in(second: u32, number: u32) -> vec3u {
    let packed = leaf_words[second * LEAF_WORDS + LEAF_TRIANGLES + number];
    return vec3u(packed & 255u, (packed >> 8u) & 255u, packed >> 16u);
}

fn edge_in(second: u32, number: u32) -> vec2u {
    let packed = leaf_words[second * LEAF_WORDS + LEAF_EDGES + number];
    return vec2u(packed & 255u, packed >> 8u);
}

/// Number of pairs of two leaves, which may be one: of what is near.
fn candidate_count(is_one: bool) -> vec3u {
    return vec3u(
        near_count(0u, 0u) * near_count(1u, 1u),
        select(near_count(0u, 1u) * near_count(1u, 0u), 0u, is_one),
        near_count(0u, 2u) * near_count(1u, 2u),
    );
}

/// A pair by its number.
fn candidate(number: u32, counts: vec3u) -> Candidate {
    if number < counts.x {
        let one = near_number(0u, 0u, number / near_count(1u, 1u));
        let other = near_number(1u, 1u, number % near_count(1u, 1u));
        let v = vertex_in(0u, one);
        let t = triangle_in(1u, other);
        return Candidate(
            vec4u(v, t + 16u), vec2u(1u << v, (1u << t.x) | (1u << t.y) | (1u << t.z)), 1u, (one << 8u) | other,
        );
    }
    if number < counts.x + counts.y {
        let one = near_number(0u, 1u, (number - counts.x) / near_count(1u, 0u));
        let other = near_number(1u, 0u, (number - counts.x) % near_count(1u, 0u));
        let t = triangle_in(0u, one);
        let v = vertex_in(1u, other);
        return Candidate(
            vec4u(v + 16u, t), vec2u((1u << t.x) | (1u << t.y) | (1u << t.z), 1u << v), 1u,
            (1u << 16u) | (one << 8u) | other,
        );
    }
    let one = near_number(0u, 2u, (number - counts.x - counts.y) / near_count(1u, 2u));
    let other = near_number(1u, 2u, (number - counts.x - counts.y) % near_count(1u, 2u));
    let e = edge_in(0u, one);
    let f = edge_in(1u, other);
    return Candidate(
        vec4u(e, f + 16u), vec2u((1u << e.x) | (1u << e.y), (1u << f.x) | (1u << f.y)), 2u,
        (2u << 16u) | (one << 8u) | other,
    );
}

/// Whether a mask has any pair of nodes of a candidate: 0 for nodes that are one, 8 for neighbours along the surface.
fn is_in_ring(one: Candidate, mask: u32) -> bool {
    var rows = 0u;
    for (var lane = 0u; lane < 16u; lane++) {
        let row = (ring_words[mask + lane / 2u] >> (16u * (lane % 2u))) & 0xffffu;
        rows |= select(0u, row, ((one.bits.x >> lane) & 1u) != 0u);
    }
    return (rows & one.bits.y) != 0u;
}

/// Whether a pair can come into contact: its sides do not hang together, and are not a collider and pinned nodes, of which neither
/// gives way. Pins that lag do, to each other.
fn may_touch(one: Candidate, has_ring: bool) -> bool {
    let any_collider = max(leaf_words[0], leaf_words[LEAF_WORDS]) >= table(NODE_PLACES);
    return (gives_way(one) || !any_collider) && !(has_ring && is_in_ring(one, 0u));
}

/// Whether any node of a pair is free.
fn gives_way(one: Candidate) -> bool {
    let free = (one.bits.x & ~leaf_words[LEAF_HELD]) | (one.bits.y & ~leaf_words[LEAF_WORDS + LEAF_HELD]);
    return free != 0u;
}

fn four_before(lanes: vec4u) -> array<vec3f, 4> {
    return array<vec3f, 4>(before[lanes.x], before[lanes.y], before[lanes.z], before[lanes.w]);
}

fn four_after(lanes: vec4u) -> array<vec3f, 4> {
    return array<vec3f, 4>(after[lanes.x], after[lanes.y], after[lanes.z], after[lanes.w]);
}

/// Whether the boxes around the sides of a pair are nearer to each other than that.
fn are_near(x: array<vec3f, 4>, first: u32, reach: f32) -> bool {
    let is_edge = first == 2u;
    let low = select(x[0], min(x[0], x[1]), is_edge);
    let high = select(x[0], max(x[0], x[1]), is_edge);
    let other_low = select(min(x[1], min(x[2], x[3])), min(x[2], x[3]), is_edge);
    let other_high = select(max(x[1], max(x[2], x[3])), max(x[2], x[3]), is_edge);
    let gap = max(max(other_low - high, low - other_high), vec3f(0.0));
    return dot3(gap, gap) < reach * reach;
}

/// Whether a candidate of two leaves is near enough, and may touch. Of two edges of one leaf only the later one is looked at.
fn matters(one: Candidate, pair: vec4u) -> bool {
    let is_again = pair.x == pair.y && one.first == 2u && (one.order & 255u) <= ((one.order >> 8u) & 255u);
    return !is_again && are_near(four_before(one.lanes), one.first, bitcast<f32>(pair.w)) && may_touch(one, pair.z > 0u);
}

/// Nodes of a pair by place.
fn nodes_of(lanes: vec4u) -> vec4u {
    let at = lanes + select(vec4u(0u), vec4u(LEAF_WORDS - 16u), lanes >= vec4u(16u));
    return vec4u(leaf_words[at.x], leaf_words[at.y], leaf_words[at.z], leaf_words[at.w]);
}

/// The thickness of a pair of two leaves [m]: for neighbours along the surface it follows from their distance at the start.
fn thickness_of(one: Candidate, thickness: f32, has_ring: bool) -> f32 {
    if !(has_ring && is_in_ring(one, 8u)) {
        return thickness;
    }
    let x = starts_of(nodes_of(one.lanes));
    let most = norm3(closest_of(relative_to_last(x, length_of(ZERO)), one.first).apart) * NEIGHBOURS;
    return select(thickness, most, most < thickness);
}

/// Where four places were at the start of the scene [m].
fn starts_of(nodes: vec4u) -> array<vec3f, 4> {
    return array<vec3f, 4>(start_of(nodes.x), start_of(nodes.y), start_of(nodes.z), start_of(nodes.w));
}

/// Where a place was at the start of the scene [m].
fn start_of(place: u32) -> vec3f {
    let at = table(START_AT) + 3u * place;
    return vec3f(bitcast<f32>(surface_tables[at]), bitcast<f32>(surface_tables[at + 1u]), bitcast<f32>(surface_tables[at + 2u]));
}
