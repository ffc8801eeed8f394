// Which leaves may come near each other: groups of sixteen look through the boxes together, level by level.

#import contact/triangles/filter.wgsl
#import contact/triangles/surfaces.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl

/// Part of its distance to the plane that a node may use up, times the largest part of the gap.
const MOST_OF_GAP: f32 = 0.8075;
/// How much nearer pairs may come by pushes where no push is longer than 1 along any axis.
const PUSH_REACH: f32 = 4.0754137;
/// What bounds are multiplied by, for rounding.
const LOOSE_REACH: f32 = 1.0001;
/// Boxes of one level that a group may be near to.
const FRONT: u32 = 1024u;

/// Boxes that are near a group of leaves, of the level that it looks at and of that below: twice as many.
var<workgroup> front: array<u32, 2048>;
/// What invocations count together, and what they have counted.
var<workgroup> counter: atomic<u32>;
var<workgroup> counted_together: u32;

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
    if seeker.kind == NEAR || seeker.kind == CARRIED || seeker.kind == SOLVED {
        let approach = norm3(max(seeker.most - least, most - seeker.least));
        let by_pushes = select(0.0, PUSH_REACH * substeps[own()].longest_push, seeker.kind == CARRIED);
        let by_solver = select(0.0, (NEARBY - 1.0) * length_of(THICKEST), seeker.kind == SOLVED);
        return (KEEPS * thickness + approach / SHARE + length_of(ALLOWANCE) + by_pushes + by_solver) * LOOSE_REACH;
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
    let material = material_of(leaf_word(seeker.leaf, LEAF_MATERIAL), leaf_word(other, LEAF_MATERIAL));
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

/// What is in a box, as it looks for others: a leaf, or a group of them.
fn seeker_in(box_at: u32, leaf: u32, kind: u32) -> Seeker {
    let least = surface_boxes[box_at + 2u].xyz;
    let most = surface_boxes[box_at + 3u].xyz;
    let way = longest_way(least, most);
    return Seeker(leaf, kind, surface_boxes[box_at].xyz, surface_boxes[box_at + 1u].xyz, least, most, way);
}

/// Whether a leaf looks for pairs.
fn seeks(leaf: u32, kind: u32) -> bool {
    return leaf < table(LEAF_COUNT) && (kind != AROUND || counted(mark_at(leaf)) == counted(JAM));
}

/// Takes what all invocations have counted, and counts from 0 again. All of them call it.
fn take_count(lane: u32) -> u32 {
    workgroupBarrier();
    if lane == 0u {
        counted_together = atomicLoad(&counter);
        atomicStore(&counter, 0u);
    }
    return workgroupUniformLoad(&counted_together);
}

/// Lists the pairs of one leaf alone, which looks through the boxes from the top: for those that are near more boxes of a level than
/// their group can note.
fn list_alone(seeker: Seeker) {
    let top = table(TOP_LEVEL);
    var level = top;
    var number = 0u;
    while level <= top {
        let box_at = 4u * (table(LEVEL_BOXES + 2u * level) + number);
        let end = (number + 1u) << (4u * level);
        // Who stands before has listed the pair.
        let may = seeker.kind == AROUND || end > seeker.leaf;
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

/// Notes the boxes of a level that are near a group of leaves and lie in those of the level above that are.
fn look_into(above: u32, count: u32, level: u32, group: Seeker, lane: u32) {
    let boxes = table(LEVEL_BOXES + 2u * level);
    for (var i = lane; i < LEAF_GROUP * count; i += 256u) {
        let number = LEAF_GROUP * front[above + i / LEAF_GROUP] + i % LEAF_GROUP;
        // Who stands before has listed the pair.
        let may = group.kind == AROUND || (number + 1u) << (4u * level) > group.leaf;
        let box_at = 4u * (boxes + number);
        if number >= table(LEVEL_BOXES + 2u * level + 1u) || !may
            || !is_in_reach(group, box_at, reach_of(group, box_at, length_of(THICKEST))) {
            continue;
        }
        let at = atomicAdd(&counter, 1u);
        if at < FRONT {
            front[FRONT - above + at] = number;
        }
    }
}

/// Lists pairs of leaves: a workgroup those of a group of sixteen, each of which sixteen invocations look for.
@compute @workgroup_size(256)
fn list_leaf_pairs(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let first = LEAF_GROUP * workgroup_index(id);
    let kind = counted(LISTED);
    let leaf = first + lane % LEAF_GROUP;
    let is_seeking = seeks(leaf, kind);
    if is_seeking {
        atomicAdd(&counter, 1u);
    }
    // Of a single level there is no box around a group.
    let top = table(TOP_LEVEL);
    let group = seeker_in(4u * select(0u, table(LEVEL_BOXES + 2u) + workgroup_index(id), top > 0u), first, kind);
    let seeker = seeker_in(4u * min(leaf, table(LEAF_COUNT) - 1u), leaf, kind);
    // The front starts with the box of the top, whose number is 0.
    var count = min(take_count(lane), 1u);
    var above = 0u;
    for (var level = top; level > 0u && count > 0u && count <= FRONT; level--) {
        look_into(above, count, level - 1u, group, lane);
        count = take_count(lane);
        above = FRONT - above;
    }
    if count > FRONT {
        if is_seeking && lane < LEAF_GROUP {
            list_alone(seeker);
        }
        return;
    }
    for (var i = lane / LEAF_GROUP; is_seeking && i < count; i += 256u / LEAF_GROUP) {
        if lists_pair(seeker, front[above + i]) {
            list_pair(seeker, front[above + i], 4u * front[above + i]);
        }
    }
}
