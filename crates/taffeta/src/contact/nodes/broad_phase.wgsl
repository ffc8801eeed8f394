// Nodes that touch each other: their surfaces, and who is near whom. A node is linked into the list of its bucket; lists
// have room for any number, in any order. Contacts of a node are taken in the order of their numbers, sixteen at a time, so
// that nothing depends on who was linked first.

#import contact/nodes/cells.wgsl
#import contact/nodes/pair.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/vector.wgsl
#import memory

/// How the nodes of a body touch others.
struct Surface {
    /// Its first node, and how many it has.
    first: u32,
    count: u32,
    /// Columns of a grid; 0: a mesh.
    cols: u32,
    /// Rows and columns, at most, from a node of a grid to one that it does not touch.
    high: u32,
    wide: u32,
    /// Where in `exclusions` it says which of its nodes do not touch: for a grid a bit for each way, row by row; for a mesh where
    /// the list of each node begins, and the end; then the lists, which ascend.
    exclusions: u32,
    material: ContactMaterial,
    cells_a_metre: f32,
}

@group(1) @binding(18) var<storage, read> surfaces: array<Surface>;
/// The surface of each slice of 16 places; then nodes that do not touch.
@group(1) @binding(19) var<storage, read> exclusions: array<u32>;
/// The first node of each bucket, and the next one of each place; behind them what `contact_work` has.
@group(3) @binding(17) var<storage, read_write> cell_links: array<atomic<u32>>;
/// The same; then contacts of each place, and its least squared distance by that which is kept, as bits.
@group(3) @binding(18) var<storage, read_write> contact_work: array<u32>;

/// The surface of a place.
fn surface_number(place: u32) -> u32 {
    let number = exclusions[place / LANES];
    if number == NONE || place - surfaces[number].first >= surfaces[number].count {
        return NONE;
    }
    return number;
}

/// Number of buckets, a power of two, where lists, contacts and distances of all places lie behind them.
fn buckets_in(length: u32) -> u32 {
    return length - 3u * arrayLength(&old_position);
}

/// Goes on by `step` in a list that ascends, if all that it passes is below `b`.
fn advance_past(at: u32, step: u32, end: u32, lists: u32, b: u32) -> u32 {
    if at + step <= end && exclusions[lists + at + step - 1u] < b {
        return at + step;
    }
    return at;
}

/// Whether two nodes of a surface are too near along it to touch.
fn are_excluded(surface: Surface, a: u32, b: u32) -> bool {
    if surface.cols > 0u {
        let row = i32(b / surface.cols) - i32(a / surface.cols) + i32(surface.high);
        let col = i32(b % surface.cols) - i32(a % surface.cols) + i32(surface.wide);
        let rows = 2 * i32(surface.high) + 1;
        let cols = 2 * i32(surface.wide) + 1;
        if row < 0 || row >= rows || col < 0 || col >= cols {
            return false;
        }
        let bit = u32(row * cols + col);
        return ((exclusions[surface.exclusions + bit / 32u] >> (bit % 32u)) & 1u) != 0u;
    }
    let lists = surface.exclusions + surface.count + 1u;
    let end = exclusions[surface.exclusions + a + 1u];
    var at = exclusions[surface.exclusions + a];
    // A list has 1,024 nodes at most. A loop would count among the turns of a software adapter.
    at = advance_past(at, 1024u, end, lists, b);
    at = advance_past(at, 512u, end, lists, b);
    at = advance_past(at, 256u, end, lists, b);
    at = advance_past(at, 128u, end, lists, b);
    at = advance_past(at, 64u, end, lists, b);
    at = advance_past(at, 32u, end, lists, b);
    at = advance_past(at, 16u, end, lists, b);
    at = advance_past(at, 8u, end, lists, b);
    at = advance_past(at, 4u, end, lists, b);
    at = advance_past(at, 2u, end, lists, b);
    at = advance_past(at, 1u, end, lists, b);
    return at < end && exclusions[lists + at] == b;
}

/// Distance at which a node of one surface touches one of another [m].
fn contact_distance(a: Surface, b: Surface) -> f32 {
    return a.material.thickness * 0.5 + b.material.thickness * 0.5;
}

/// Whether a node at `x` of surface `number` is as near to another as those do that touch.
fn is_within_reach(node: u32, number: u32, x: vec3f, other: u32) -> bool {
    let d = x - position_of(other);
    let reach = contact_distance(surfaces[number], surfaces[surface_number(other)]);
    return other != node && dot3(d, d) < reach * reach;
}

/// Whether a node of surface `number` touches another where it is near.
fn may_collide(node: u32, number: u32, other: u32) -> bool {
    let first = surfaces[number].first;
    return surface_number(other) != number || !are_excluded(surfaces[number], node - first, other - first);
}

/// Some numbers of nodes, ascending; NONE past the last.
struct Sixteen {
    a: vec4u,
    b: vec4u,
    c: vec4u,
    d: vec4u,
}

/// Adds a number that is not yet there; the greatest leaves.
fn insert(all: Sixteen, number: u32) -> Sixteen {
    let n = vec4u(number);
    if any(all.a == n) || any(all.b == n) || any(all.c == n) || any(all.d == n) {
        return all;
    }
    return Sixteen(
        max(vec4u(0u, all.a.xyz), min(all.a, n)),
        max(vec4u(all.a.w, all.b.xyz), min(all.b, n)),
        max(vec4u(all.b.w, all.c.xyz), min(all.c, n)),
        max(vec4u(all.c.w, all.d.xyz), min(all.d, n)),
    );
}

fn number_in(all: Sixteen, i: u32) -> u32 {
    let low = select(all.a, all.b, i >= 4u);
    let high = select(all.c, all.d, i >= 12u);
    let four = select(low, high, i >= 8u);
    return four[i % 4u];
}

/// The node after one in its list.
fn next_in_list(node: u32, buckets: u32) -> u32 {
    if node == NONE {
        return NONE;
    }
    return contact_work[buckets + node];
}

/// Adds a node from `least` on to which a node at `x` of surface `number` is near, unless there are sixteen before it.
fn with_candidate(found: Sixteen, node: u32, number: u32, x: vec3f, least: u32, other: u32) -> Sixteen {
    if other >= least && other < found.d.w && is_within_reach(node, number, x, other) {
        return insert(found, other);
    }
    return found;
}

/// The first sixteen nodes from `least` on to which a node at `x` of surface `number` is near. One loop goes through all
/// lists, so that invocations side by side wait for the longest way alone, and not for the longest list in each bucket.
fn neighbours_from(node: u32, number: u32, x: vec3f, least: u32) -> Sixteen {
    var found = Sixteen(vec4u(NONE), vec4u(NONE), vec4u(NONE), vec4u(NONE));
    let buckets = buckets_in(arrayLength(&contact_work));
    let cell = cell_at(x, surfaces[number].cells_a_metre);
    var bucket = 0u;
    var other = NONE;
    while bucket < 27u || other != NONE {
        if other == NONE {
            other = contact_work[(first_around(cell, bucket / 3u) + bucket % 3u) & (buckets - 1u)];
            bucket++;
        }
        // Two a turn: a software adapter ends an invocation after 65,536 turns.
        found = with_candidate(found, node, number, x, least, other);
        other = next_in_list(other, buckets);
        found = with_candidate(found, node, number, x, least, other);
        other = next_in_list(other, buckets);
    }
    return found;
}

/// Contacts of a place.
fn contacts_of(node: u32) -> u32 {
    let places = arrayLength(&old_position);
    return contact_work[buckets_in(arrayLength(&contact_work)) + places + node];
}
