// What kernels know of surfaces: leaves of triangles, their places, boxes around them, and what is counted on the way.
//
// Lists are filled in any order, by a number that is counted up. Whatever is summed is sorted before, so that nothing depends on
// that order. A list that is too short counts on: the host reads what it would have needed, and repeats the frame.

#import contact/triangles/impulse.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/vector.wgsl

/// All that is constant: a header, then the tables that it names.
@group(1) @binding(70) var<storage, read> surface_tables: array<u32>;
/// What a command of several is about: a level of boxes, or what is counted.
@group(1) @binding(71) var<storage, read> surface_part: array<u32>;
/// Corners of colliders at the start and at the end of each sub-step, where some move.
@group(1) @binding(72) var<storage, read> surface_corners: array<vec4f>;
/// Where surfaces pass through each other, or nodes are led out of colliders: what each place has to do with that, nine words each; then what pulls them apart,
/// sixteen words each (pull.wgsl).
@group(1) @binding(73) var<storage, read> surface_knots: array<u32>;
/// Vectors of places, one array of all of them after the other.
@group(3) @binding(70) var<storage, read_write> surface_places: array<vec4f>;
/// Of each leaf, and of boxes of sixteen: the least and the largest corner before, and of the motion.
@group(3) @binding(71) var<storage, read_write> surface_boxes: array<vec4f>;
/// Pairs of leaves that are near each other: both, their ring, and the distance up to which their triangles matter, as bits.
@group(3) @binding(72) var<storage, read_write> surface_pairs: array<vec4u>;
@group(3) @binding(73) var<storage, read_write> surface_contacts: array<SurfaceContact>;
/// Forces of the last sub-step, three records each: the order of their contact, and 1 if the solver of this one has given it an
/// impulse; the force [N]; that impulse [N·s], as bits.
@group(3) @binding(74) var<storage, read_write> surface_forces: array<vec4u>;
/// What is counted, and lists of numbers.
@group(3) @binding(75) var<storage, read_write> surface_work: array<atomic<u32>>;
/// Workgroups of commands that are counted.
@group(3) @binding(76) var<storage, read_write> surface_counts: array<u32>;

// The header of the tables: numbers of places of nodes, of all places, of leaves, of levels of boxes; the first box and the number
// of boxes of each level; where tables and lists begin.
const NODE_PLACES: u32 = 0u;
const ALL_PLACES: u32 = 1u;
const LEAF_COUNT: u32 = 2u;
const TOP_LEVEL: u32 = 3u;
const LEVEL_BOXES: u32 = 4u;
const LEAVES_AT: u32 = 16u;
const ROWS_AT: u32 = 17u;
const ROW_ITEMS_AT: u32 = 18u;
const RINGS_AT: u32 = 19u;
const MATERIALS_AT: u32 = 20u;
const MATERIAL_COUNT: u32 = 21u;
const LEAVES_OF_AT: u32 = 22u;
const LEAF_ITEMS_AT: u32 = 23u;
const START_AT: u32 = 24u;
const HAS_SURFACE_AT: u32 = 25u;
const PAIR_ROOM: u32 = 26u;
const CONTACT_ROOM: u32 = 27u;
const BUCKETS: u32 = 28u;
// Lengths, as bits: the longest way of a round of the filter [m], and the largest squared way
// that is not longer [m²]; squared ways below which a node makes no progress, and from which on pairs are listed again [m²]; how
// much nearer pairs may come by impulses, the largest thickness, the longest edge [m].
const LONGEST_WAY: u32 = 30u;
const SQUARED_WAY: u32 = 31u;
const SQUARED_PROGRESS: u32 = 32u;
const SQUARED_CHANGE: u32 = 33u;
const ALLOWANCE: u32 = 34u;
const THICKEST: u32 = 35u;
const LONGEST_EDGE: u32 = 36u;
/// Rounds of the filter that are written down.
const ROUND_ROOM: u32 = 37u;
/// How often nodes that are held back may hold back others, as is written down.
const JAM_ROOM: u32 = 39u;
/// 0, as bits.
const ZERO: u32 = 38u;
/// How often nodes that are pushed may push others, as is written down.
const PUSH_ROOM: u32 = 40u;
/// Whether surfaces pass through each other, and how many pulls lead them back.
const IS_TANGLED: u32 = 41u;
const PULL_COUNT: u32 = 42u;
/// Whether contacts are part of a system that is solved for.
const IS_SOLVED: u32 = 43u;
/// Rounds of impulses that are written down.
const IMPULSE_ROOM: u32 = 46u;
/// The triangles around each place: where its fan begins; the other two corners of each.
const FANS_AT: u32 = 44u;
const FAN_ITEMS_AT: u32 = 45u;

