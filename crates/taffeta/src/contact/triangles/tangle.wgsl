// Surfaces that pass through each other: what becomes of their pairs (tangle.rs).

#import contact/triangles/surfaces.wgsl

// What becomes of a pair: its sides keep their distance; they do not act on each other; the vertex goes to the side of the triangle
// where its normal points, or to the other.
const APART: u32 = 0u;
const IGNORED: u32 = 1u;
const BELOW: u32 = 2u;
const ABOVE: u32 = 3u;

// Words of a place: whose nearest line it is, next to which it is, from which it is astray, whether it belongs above the other
// surface there, and next to which of the last lines of a surface with itself it is; each for both sides of lines, a bit for each
// line. Then whether it is led out of colliders.
const KNOT_WORDS: u32 = 11u;
const KNOT_OF: u32 = 0u;
const KNOT_NEXT: u32 = 2u;
const KNOT_ASTRAY: u32 = 4u;
const KNOT_ABOVE: u32 = 6u;
const KNOT_LOOSE: u32 = 8u;
const KNOT_LED: u32 = 10u;

/// Words of one of the sides of a pair.
fn knots_of(nodes: vec4u, first: u32, second: bool, word: u32) -> vec2u {
    var all = vec2u(0u);
    for (var i = 0u; i < 4u; i++) {
        if (i >= first) == second {
            let at = KNOT_WORDS * nodes[i] + word;
            all |= vec2u(surface_knots[at], surface_knots[at + 1u]);
        }
    }
    return all;
}

/// Whether what is of one side of a line is of the same line as what is of its other side.
fn meet(one: vec2u, other: vec2u) -> bool {
    return any((one & other.yx) != vec2u(0u));
}

/// Whether some nodes are corners of colliders, and others are led out of these.
fn are_led_apart(nodes: vec4u) -> bool {
    var is_led = false;
    for (var i = 0u; i < 4u; i++) {
        is_led = is_led || surface_knots[KNOT_WORDS * nodes[i] + KNOT_LED] != 0u;
    }
    return is_led && any(nodes >= vec4u(table(NODE_PLACES)));
}

/// What becomes of a pair, of whose nodes so many are its first side.
fn rule_of(nodes: vec4u, first: u32) -> u32 {
    if table(IS_TANGLED) == 0u {
        return APART;
    }
    if are_led_apart(nodes) {
        return IGNORED;
    }
    if meet(knots_of(nodes, first, false, KNOT_LOOSE), knots_of(nodes, first, true, KNOT_LOOSE)) {
        return IGNORED;
    }
    let next = knots_of(nodes, first, false, KNOT_NEXT);
    let other_next = knots_of(nodes, first, true, KNOT_NEXT);
    let astray = knots_of(nodes, first, false, KNOT_ASTRAY);
    let some = knots_of(nodes, first, false, KNOT_OF) | next;
    let others = knots_of(nodes, first, true, KNOT_OF) | other_next;
    let goes = meet(astray, others);
    if first == 1u && goes {
        let is_above = meet(astray & knots_of(nodes, first, false, KNOT_ABOVE), others);
        return select(BELOW, ABOVE, is_above);
    }
    let is_ignored = first == 2u && (goes || meet(next, other_next));
    return select(APART, IGNORED, is_ignored || meet(some, knots_of(nodes, first, true, KNOT_ASTRAY)));
}
