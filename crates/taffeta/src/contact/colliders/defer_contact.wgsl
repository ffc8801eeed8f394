// Where a collider is a mesh, contact is a kernel of its own, and this takes the place of resolve_contact.wgsl in the others.

#import contact/colliders/response.wgsl
#import solvers/explicit/node.wgsl

fn resolve_contact(node: Node, origin: Origin, substep: u32) -> Node {
    return node;
}
