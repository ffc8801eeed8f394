// A sub-step, in the order of S2's list; one thread a particle.

/// Force of all its springs on the particle `i` [N].
fn spring_force(i: u32, own: Particle) -> vec3f {
    var sum = vec3f(0.0);
    let end = starts[i + 1u];
    for (var s = starts[i]; s < end; s++) {
        let spring = springs[s];
        sum += pull(own, input[spring.other], spring);
    }
    return sum;
}

/// Whether a spring joins the two.
fn joined(i: u32, j: u32) -> bool {
    let end = starts[i + 1u];
    for (var s = starts[i]; s < end; s++) {
        if springs[s].other == j {
            return true;
        }
    }
    return false;
}

/// What the particle `j` changes the velocity of particle `i` by [m/s].
fn touch(i: u32, own: Particle, j: u32) -> vec3f {
    let other = input[j];
    let d = own.x - other.x;
    if !nearer(d, world.thickness) || i == j || joined(i, j) {
        return vec3f(0.0);
    }
    return exchange(d, own.v - other.v);
}

@compute @workgroup_size(64)
fn substep(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let i = (group.x + group.y * counts.x) * 64u + local;
    // Both buffers have the held ones from the start.
    if i < world.held || i >= arrayLength(&result) {
        return;
    }
    let own = input[i];
    var p = own;
    var force = spring_force(i, own) + world.wind - world.drag * own.v;
    force.y -= world.gravity * world.mass;
    let away = p.x - world.ball.xyz;
    if nearer(away, world.ball.w) {
        let normal = normalize(away);
        p.v -= into(p.v, normal);
        force -= into(force, normal);
    }
    if p.x.y < world.floor_y {
        p.v.y = max(p.v.y, 0.0);
        force.y = max(force.y, 0.0);
    }
    p.v += others(i, own);
    p.v += force * (world.h / world.mass);
    p.x += p.v * world.h;
    result[i] = p;
}
