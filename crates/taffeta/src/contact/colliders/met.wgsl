// Colliders as each node meets them.

#import contact/colliders/shape.wgsl
#import gpu/wgsl/substep.wgsl

/// The colliders that a node meets.
struct Met {
    /// Where those of all bodies begin.
    all: u32,
    /// Where those of its own body begin.
    own: u32,
    /// How many they are.
    count: u32,
}

/// The colliders that the node at a place meets in a sub-step. A body that has a friction of its own with some meets records of its
/// own. They follow those of all others, behind a record whose `kind` and `mesh` are the body's first place and how many it has.
fn met_by(place: u32, substep: u32) -> Met {
    let all = substeps[substep].first_collider;
    let count = substeps[own() + substep].colliders;
    // Only what differs among nodes goes through the loop.
    var first = all;
    for (var i = 0u; i < substeps[own()].bodies_apart; i++) {
        let list = all + count + i * (count + 1u);
        if place - colliders[list].kind < colliders[list].mesh {
            first = list + 1u;
            break;
        }
    }
    return Met(all, first, count);
}

/// One of them. All but its friction is read from the record that is the same for all nodes, so that it can stay in the registers
/// that a GPU has once for all of them.
fn collider_met(met: Met, number: u32) -> Collider {
    var collider = colliders[met.all + number];
    collider.friction = colliders[met.own + number].friction;
    return collider;
}
