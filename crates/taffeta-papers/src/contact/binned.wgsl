/// What the particles in the 3 × 3 × 3 bins around particle `i` change its velocity by [m/s].
fn others(i: u32, own: Particle) -> vec3f {
    var change = vec3f(0.0);
    let bin = bin_at(own.x);
    let low = lowest_near(bin);
    let high = highest_near(bin);
    for (var z = low.z; z <= high.z; z++) {
        for (var y = low.y; y <= high.y; y++) {
            for (var x = low.x; x <= high.x; x++) {
                change += others_in(i, own, number_of(vec3u(x, y, z)));
            }
        }
    }
    return change;
}

fn others_in(i: u32, own: Particle, bin: u32) -> vec3f {
    var change = vec3f(0.0);
    let first = bin * CAPACITY;
    let end = first + filled[bin];
    for (var place = first; place < end; place++) {
        change += touch(i, own, members[place]);
    }
    return change;
}
