// Contact of nodes that are moved once more after contact.

#import contact/colliders/response.wgsl
#import gpu/wgsl/state.wgsl
#import solvers/explicit/node.wgsl
#import meshes
#import resolve_contact

/// Keeps a node out of colliders again, and writes its state. It was at `x` with the velocity `v`, and has been moved
/// since. A node that was in contact before stays marked.
fn resolve_contact_again(place: u32, x: vec4f, v: vec4f, moved_to: vec3f, velocity: vec3f) {
    let moved = Node(vec4f(moved_to, x.w), vec4f(velocity, abs(v.w)));
    var after = moved;
    if !is_led_out(place) {
        after = resolve_contact(place, moved, Origin(x.xyz, false), 0u);
    }
    let mass = select(after.velocity.w, -abs(v.w), v.w < 0.0);
    new_position[place] = after.position;
    new_velocity[place] = vec4f(after.velocity.xyz, mass);
}
