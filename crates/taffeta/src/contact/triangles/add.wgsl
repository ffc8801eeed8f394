// Contacts as they are found, in any order.

#import contact/triangles/impulse.wgsl
#import contact/triangles/surfaces.wgsl

fn put_contact(one: SurfaceContact) {
    // Bits of positive numbers have the order of the numbers.
    atomicMin(&surface_work[NEAREST], bitcast<u32>(max(1.0 + one.gap / one.thickness, 0.0)));
    let number = atomicAdd(&surface_work[CONTACTS], 1u);
    if number >= table(CONTACT_ROOM) {
        return;
    }
    surface_contacts[number] = one;
    for (var i = 0u; i < 4u; i++) {
        let node = one.nodes[i];
        if one.weights[i] != 0.0 && node < table(NODE_PLACES) && atomicAdd(&surface_work[count_at(node)], 1u) == 0u {
            set_counted(touched_at(atomicAdd(&surface_work[TOUCHED], 1u)), node);
        }
    }
}

/// Adds a contact that leads nodes where they belong: their weights, its normal, and its gap and thickness [m].
fn add_lead(nodes: vec4u, weights: vec4f, normal: vec3f, lengths: vec2f, order: vec3u) {
    put_contact(SurfaceContact(
        nodes, weights, normal, lengths.x, vec3f(0.0), 0.0, vec3f(0.0), lengths.y, order, 0.0, vec3f(0.0), 0.0, 1u, 0.0,
    ));
}
