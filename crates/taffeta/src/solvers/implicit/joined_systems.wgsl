// Systems that contacts of surfaces and seams join: each takes the sums of all of them.

/// By system, one of those that it is joined with, or itself; never a later one.
@group(3) @binding(48) var<storage, read_write> joins: array<atomic<u32>>;

/// The first of the systems that one is joined with, as far as is known.
fn first_of(system: u32) -> u32 {
    var first = system;
    var next = atomicLoad(&joins[first]);
    while next != first {
        // The way there is shorter the next time.
        atomicMin(&joins[first], atomicLoad(&joins[next]));
        first = next;
        next = atomicLoad(&joins[first]);
    }
    return first;
}

/// Joins two systems. Whatever the order in which invocations do so, the first system of all that hang together is the least.
fn join(a: u32, b: u32) {
    var one = first_of(a);
    var other = first_of(b);
    while one != other {
        let most = max(one, other);
        let least = min(one, other);
        let before = atomicMin(&joins[most], least);
        // If another invocation has joined it meanwhile, what it has found hangs together with this, too.
        one = first_of(select(before, least, before == most));
        other = first_of(least);
    }
}
