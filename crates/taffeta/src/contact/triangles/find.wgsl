// Which triangles may come near each other, and which of their vertices and edges are in contact.

#import contact/triangles/closest.wgsl
#import contact/triangles/filter.wgsl
#import contact/triangles/impulse.wgsl
#import contact/triangles/surfaces.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl

/// Part of its distance to the plane that a node may use up, and that times the largest part of the gap.
const SHARE: f32 = 0.85;
const MOST_OF_GAP: f32 = 0.8075;
/// What bounds are multiplied by, for rounding.
const LOOSE_REACH: f32 = 1.0001;
/// Thickness of neighbours along the surface, at most, relative to their distance at the start.
const NEIGHBOURS: f32 = 0.5;

/// Keeps where nodes are where the sub-step begins.
@compute @workgroup_size(256)
fn keep_places(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let place = node_of(id, lane);
    if place < table(NODE_PLACES) {
        put_place(AT_START, place, old_position[place].xyz);
    }
}

/// Takes up the state after the sub-step without contact, and empties lists.
@compute @workgroup_size(256)
fn take_places(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let number = node_of(id, lane);
    if number == 0u {
        for (var word = 0u; word < SHORT; word++) {
            if word != FORCES && word != IS_ODD {
                set_counted(word, 0u);
            }
        }
        set_counted(NEAREST, bitcast<u32>(FAR));
    }
    if number < table(NODE_PLACES) {
        put_place(BEFORE, number, place_at(AT_START, number));
        put_place(AFTER, number, new_position[number].xyz);
        put_place(BASE_VELOCITY, number, new_velocity[number].xyz);
        set_counted(count_at(number), 0u);
        set_counted(filled_at(number), 0u);
        set_counted(limit_at(number), bitcast<u32>(1.0));
        set_counted(held_at(number), 0u);
    }
    if number < table(LEAF_COUNT) {
        set_counted(mark_at(number), 0u);
    }
    if number < table(BUCKETS) {
        set_counted(first_force_at(1u - counted(IS_ODD), number), NONE);
    }
}

/// The box around the places of a leaf before, and around their motion.
@compute @workgroup_size(256)
fn bound_leaves(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let leaf = node_of(id, lane);
    if leaf >= table(LEAF_COUNT) {
        return;
    }
    var low = vec3f(FAR);
    var high = vec3f(-FAR);
    var least = vec3f(FAR);
    var most = vec3f(-FAR);
    for (var i = 0u; i < leaf_word(leaf, LEAF_NODES); i++) {
        let node = leaf_word(leaf, i);
        let x = place_at(BEFORE, node);
        let way = place_at(AFTER, node) - x;
        low = min(low, x);
        high = max(high, x);
        least = min(least, way);
        most = max(most, way);
    }
    put_box(leaf, low, high, least, most);
}

fn put_box(number: u32, low: vec3f, high: vec3f, least: vec3f, most: vec3f) {
    surface_boxes[4u * number] = vec4f(low, 0.0);
    surface_boxes[4u * number + 1u] = vec4f(high, 0.0);
    surface_boxes[4u * number + 2u] = vec4f(least, 0.0);
    surface_boxes[4u * number + 3u] = vec4f(most, 0.0);
}

/// The boxes of a level, each around up to sixteen of the level below.
@compute @workgroup_size(256)
fn bound_level(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let level = surface_part[0];
    let number = node_of(id, lane);
    if number >= table(LEVEL_BOXES + 2u * level + 1u) {
        return;
    }
    let below = table(LEVEL_BOXES + 2u * level - 2u);
    let first = number * LEAF_GROUP;
    let end = min(first + LEAF_GROUP, table(LEVEL_BOXES + 2u * level - 1u));
    var low = vec3f(FAR);
    var high = vec3f(-FAR);
    var least = vec3f(FAR);
    var most = vec3f(-FAR);
    for (var i = first; i < end; i++) {
        let at = 4u * (below + i);
        low = min(low, surface_boxes[at].xyz);
        high = max(high, surface_boxes[at + 1u].xyz);
        least = min(least, surface_boxes[at + 2u].xyz);
        most = max(most, surface_boxes[at + 3u].xyz);
    }
    put_box(table(LEVEL_BOXES + 2u * level) + number, low, high, least, most);
}

