/// What all other particles change the velocity of particle `i` by [m/s].
fn others(i: u32, own: Particle) -> vec3f {
    var change = vec3f(0.0);
    // Not a number in a uniform: llvmpipe takes 65,536 turns then, most of them masked.
    for (var j = 0u; j < arrayLength(&input); j++) {
        change += touch(i, own, j);
    }
    return change;
}
