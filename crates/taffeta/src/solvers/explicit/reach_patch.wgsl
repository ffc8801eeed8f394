// Nodes as springs reach them: a patch of the scene in the workgroup's own memory.

#import gpu/wgsl/state.wgsl
#import solvers/explicit/node.wgsl

/// Sub-steps that a dispatch takes at most.
override STEPS: u32 = 64u;
/// Nodes that an invocation works on at most.
const OWN: u32 = 4u;
/// Numbers that a patch has room for.
override ROOM: u32 = 4032u;
/// Numbers of a node: position [m], velocity [m/s], inverse mass [1/kg]. An odd number, so that neighbouring
/// invocations use different banks.
const NUMBERS_A_NODE: u32 = 7u;
var<workgroup> patch_numbers: array<f32, ROOM>;
/// The node at the patch's first place.
var<private> patch_base: u32;

fn patch_three(at: u32) -> vec3f {
    return vec3f(patch_numbers[at], patch_numbers[at + 1u], patch_numbers[at + 2u]);
}

fn position_of(node: u32) -> vec3f {
    return patch_three(NUMBERS_A_NODE * (node - patch_base));
}

fn velocity_of(node: u32) -> vec3f {
    return patch_three(NUMBERS_A_NODE * (node - patch_base) + 3u);
}

/// Puts a node into the patch.
fn keep(place: u32, x: vec4f, v: vec3f) {
    let at = NUMBERS_A_NODE * place;
    patch_numbers[at] = x.x;
    patch_numbers[at + 1u] = x.y;
    patch_numbers[at + 2u] = x.z;
    patch_numbers[at + 3u] = v.x;
    patch_numbers[at + 4u] = v.y;
    patch_numbers[at + 5u] = v.z;
    patch_numbers[at + 6u] = x.w;
}

/// A node of the patch; its mass is 1, or -1 once it has touched.
fn kept(place: u32) -> Node {
    let at = NUMBERS_A_NODE * place;
    return Node(vec4f(patch_three(at), patch_numbers[at + 6u]), vec4f(patch_three(at + 3u), 1.0));
}

/// Writes a node that has gone through some sub-steps to memory.
fn release(node: u32, after: Node) {
    let mass = abs(old_velocity[node].w);
    new_position[node] = after.position;
    new_velocity[node] = vec4f(after.velocity.xyz, select(mass, -mass, after.velocity.w < 0.0));
}