/// A leaf that looks for others.
struct Seeker {
    leaf: u32,
    /// Which pairs it lists.
    kind: u32,
    low: vec3f,
    high: vec3f,
    least: vec3f,
    most: vec3f,
    /// Its longest way [m].
    way: f32,
}

fn longest_way(least: vec3f, most: vec3f) -> f32 {
    return norm3(max(abs(least), abs(most)));
}

/// Distance up to which triangles of two leaves of this thickness matter, the second of which, or what it is one of, is in a
/// box [m].
fn reach_of(seeker: Seeker, box_at: u32, thickness: f32) -> f32 {
    let least = surface_boxes[box_at + 2u].xyz;
    let most = surface_boxes[box_at + 3u].xyz;
    if seeker.kind == NEAR {
        let approach = norm3(max(seeker.most - least, most - seeker.least));
        return (KEEPS * thickness + approach / SHARE + length_of(ALLOWANCE)) * LOOSE_REACH;
    }
    let way = max(seeker.way, longest_way(least, most)) + length_of(ALLOWANCE);
    let far = bitcast<f32>(counted(FARTHEST_PLACE));
    let kept = floor_of(length_of(LONGEST_EDGE), length_of(THICKEST), far);
    return (2.0 * way / MOST_OF_GAP + 2.0 * kept / MOST_SHARE) * LOOSE_REACH;
}

/// Whether a box is nearer to a leaf than that.
fn is_in_reach(seeker: Seeker, box_at: u32, reach: f32) -> bool {
    let gap = max(seeker.low - surface_boxes[box_at + 1u].xyz, surface_boxes[box_at].xyz - seeker.high);
    let apart = max(gap, vec3f(0.0));
    return dot3(apart, apart) < reach * reach;
}

