// Once a frame the bins are filled again; one thread a bin.

/// As `filled` and `members`: the bins that are written.
@group(3) @binding(2) var<storage, read_write> new_filled: array<u32>;
@group(3) @binding(3) var<storage, read_write> new_members: array<u32>;
/// Particles that found no room in their bin, in all fillings.
@group(3) @binding(4) var<storage, read_write> left_out: atomic<u32>;

/// Puts the particle `i` into a bin that has `found` before it.
fn put(bin: u32, found: u32, i: u32) {
    if found < CAPACITY {
        new_members[bin * CAPACITY + found] = i;
    }
}

/// A bin to which `found` particles belong is done.
fn close(bin: u32, found: u32) {
    new_filled[bin] = min(found, CAPACITY);
    if found > CAPACITY {
        atomicAdd(&left_out, found - CAPACITY);
    }
}

/// Looks at all particles.
@compute @workgroup_size(64)
fn scan(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let number = (group.x + group.y * counts.x) * 64u + local;
    if number >= arrayLength(&new_filled) {
        return;
    }
    let bin = bin_of(number);
    var found = 0u;
    for (var i = 0u; i < arrayLength(&input); i++) {
        if all(bin_at(input[i].x) == bin) {
            put(number, found, i);
            found++;
        }
    }
    close(number, found);
}

/// Looks at the particles that were in this bin and its neighbours. One that has crossed a whole bin since is lost.
@compute @workgroup_size(64)
fn refresh(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let number = (group.x + group.y * counts.x) * 64u + local;
    if number >= arrayLength(&new_filled) {
        return;
    }
    let bin = bin_of(number);
    let low = lowest_near(bin);
    let high = highest_near(bin);
    var found = 0u;
    for (var z = low.z; z <= high.z; z++) {
        for (var y = low.y; y <= high.y; y++) {
            for (var x = low.x; x <= high.x; x++) {
                found = take_over(number_of(vec3u(x, y, z)), bin, number, found);
            }
        }
    }
    close(number, found);
}

/// Takes what belongs to `bin` now and was in the bin of number `before`; how many are found now.
fn take_over(before: u32, bin: vec3u, number: u32, found: u32) -> u32 {
    var now = found;
    let first = before * CAPACITY;
    let end = first + filled[before];
    for (var place = first; place < end; place++) {
        let i = members[place];
        if all(bin_at(input[i].x) == bin) {
            put(number, now, i);
            now++;
        }
    }
    return now;
}
