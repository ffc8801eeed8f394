// The particle stages that concern a node alone.

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

/// Keeps a node out of colliders. Held nodes are not kept out.
fn touch(node: Node, substep: u32) -> Node {
    let count = substeps[substep].colliders;
    if count == 0u || !(node.position.w > 0.0) {
        return node;
    }
    let first = substeps[substep].first_collider;
    let after = contact(node.position.xyz, node.velocity.xyz, first, count, substeps[substep].h);
    let mass = select(node.velocity.w, -node.velocity.w, after.last > 0u);
    return Node(vec4f(after.x, node.position.w), vec4f(after.v, mass));
}