// Words of a leaf: its nodes, their number, its surface, the lanes that are held, the numbers of its triangles, edges and vertices;
// then these by lanes, a triangle, an edge or four vertices a word.
const LEAF_WORDS: u32 = 56u;
const LEAF_NODES: u32 = 16u;
const LEAF_MATERIAL: u32 = 17u;
const LEAF_HELD: u32 = 18u;
const LEAF_COUNTS: u32 = 19u;
const LEAF_TRIANGLES: u32 = 20u;
const LEAF_EDGES: u32 = 28u;
const LEAF_VERTICES: u32 = 52u;
/// Leaves of a group, which stand together in the order of contacts; also the boxes of a box.
const LEAF_GROUP: u32 = 16u;
/// Pairs that are nearer than this, relative to their thickness, may become contacts while a system is solved for.
const NEARBY: f32 = 1.25;

// Arrays of places: where nodes were where the sub-step began, are before it or the round of the filter, and are after it; the
// velocity before contact; what removes old overlaps; where nodes would end, and before the filter how far colliders have pushed
// them, and as long as a system is solved for where corners of colliders go; the velocity there.
const AT_START: u32 = 0u;
const BEFORE: u32 = 1u;
const AFTER: u32 = 2u;
const BASE_VELOCITY: u32 = 3u;
const PUSH: u32 = 4u;
const TARGET: u32 = 5u;
const TARGET_VELOCITY: u32 = 6u;

// What is counted, in the first words of `surface_work`.
const PAIRS: u32 = 0u;
const CONTACTS: u32 = 1u;
const TOUCHED: u32 = 2u;
const PARTS: u32 = 3u;
const FORCES: u32 = 4u;
const SINKS: u32 = 5u;
const NEAREST: u32 = 6u;
const WAY: u32 = 7u;
const CHANGE_OF_WAY: u32 = 8u;
const FARTHEST_PLACE: u32 = 9u;
const PROGRESS: u32 = 10u;
const HELD: u32 = 11u;
const ROUND: u32 = 12u;
const IS_ACTIVE: u32 = 13u;
const FILTER_ROUND: u32 = 14u;
const JAM: u32 = 15u;
const LISTED: u32 = 16u;
const IN_ROUNDS: u32 = 17u;
const IS_ODD: u32 = 18u;
/// Parts of the motion of colliders that have begun; whether a node goes farther by a push, or stops; rounds of pushes in the part.
const CORNER_PART: u32 = 19u;
const PUSHED: u32 = 20u;
const PUSH_ROUND: u32 = 21u;
/// What was too little in the frame: room for pairs, for contacts, rounds of the filter, of jams, of pushes, of impulses; and what
/// was needed at most.
const SHORT: u32 = 22u;
const MOST_PAIRS: u32 = 23u;
const MOST_CONTACTS: u32 = 24u;
// What was needed of what is written down, at most in a frame: rounds of impulses, rounds of the filter, how often nodes that are held
// back hold back others, how often nodes that are pushed push others.
const MOST_IMPULSES: u32 = 25u;
const MOST_ROUNDS: u32 = 26u;
const MOST_JAMS: u32 = 27u;
const MOST_PUSHES: u32 = 28u;
/// The longest way that the filter has taken of a node, squared [m²], as bits: after the last round; and at most in a sub-step of the
/// frame.
const WAY_TAKEN: u32 = 29u;
const MOST_WAY_TAKEN: u32 = 30u;
/// One more than the last node that had no room between colliders in the frame.
const SQUEEZED: u32 = 31u;
/// What the next round of pushes does.
const PUSH_PHASE: u32 = 32u;
/// One more than the last node of a side that was pushed and is not pinned, in a round.
const WAITING: u32 = 33u;
/// Lists of numbers begin here.
const LISTS: u32 = 34u;

/// Rounds of pushes in a part of the motion of colliders at most.
const PUSHES: u32 = 64u;

// What a round of pushes does: it pushes nodes; puts them back; pushes them with less room; has them stop; nothing.
const PHASE_PUSH: u32 = 0u;
const PHASE_RESTART: u32 = 1u;
const PHASE_SQUEEZE: u32 = 2u;
const PHASE_STOP: u32 = 3u;
const PHASE_OVER: u32 = 4u;

// Which pairs are listed: all that may come near each other; those around leaves that were marked last; all within reach; all that
// may come near each other where colliders push nodes; all that may while a system is solved for.
const NEAR: u32 = 0u;
const AROUND: u32 = 1u;
const ALL: u32 = 2u;
const CARRIED: u32 = 3u;
const SOLVED: u32 = 4u;

