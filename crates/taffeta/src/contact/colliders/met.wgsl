// Colliders as each node meets them. met.rs is its twin.

#import contact/colliders/shape.wgsl
#import gpu/wgsl/substep.wgsl

/// How lists of bodies differ from that of all colliders: there are none; by friction alone; some colliders are not among them.
override LISTS_DIFFER: u32 = 0u;
const DIFFER_BY_FRICTION: u32 = 1u;
const DIFFER_BY_COLLIDERS: u32 = 2u;

/// The colliders that a node meets.
struct Met {
    /// Where those of all bodies begin.
    all: u32,
    /// Where those of its own body begin.
    own: u32,
    /// How many the latter are.
    count: u32,
}

/// The colliders that the node at a place meets in a sub-step. Behind all of them is a record for each range of places: its first
/// place in `kind`, and in `mesh` where its list begins, counted from the first of all colliders, or 0 if it meets them all. In front
/// of a list is a record whose `mesh` is how many it has.
fn met_by(place: u32, substep: u32) -> Met {
    let all = substeps[substep].first_collider;
    let count = substeps[own() + substep].colliders;
    if LISTS_DIFFER == 0u {
        return Met(all, all, count);
    }
    // The last range that does not begin behind the place.
    let ranges = all + count;
    var low = 0u;
    var high = substeps[own()].collider_ranges;
    while high > low + 1u {
        let middle = (low + high) / 2u;
        let is_before = colliders[ranges + middle].kind <= place;
        low = select(low, middle, is_before);
        high = select(middle, high, is_before);
    }
    let list = colliders[ranges + low].mesh;
    let has_own = high > 0u && list > 0u;
    let first = select(all, all + list, has_own);
    if LISTS_DIFFER == DIFFER_BY_FRICTION {
        return Met(all, first, count);
    }
    let number = colliders[select(ranges, first - 1u, has_own)].mesh;
    return Met(all, first, select(count, number, has_own));
}

/// One of them. Where they are the same for all nodes but for friction, the rest is read from the record that all have in common, so
/// that it can stay in the registers that a GPU has once for all of them.
fn collider_met(met: Met, number: u32) -> Collider {
    if LISTS_DIFFER == DIFFER_BY_COLLIDERS {
        return colliders[met.own + number];
    }
    var collider = colliders[met.all + number];
    if LISTS_DIFFER == DIFFER_BY_FRICTION {
        collider.friction = colliders[met.own + number].friction;
    }
    return collider;
}