/// The ring of two leaves, the first not after the second; 0: they have none.
fn ring_of(first: u32, second: u32) -> u32 {
    var low = surface_tables[table(ROWS_AT) + first];
    var high = surface_tables[table(ROWS_AT) + first + 1u];
    let items = table(ROW_ITEMS_AT);
    while low < high {
        let middle = (low + high) / 2u;
        let number = surface_tables[items + 2u * middle];
        if number == second {
            return surface_tables[items + 2u * middle + 1u];
        }
        if number < second {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return 0u;
}

/// Whether a leaf lists its pair with another one.
fn lists_pair(seeker: Seeker, other: u32) -> bool {
    if seeker.kind == AROUND && other < seeker.leaf {
        return counted(mark_at(other)) != counted(JAM);
    }
    return other >= seeker.leaf;
}

fn list_pair(seeker: Seeker, other: u32, box_at: u32) {
    let material = material_of(leaf_word(seeker.leaf, LEAF_SURFACE), leaf_word(other, LEAF_SURFACE));
    let reach = reach_of(seeker, box_at, material.x);
    if material.x < 0.0 || !is_in_reach(seeker, box_at, reach) {
        return;
    }
    let number = atomicAdd(&surface_work[PAIRS], 1u);
    if number < table(PAIR_ROOM) {
        let first = min(seeker.leaf, other);
        let second = max(seeker.leaf, other);
        surface_pairs[number] = vec4u(first, second, ring_of(first, second), bitcast<u32>(reach));
    }
}

/// Lists pairs of leaves, each of which looks through the boxes from the top.
@compute @workgroup_size(256)
fn list_leaf_pairs(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let leaf = node_of(id, lane);
    if leaf >= table(LEAF_COUNT) {
        return;
    }
    let kind = counted(LISTED);
    if kind == AROUND && counted(mark_at(leaf)) != counted(JAM) {
        return;
    }
    let own = 4u * leaf;
    let least = surface_boxes[own + 2u].xyz;
    let most = surface_boxes[own + 3u].xyz;
    let way = longest_way(least, most);
    let seeker = Seeker(leaf, kind, surface_boxes[own].xyz, surface_boxes[own + 1u].xyz, least, most, way);
    let top = table(TOP_LEVEL);
    var level = top;
    var number = 0u;
    while level <= top {
        let box_at = 4u * (table(LEVEL_BOXES + 2u * level) + number);
        let end = (number + 1u) << (4u * level);
        // Who stands before has listed the pair.
        let may = kind == AROUND || end > leaf;
        if may && level == 0u {
            if lists_pair(seeker, number) {
                list_pair(seeker, number, box_at);
            }
        } else if may && is_in_reach(seeker, box_at, reach_of(seeker, box_at, length_of(THICKEST))) {
            level--;
            number *= LEAF_GROUP;
            continue;
        }
        number++;
        while level <= top && (number % LEAF_GROUP == 0u || number >= table(LEVEL_BOXES + 2u * level + 1u)) {
            number = (number - 1u) / LEAF_GROUP + 1u;
            level++;
        }
    }
}

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

/// Loads two leaves. All invocations of the workgroup call it.
fn load_leaves(pair: vec4u, lane: u32) {
    if lane < 112u {
        let leaf = select(pair.x, pair.y, lane >= LEAF_WORDS);
        leaf_words[lane] = leaf_word(leaf, lane % LEAF_WORDS);
    }
    if lane >= 128u && lane < 144u {
        ring_words[lane - 128u] = surface_tables[table(RINGS_AT) + 16u * pair.z + lane - 128u];
    }
    if lane < 32u {
        let node = leaf_word(select(pair.x, pair.y, lane >= 16u), lane % 16u);
        before[lane] = place_at(BEFORE, node);
        after[lane] = place_at(AFTER, node);
    }
    workgroupBarrier();
    if lane < 96u {
        list_near(lane / 48u, lane % 48u, select(pair.x, pair.y, lane < 48u), bitcast<f32>(pair.w));
    }
    workgroupBarrier();
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

/// Whether a pair can come into contact: its sides do not hang together, and not all its nodes are held.
fn may_touch(one: Candidate, has_ring: bool) -> bool {
    let free = (one.bits.x & ~leaf_words[LEAF_HELD]) | (one.bits.y & ~leaf_words[LEAF_WORDS + LEAF_HELD]);
    return free != 0u && !(has_ring && is_in_ring(one, 0u));
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
    let nodes = nodes_of(one.lanes);
    let x = array<vec3f, 4>(start_of(nodes.x), start_of(nodes.y), start_of(nodes.z), start_of(nodes.w));
    let most = norm3(closest_of(relative_to_last(x, length_of(ZERO)), one.first).apart) * NEIGHBOURS;
    return select(thickness, most, most < thickness);
}

/// Where a place was at the start of the scene [m].
fn start_of(place: u32) -> vec3f {
    let at = table(START_AT) + 3u * place;
    return vec3f(bitcast<f32>(surface_tables[at]), bitcast<f32>(surface_tables[at + 1u]), bitcast<f32>(surface_tables[at + 2u]));
}

/// The force that a contact had in the last sub-step [N].
fn last_force(order: vec3u) -> vec3f {
    var number = counted(first_force_at(counted(IS_ODD), bucket_of(order)));
    while number != NONE {
        if all(surface_forces[2u * number].xyz == order) {
            return bitcast<vec3f>(surface_forces[2u * number + 1u].xyz);
        }
        number = counted(next_force_at(number));
    }
    return vec3f(0.0);
}

/// The contacts of two leaves.
@compute @workgroup_size(256)
fn find_surface_contacts(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = min(workgroup_index(id), counted(PAIRS) - 1u);
    let is_there = index == workgroup_index(id);
    let pair = surface_pairs[index];
    load_leaves(pair, lane);
    let counts = candidate_count(pair.x == pair.y);
    let material = material_of(leaf_words[LEAF_SURFACE], leaf_words[LEAF_WORDS + LEAF_SURFACE]);
    let count = select(0u, counts.x + counts.y + counts.z, is_there);
    for (var number = lane; number < count; number += 256u) {
        let one = candidate(number, counts);
        if matters(one, pair) {
            add_contact(one, four_before(one.lanes), vec3u(pair.xy, one.order), material, pair.z > 0u);
        }
    }
}

/// Adds a pair to the contacts, if it would end nearer than its thickness. One that carried a force remains one a little longer.
fn add_contact(one: Candidate, x: array<vec3f, 4>, order: vec3u, material: vec2f, has_ring: bool) {
    let found = closest_of(relative_to_last(x, length_of(ZERO)), one.first);
    let distance = norm3(found.apart);
    let ends = relative_to_last(four_after(one.lanes), length_of(ZERO));
    let then = ends[0] * found.weights.x + ends[1] * found.weights.y + ends[2] * found.weights.z;
    let along = dot3(then, found.apart * (1.0 / select(1.0, distance, distance > TINY)));
    let thickness = thickness_of(one, material.x, has_ring);
    if !(along < KEEPS * thickness && distance > 0.0) {
        return;
    }
    let force = last_force(order);
    if all(force == vec3f(0.0)) && !(along < thickness) {
        return;
    }
    let gap = distance - thickness;
    // Bits of positive numbers have the order of the numbers.
    atomicMin(&surface_work[NEAREST], bitcast<u32>(max(1.0 + gap / thickness, 0.0)));
    let number = atomicAdd(&surface_work[CONTACTS], 1u);
    if number >= table(CONTACT_ROOM) {
        return;
    }
    let nodes = nodes_of(one.lanes);
    surface_contacts[number] = SurfaceContact(
        nodes, found.weights, found.apart / distance, gap, force * substeps[0].h, 0.0, force, thickness, order,
        material.y, 0.0,
    );
    for (var i = 0u; i < 4u; i++) {
        if found.weights[i] != 0.0 && nodes[i] < table(NODE_PLACES) && atomicAdd(&surface_work[count_at(nodes[i])], 1u) == 0u {
            set_counted(touched_at(atomicAdd(&surface_work[TOUCHED], 1u)), nodes[i]);
        }
    }
}

/// The limits of the nodes of all pairs of two leaves: of those that come near each other, if all nodes go all their way; of those
/// around nodes that are held back, by planes that stand still.
@compute @workgroup_size(256)
fn limit_ways(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = min(workgroup_index(id), counted(PAIRS) - 1u);
    let is_there = index == workgroup_index(id);
    let pair = surface_pairs[index];
    load_leaves(pair, lane);
    let counts = candidate_count(pair.x == pair.y);
    let material = material_of(leaf_words[LEAF_SURFACE], leaf_words[LEAF_WORDS + LEAF_SURFACE]);
    let kind = counted(LISTED);
    let far = bitcast<f32>(counted(FARTHEST_PLACE));
    let count = select(0u, counts.x + counts.y + counts.z, is_there);
    for (var number = lane; number < count; number += 256u) {
        let one = candidate(number, counts);
        let nodes = nodes_of(one.lanes);
        if !matters(one, pair) || (kind == AROUND && !any_held(nodes)) {
            continue;
        }
        let thickness = thickness_of(one, material.x, pair.z > 0u);
        limit_nodes(one, nodes, four_before(one.lanes), thickness, far, kind == NEAR);
    }
}

/// Whether a node was held back in the last round of jams.
fn any_held(nodes: vec4u) -> bool {
    var any = false;
    for (var i = 0u; i < 4u; i++) {
        any = any || (nodes[i] < table(NODE_PLACES) && counted(held_at(nodes[i])) == counted(JAM));
    }
    return any;
}

fn limit_nodes(one: Candidate, nodes: vec4u, x: array<vec3f, 4>, thickness: f32, far: f32, together: bool) {
    let ends = four_after(one.lanes);
    let moves = array<vec3f, 4>(ends[0] - x[0], ends[1] - x[1], ends[2] - x[2], ends[3] - x[3]);
    let start = relative_to_last(x, length_of(ZERO));
    let apart = closest_of(start, one.first).apart;
    let parts = limits_of(start, moves, one.first, apart, thickness, far, together);
    for (var i = 0u; i < 4u; i++) {
        if parts[i] < 1.0 && nodes[i] < table(NODE_PLACES) {
            atomicMin(&surface_work[limit_at(nodes[i])], bitcast<u32>(parts[i]));
        }
    }
}
