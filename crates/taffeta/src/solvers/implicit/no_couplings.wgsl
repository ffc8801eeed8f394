// The system where springs alone are solved for.

#import contacts
#import solvers/implicit/levels.wgsl

/// The finest level's system times a vector, at a node; nothing holds it.
fn system_times(mass: f32, which: u32, node: u32) -> vec3f {
    return springs_times(mass, which, node) + taken_by_contacts(node);
}

/// A coarser level's system times a vector, at a node.
fn level_times(which: u32, node: u32) -> vec3f {
    let own = vector_of(which, node);
    var sum = times(diagonals[node].own, own);
    let range = slots_of(node);
    let first = slots[0];
    for (var at = range.x; at < range.y; at += LANES) {
        sum += times(coarse_blocks[at - first], own - vector_of(which, slots[at]));
    }
    return sum;
}

/// What other elements give a node.
fn given_by_elements(node: u32) -> ElementSums {
    return ElementSums(vec3f(0.0), Symmetric(vec3f(0.0), vec3f(0.0)));
}

/// Coarser levels need no sum of a node's blocks.
fn keep_sum(_node: u32, _sum: Symmetric) {}
