// Replaces resolve_contact.wgsl in kernels that leave contact to a kernel of its own, because a collider is a mesh.

#import contact/colliders/response.wgsl
#import solvers/explicit/node.wgsl

fn resolve_contact(_place: u32, node: Node, origin: Origin, substep: u32) -> Node {
    return node;
}
