// Who a plane stops goes on along it: what part of its way a node may make, and which plane stops it, in one word. In the order of
// operations of slide.rs.

#import gpu/wgsl/vector.wgsl

/// The word of a node that may go all its way.
const UNLIMITED: u32 = 0xffffffffu;
/// Parts are counted in so many steps, rounded down.
const PART_STEPS: f32 = 1023.0;
/// Bits of the number of steps, of each coordinate of a direction, and half the greatest of these.
const STEP_BITS: u32 = 22u;
const AXIS_BITS: u32 = 11u;
const HALF_AXIS: f32 = 1023.5;
/// A node moves away from the plane by this part of its way along it.
const TILT: f32 = 4e-3;

/// The lower half of the octahedron lies around the upper one.
fn folded(at: vec2f) -> vec2f {
    let left = vec2f(1.0) - abs(at.yx);
    return select(left, -left, at < vec2f(0.0));
}

/// A direction on an octahedron that is unfolded to a square.
fn direction(x: vec3f) -> u32 {
    let sum = abs(x.x) + abs(x.y) + abs(x.z);
    var at = x.xy / select(1.0, sum, sum > 0.0);
    at = select(at, folded(at), x.z < 0.0);
    let steps = vec2u(at * HALF_AXIS + (HALF_AXIS + 0.5));
    return (steps.x << AXIS_BITS) | steps.y;
}

/// The word of a node that may make a part of its way, for a plane from which `away` leads.
fn limit_word(part: f32, away: vec3f) -> u32 {
    let steps = min(u32(part * PART_STEPS), u32(PART_STEPS) - 1u);
    return select((steps << STEP_BITS) | direction(away), UNLIMITED, part >= 1.0);
}

/// The part of its way that a node with this word may make.
fn part_of_way(word: u32) -> f32 {
    return f32(word >> STEP_BITS) / PART_STEPS;
}

/// The unit vector of a word.
fn away_from_plane(word: u32) -> vec3f {
    let steps = vec2u(word >> AXIS_BITS, word) & vec2u((1u << AXIS_BITS) - 1u);
    let at = vec2f(steps) / HALF_AXIS - 1.0;
    let z = 1.0 - abs(at.x) - abs(at.y);
    let away = vec3f(select(at, folded(at), z < 0.0), z);
    return away / norm3(away);
}

/// What must be added to the way that is left of a node with this word [m] for it to lead along the plane.
fn lift_of(left: vec3f, word: u32) -> vec3f {
    let away = away_from_plane(word);
    let missing = TILT * norm3(left) - dot3(left, away);
    return select(vec3f(0.0), away * missing, missing > 0.0);
}
