// Loads on single nodes: uniform wind, linear drag, shared torques.

#import gpu/wgsl/vector.wgsl

/// Uniform wind force [N] less linear drag [kg/s]: f = w − c v.
fn wind_and_drag(wind: vec3f, drag: f32, velocity: vec3f) -> vec3f {
    return wind - drag * velocity;
}

/// Lever of a node about an axis through `about`: a × r [m], `axis` of unit length.
fn lever(x: vec3f, axis: vec3f, about: vec3f) -> vec3f {
    return cross3(axis, x - about);
}

/// The factor [N/m] on each lever so that the moments about the axis add up to `torque` [N·m], from Σ|a × r|² [m²].
fn torque_factor(torque: f32, sum: f32) -> f32 {
    let some = sum > TINY;
    return select(0.0, torque / select(1.0, sum, some), some);
}
