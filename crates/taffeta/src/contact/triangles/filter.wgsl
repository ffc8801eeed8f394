// How far the nodes of a pair may go, in the order of operations of filter.rs.

#import gpu/wgsl/vector.wgsl

/// Least part of the gap that a side gets, and the most.
const LEAST_SHARE: f32 = 0.05;
const MOST_SHARE: f32 = 0.95;
/// Part of the gap that is left.
const PLANE_LEFT: f32 = 0.15;
/// Part of its distance to the plane that a node may use up.
const SHARE: f32 = 0.85;
/// Part of the thickness that a collider which moves leaves to what is in its way.
const ROOM_BEFORE: f32 = 0.5;
/// Part of its distance, and part of twice the least distance, that a pair keeps which is squeezed, and what part of where it goes that
/// is.
const SQUEEZED_PART: f32 = 0.5;
const SQUEEZED_FLOOR: f32 = 0.25;
const SQUEEZED_AHEAD: f32 = 0.98;
/// The least distance to the plane: relative to the extent of a pair, in units in the last place, and at most relative to the
/// thickness.
const SLENDER: f32 = 4e-3;
const DIGITS: f32 = 16.0;
const THIN: f32 = 0.25;
/// By how much of itself a distance may differ of nodes that move as one.
const AS_ONE: f32 = 1e-3;

/// The least distance to the plane that is kept [m].
fn floor_of(extent: f32, thickness: f32, far: f32) -> f32 {
    let slender = SLENDER * extent + DIGITS * EPSILON * far;
    let thin = THIN * thickness;
    return select(thin, slender, slender < thin);
}

/// Whether four nodes that began at `start` [m] are as far from each other at `x` [m] as there.
fn keeps_shape(start: array<vec3f, 4>, x: array<vec3f, 4>) -> bool {
    var far = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let size = abs(x[i]);
        far = max(far, max(size.x, max(size.y, size.z)));
    }
    let digits = DIGITS * EPSILON * far;
    var keeps = true;
    for (var i = 0u; i < 4u; i++) {
        for (var j = 0u; j < i; j++) {
            let wanted = norm3(start[i] - start[j]);
            let off = abs(norm3(x[i] - x[j]) - wanted);
            keeps = keeps && off <= AS_ONE * wanted + digits;
        }
    }
    return keeps;
}

/// Where the first side of a pair, given as for `limits_of`, must go [m] so that its sides end as far apart along their normal as a
/// plane that goes along needs, and not much nearer than they were if they are nearer than a part of their thickness, nor any nearer
/// than twice the least distance: pushes come in every sub-step. Sides that are `squeezed` come nearer than that, for there is no
/// room. 0 if they do without it.
fn push_apart(
    x: array<vec3f, 4>,
    moves: array<vec3f, 4>,
    first: u32,
    apart: vec3f,
    thickness: f32,
    far: f32,
    squeezed: bool,
) -> vec3f {
    let length = norm3(apart);
    let normal = apart * (1.0 / select(1.0, length, length > TINY));
    var low = FAR;
    var high = -FAR;
    var low_end = FAR;
    var high_end = -FAR;
    var extent = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let is_first = i < first;
        let at = dot3(normal, x[i]);
        let end = at + dot3(normal, moves[i]);
        low = select(low, at, is_first && at < low);
        low_end = select(low_end, end, is_first && end < low_end);
        high = select(high, at, !is_first && at > high);
        high_end = select(high_end, end, !is_first && end > high_end);
        let size = abs(x[i]);
        extent = max(extent, max(size.x, max(size.y, size.z)));
    }
    let before = low - high;
    let after = low_end - high_end;
    let twice = 2.0 * floor_of(extent, thickness, far);
    let least = PLANE_LEFT * before + twice;
    let kept_at_least = min(before, select(twice, SQUEEZED_FLOOR * twice, squeezed));
    let as_before = max(select(SHARE, SQUEEZED_PART, squeezed) * before, kept_at_least);
    let wanted = min(as_before, max(least, ROOM_BEFORE * thickness));
    // It goes a little farther than it must, so that once is enough.
    let missing = wanted / select(SHARE, SQUEEZED_AHEAD, squeezed) - after;
    return select(vec3f(0.0), normal * missing, before > 0.0 && after < wanted);
}

/// The part of its motion that each node of a pair may make. `x` are its nodes before, relative to one of them [m], `moves` their
/// motion [m], `apart` the vector between closest points [m]; `far` is the largest coordinate [m]. `together` allows a plane that
/// goes along.
fn limits_of(
    x: array<vec3f, 4>,
    moves: array<vec3f, 4>,
    first: u32,
    apart: vec3f,
    thickness: f32,
    far: f32,
    together: bool,
) -> vec4f {
    let length = norm3(apart);
    let normal = apart * (1.0 / select(1.0, length, length > TINY));
    let at = vec4f(dot3(normal, x[0]), dot3(normal, x[1]), dot3(normal, x[2]), dot3(normal, x[3]));
    let ways = vec4f(
        dot3(normal, moves[0]), dot3(normal, moves[1]), dot3(normal, moves[2]), dot3(normal, moves[3]),
    );
    let ends = at + ways;
    var low = at.x;
    var high = at.w;
    var low_end = ends.x;
    var high_end = ends.w;
    var of_first = 0.0;
    var of_second = 0.0;
    var extent = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let is_first = i < first;
        low = select(low, at[i], is_first && at[i] < low);
        low_end = select(low_end, ends[i], is_first && ends[i] < low_end);
        of_first = select(of_first, -ways[i], is_first && !(of_first > -ways[i]));
        high = select(high, at[i], !is_first && at[i] > high);
        high_end = select(high_end, ends[i], !is_first && ends[i] > high_end);
        of_second = select(of_second, ways[i], !is_first && !(of_second > ways[i]));
        let size = abs(x[i]);
        extent = max(extent, max(size.x, max(size.y, size.z)));
    }
    let gap = low - high;
    let sum = of_first + of_second;
    var share = select(1.0, of_second, sum > 0.0) / select(2.0, sum, sum > 0.0);
    share = select(LEAST_SHARE, share, share > LEAST_SHARE);
    share = select(MOST_SHARE, share, share < MOST_SHARE);
    let level = high + share * gap;
    let kept_at_least = floor_of(extent, thickness, far);
    let goes_along = PLANE_LEFT * gap + 2.0 * kept_at_least;
    let limited = gap > 0.0 && !(together && low_end - high_end >= goes_along);
    var parts = vec4f(1.0);
    for (var i = 0u; i < 4u; i++) {
        let room = select(level - at[i], at[i] - level, i < first);
        let towards = select(ways[i], -ways[i], i < first);
        let kept = select(kept_at_least, room, room < kept_at_least);
        let left = room * PLANE_LEFT;
        let allowed = room - select(left, kept, kept > left);
        let held = limited && towards > allowed;
        let way = select(0.0, allowed, allowed > 0.0);
        parts[i] = select(1.0, way / select(1.0, towards, held), held);
    }
    return parts;
}
