// The particle stages that concern a node alone.

#import gpu/wgsl/substep.wgsl
#import solvers/explicit/euler.wgsl

struct Node {
    position: vec4f,
    velocity: vec4f,
}

/// New velocity, then new position.
fn integrate(x: vec4f, v: vec4f, force: vec3f, substep: u32) -> Node {
    let h = substeps[substep].h;
    let velocity = new_velocity_of(v.xyz, force, x.w, substeps[substep].gravity, h);
    return Node(vec4f(new_position_of(x.xyz, velocity, h), x.w), vec4f(velocity, abs(v.w)));
}
