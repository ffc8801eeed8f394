// What pulls surfaces apart that pass through each other.

#import contact/triangles/add.wgsl
#import contact/triangles/surfaces.wgsl
#import contact/triangles/tangle.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/vector.wgsl

// Words of a pull: its nodes, their weights, the direction, the thickness of both surfaces and the contact's [m]; 1 if it leads a node out
// of a collider.
const PULL_WORDS: u32 = 16u;
const PULL_WEIGHTS: u32 = 4u;
const PULL_DIRECTION: u32 = 8u;
const PULL_THICKNESS: u32 = 11u;
const PULL_SIZE: u32 = 12u;
const PULL_LED: u32 = 13u;

fn pull_number(pull: u32, word: u32) -> f32 {
    return bitcast<f32>(surface_knots[KNOT_WORDS * table(ALL_PLACES) + PULL_WORDS * pull + word]);
}

fn pull_vector(pull: u32, word: u32) -> vec3f {
    return vec3f(pull_number(pull, word), pull_number(pull, word + 1u), pull_number(pull, word + 2u));
}

/// Adds contacts that move lines along which surfaces pass through each other, and that lead nodes out of colliders.
@compute @workgroup_size(256)
fn add_pulls(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let pull = node_of(id, lane);
    if pull >= table(PULL_COUNT) {
        return;
    }
    let at = KNOT_WORDS * table(ALL_PLACES) + PULL_WORDS * pull;
    let is_led = surface_knots[at + PULL_LED] != 0u;
    if !is_led && table(IS_SOLVED) != 0u && counted(LISTED) != SOLVED {
        // In an implicit step the solver moves lines.
        return;
    }
    let nodes = vec4u(surface_knots[at], surface_knots[at + 1u], surface_knots[at + 2u], surface_knots[at + 3u]);
    let weights = vec4f(pull_vector(pull, PULL_WEIGHTS), pull_number(pull, PULL_WEIGHTS + 3u));
    let normal = pull_vector(pull, PULL_DIRECTION);
    let last = place_at(BEFORE, nodes.w);
    let apart = (place_at(BEFORE, nodes.x) - last) * weights.x
        + (place_at(BEFORE, nodes.y) - last) * weights.y + (place_at(BEFORE, nodes.z) - last) * weights.z;
    let gap = select(dot3(normal, apart), 0.0, is_led) - pull_number(pull, PULL_THICKNESS);
    add_lead(nodes, weights, normal, vec2f(gap, pull_number(pull, PULL_SIZE)), vec3u(NONE, NONE, pull));
}
