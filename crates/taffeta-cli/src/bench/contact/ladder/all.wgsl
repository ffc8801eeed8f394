/// What all other particles change the velocity of particle `i` by [m/s].
fn others(i: u32, own: Particle) -> vec3f {
    var change = vec3f(0.0);
    for (var j = 0u; j < world.count; j++) {
        change += touch(i, own, j);
    }
    return change;
}
