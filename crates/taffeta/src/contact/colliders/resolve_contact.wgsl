// Contact of a node with all colliders.

#import contact/colliders/contact.wgsl
#import contact/colliders/met.wgsl
#import contact/colliders/response.wgsl
#import gpu/wgsl/substep.wgsl
#import solvers/explicit/node.wgsl

/// Keeps the node at a place, which comes from `origin`, out of colliders. Pinned nodes are left as they are.
fn resolve_contact(place: u32, node: Node, origin: Origin, substep: u32) -> Node {
    if substeps[own() + substep].colliders == 0u || !(node.position.w > 0.0) {
        return node;
    }
    let after = contact(node.position.xyz, node.velocity.xyz, origin, met_by(place, substep), substeps[substep].h);
    let mass = select(node.velocity.w, -node.velocity.w, after.last > 0u);
    return Node(vec4f(after.x, node.position.w), vec4f(after.v, mass));
}
