// The broad phase of self-collision: the surfaces of bodies, and which nodes are near each other. Each node is in the
// linked list of its bucket; a list has room for any number of nodes, in any order. The contacts of a node are taken
// in the order of their numbers, sixteen at a time, so that nothing depends on the order of the lists.

#import contact/nodes/cells.wgsl
#import contact/nodes/pair.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/vector.wgsl
#import memory

/// The surface of a self-colliding body.
struct Surface {
    /// Its first node, and how many it has.
    first: u32,
    count: u32,
    /// Columns of a grid; 0: a mesh.
    cols: u32,
    /// Largest number of rows and columns between a node of a grid and one on its exclusion list.
    high: u32,
    wide: u32,
    /// Where in `exclusions` the exclusion lists of its nodes are. For a grid: one bit for each offset, row by row.
    /// For a mesh: where the list of each node begins, and the end; then the lists, ascending.
    exclusions: u32,
    material: ContactMaterial,
    cells_a_metre: f32,
    /// The layers that it is in, and those that it meets, a bit each.
    memberships: u32,
    met_layers: u32,
}

/// Whether some surfaces do not meet others.
override HAS_LAYERS: bool = false;

@group(1) @binding(18) var<storage, read> surfaces: array<Surface>;
/// The surface of each slice of 16 places; then the exclusion lists.
@group(1) @binding(19) var<storage, read> exclusions: array<u32>;
/// The first node of each bucket, and the next node of each place; then what `contact_work` has.
@group(3) @binding(17) var<storage, read_write> cell_links: array<atomic<u32>>;
/// The same; then, for each place, the number of contacts, and the least squared distance relative to the thickness,
/// as bits.
@group(3) @binding(18) var<storage, read_write> contact_work: array<u32>;

/// The surface of a place.
fn surface_number(place: u32) -> u32 {
    let number = exclusions[place / LANES];
    if number == NONE || place - surfaces[number].first >= surfaces[number].count {
        return NONE;
    }
    return number;
}

/// Number of buckets, a power of two. The lists, contacts and distances of all places follow them.
fn buckets_in(length: u32) -> u32 {
    return length - 3u * arrayLength(&old_position);
}

/// Advances by `step` in an ascending list, if all that it skips is below `b`.
fn advance_past(at: u32, step: u32, end: u32, lists: u32, b: u32) -> u32 {
    if at + step <= end && exclusions[lists + at + step - 1u] < b {
        return at + step;
    }
    return at;
}

/// Whether a node is on the exclusion list of another node of its surface.
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
    // A list has 1,024 nodes at most. A loop would count as turns of a software adapter.
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

/// Distance at which nodes of two surfaces are in contact [m].
fn contact_distance(a: Surface, b: Surface) -> f32 {
    return a.material.thickness * 0.5 + b.material.thickness * 0.5;
}

/// Whether two surfaces meet. Each meets itself.
fn do_meet(a: u32, b: u32) -> bool {
    return !HAS_LAYERS || a == b || (surfaces[a].memberships & surfaces[b].met_layers) != 0u
        && (surfaces[b].memberships & surfaces[a].met_layers) != 0u;
}

/// Whether a node at `x` of surface `number` is within contact distance of another that it meets.
fn is_within_reach(node: u32, number: u32, x: vec3f, other: u32) -> bool {
    let d = x - position_of(other);
    let of_other = surface_number(other);
    let reach = contact_distance(surfaces[number], surfaces[of_other]);
    return other != node && dot3(d, d) < reach * reach && do_meet(number, of_other);
}

/// Whether a node of surface `number` collides with another when they are near.
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

/// Inserts a number, unless it is there; the greatest is dropped.
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

/// Inserts a node, not below `least`, that a node at `x` of surface `number` is near to, unless there are sixteen
/// before it.
fn with_candidate(found: Sixteen, node: u32, number: u32, x: vec3f, least: u32, other: u32) -> Sixteen {
    if other >= least && other < found.d.w && is_within_reach(node, number, x, other) {
        return insert(found, other);
    }
    return found;
}

/// The first sixteen nodes, not below `least`, that a node at `x` of surface `number` is near to. One loop goes
/// through all lists, so that invocations side by side wait for the longest sum of lists only, and not for the
/// longest list of each bucket.
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
        // Two nodes in each turn: a software adapter ends an invocation after 65,536 turns.
        found = with_candidate(found, node, number, x, least, other);
        other = next_in_list(other, buckets);
        found = with_candidate(found, node, number, x, least, other);
        other = next_in_list(other, buckets);
    }
    return found;
}

/// Number of contacts of a place.
fn contacts_of(node: u32) -> u32 {
    let places = arrayLength(&old_position);
    return contact_work[buckets_in(arrayLength(&contact_work)) + places + node];
}
