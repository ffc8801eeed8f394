// Colliders as each node meets them.

#import contact/colliders/shape.wgsl
#import gpu/wgsl/substep.wgsl

/// Where the colliders begin that the node at a place meets in a sub-step. A body that has a friction of its own with some
/// meets records of its own. They follow those of all others, behind a record whose `kind` and `mesh` are the body's first
/// place and how many it has.
fn first_met(place: u32, substep: u32) -> u32 {
    let all = substeps[substep].first_collider;
    let count = substeps[own() + substep].colliders;
    for (var i = 0u; i < substeps[own()].bodies_apart; i++) {
        let list = all + count + i * (count + 1u);
        if place - colliders[list].kind < colliders[list].mesh {
            return list + 1u;
        }
    }
    return all;
}
