// Replaces surface.wgsl if no collider is a mesh, and in kernels that leave contact to another.

#import contact/colliders/response.wgsl
#import contact/colliders/shape.wgsl

/// Where nodes may be led out of colliders, contact is a kernel that sees `mesh_data`.
fn is_led_out(_place: u32) -> bool {
    return false;
}

fn collide_mesh(node: ContactState, origin: Origin, collider: Collider, number: u32, h: f32) -> ContactState {
    return node;
}

fn mesh_penetration(collider: Collider, x: vec3f) -> Depth {
    return Depth(vec3f(0.0), -FAR);
}
