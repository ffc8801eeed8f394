// Symplectic Euler: v += h (w f + g), x += h v.
//
// Source: Va, Choi, Hong, "Real-Time Surface-Based Volume Constraints on Mass-Spring Model in Unity3D", 2023,
// eqs. 2–3, with the inverse mass w [1/kg]; w = 0 is a held node, which gravity does not move either.

/// New velocity [m/s] from velocity, force [N] and gravity [m/s²] over a step `h` [s].
fn new_velocity_of(v: vec3f, force: vec3f, inverse_mass: f32, gravity: vec3f, h: f32) -> vec3f {
    let pull = select(vec3f(0.0), gravity, inverse_mass > 0.0);
    return v + h * (inverse_mass * force + pull);
}

/// New position [m] from position and **new** velocity.
fn new_position_of(x: vec3f, new_velocity: vec3f, h: f32) -> vec3f {
    return x + h * new_velocity;
}