/// Numbers that mark what is held back, in a round of the filter.
const STAMPS: u32 = 32u;

fn table(word: u32) -> u32 {
    return surface_tables[word];
}

fn length_of(word: u32) -> f32 {
    return bitcast<f32>(surface_tables[word]);
}

fn place_at(array: u32, place: u32) -> vec3f {
    return surface_places[array * table(ALL_PLACES) + place].xyz;
}

fn put_place(array: u32, place: u32, x: vec3f) {
    surface_places[array * table(ALL_PLACES) + place] = vec4f(x, 0.0);
}

fn counted(word: u32) -> u32 {
    return atomicLoad(&surface_work[word]);
}

fn set_counted(word: u32, value: u32) {
    atomicStore(&surface_work[word], value);
}

// Lists of numbers by place: contacts, where the list of these begins and how many are in it yet, what the filter leaves of the way
// and which plane stops it (slide.wgsl), and when the node was held back.
fn count_at(place: u32) -> u32 {
    return LISTS + place;
}

fn list_start_at(place: u32) -> u32 {
    return LISTS + table(ALL_PLACES) + place;
}

fn filled_at(place: u32) -> u32 {
    return LISTS + 2u * table(ALL_PLACES) + place;
}

fn limit_at(place: u32) -> u32 {
    return LISTS + 3u * table(ALL_PLACES) + place;
}

fn held_at(place: u32) -> u32 {
    return LISTS + 4u * table(ALL_PLACES) + place;
}

/// How far a round pushes a node along an axis, as a key (carry.wgsl). Contacts have found their impulses before.
fn push_at(axis: u32, place: u32) -> u32 {
    return LISTS + axis * table(ALL_PLACES) + place;
}

/// Nodes in contact, in any order.
fn touched_at(number: u32) -> u32 {
    return LISTS + 5u * table(ALL_PLACES) + number;
}

/// When a leaf had a node last that was held back.
fn mark_at(leaf: u32) -> u32 {
    return LISTS + 6u * table(ALL_PLACES) + leaf;
}

fn after_marks() -> u32 {
    return mark_at(0u) + table(LEAF_COUNT);
}

/// The parts of nodes in contacts, in any order: four times the contact, and which of its nodes. Then the same, sorted.
fn part_at(number: u32) -> u32 {
    return after_marks() + number;
}

fn sorted_part_at(number: u32) -> u32 {
    return after_marks() + 4u * table(CONTACT_ROOM) + number;
}

/// The force after one in its bucket.
fn next_force_at(number: u32) -> u32 {
    return after_marks() + 8u * table(CONTACT_ROOM) + number;
}

/// The first force of a bucket, by turns.
fn first_force_at(is_odd: u32, bucket: u32) -> u32 {
    return after_marks() + 9u * table(CONTACT_ROOM) + is_odd * table(BUCKETS) + bucket;
}

/// The bucket of a contact by its order.
fn bucket_of(order: vec3u) -> u32 {
    var mixed = order.x * 0x9e3779b1u ^ order.y * 0x85ebca6bu ^ order.z * 0xc2b2ae35u;
    mixed ^= mixed >> 15u;
    return mixed & (table(BUCKETS) - 1u);
}

/// Whether a contact stands before another one in the order in which they are summed up.
fn is_before(a: vec3u, b: vec3u) -> bool {
    // Pulls, which have no leaf, come first.
    let groups_a = (a.xy + LEAF_GROUP) / LEAF_GROUP;
    let groups_b = (b.xy + LEAF_GROUP) / LEAF_GROUP;
    if groups_a.x != groups_b.x {
        return groups_a.x < groups_b.x;
    }
    if groups_a.y != groups_b.y {
        return groups_a.y < groups_b.y;
    }
    if a.x != b.x {
        return a.x < b.x;
    }
    if a.y != b.y {
        return a.y < b.y;
    }
    return a.z < b.z;
}

/// A word of a leaf.
fn leaf_word(leaf: u32, word: u32) -> u32 {
    return surface_tables[table(LEAVES_AT) + leaf * LEAF_WORDS + word];
}

/// Thickness [m] and friction of pairs of two surfaces; the thickness is below zero if they do not touch.
fn material_of(a: u32, b: u32) -> vec2f {
    let at = table(MATERIALS_AT) + 2u * (a * table(MATERIAL_COUNT) + b);
    return vec2f(bitcast<f32>(surface_tables[at]), bitcast<f32>(surface_tables[at + 1u]));
}

/// Whether a place has a surface.
fn has_surface(place: u32) -> bool {
    return surface_tables[table(HAS_SURFACE_AT) + place] != 0u;
}
