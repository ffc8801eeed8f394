// What all rungs of S2's ladder ("CUDA Cloth Simulation") compute, as serial.rs does: explicit integration of masses on
// springs that lie by rows.

struct Particle {
    /// Position [m].
    x: vec3f,
    /// Velocity [m/s].
    v: vec3f,
}

/// A spring at a particle: the other end, rest length [m], stiffness [N/m], damping [kg/s].
struct Spring {
    other: u32,
    rest: f32,
    k: f32,
    d: f32,
}

struct World {
    /// Centre and radius, with the offset [m].
    ball: vec4f,
    /// On each particle [N].
    wind: vec3f,
    /// [kg/s]
    drag: f32,
    /// Height, with the offset [m].
    floor_y: f32,
    /// Kept between particles that no spring joins [m].
    thickness: f32,
    /// Of a particle [kg].
    mass: f32,
    /// Downwards [m/s²].
    gravity: f32,
    /// Length of a sub-step [s].
    h: f32,
    /// The first of the particles are held, so many.
    held: u32,
}

/// Force of a spring on the particle `p` [N]: Hooke's law, and what damps its length.
fn pull(p: Particle, other: Particle, spring: Spring) -> vec3f {
    let d = other.x - p.x;
    let distance = length(d);
    let tension = spring.k * (distance - spring.rest) + spring.d * dot(d, other.v - p.v) / distance;
    return d * (tension / distance);
}

/// The part of `a` that points against the unit vector `normal`.
fn into(a: vec3f, normal: vec3f) -> vec3f {
    return normal * min(dot(a, normal), 0.0);
}

/// The change of velocity of a particle that is `d` away from another of the same mass, and moves with `v` against it: the
/// two exchange their speeds along the line between them where they approach.
fn exchange(d: vec3f, v: vec3f) -> vec3f {
    return -into(v, normalize(d));
}
