// Damped linear springs.
//
// Source: Va, Choi, Hong, "Real-Time Cloth Simulation Using Compute Shader in Unity3D for AR/VR Contents", 2021,
// eq. 1. With d = x_b − x_a [m], l = |d|, Δv = v_b − v_a [m/s], stiffness k [N/m], damping c [kg/s]:
// f_a = [k (l − L) + c Δv·d/l] d/l, f_b = −f_a [N].

#import gpu/wgsl/vector.wgsl

/// The factor [N/m] that turns d into the force on a: f_a = factor · d.
fn spring_factor(d: vec3f, dv: vec3f, k: f32, damping: f32, rest_length: f32) -> f32 {
    let length_squared = dot3(d, d);
    let squared = select(length_squared, TINY, length_squared < TINY);
    let inverse_squared = 1.0 / squared;
    let inverse = sqrt(inverse_squared);
    return k - k * rest_length * inverse + damping * (dot3(dv, d) * inverse_squared);
}

/// Energy ½ k (l − L)² [J].
fn spring_energy(length: f32, k: f32, rest_length: f32) -> f32 {
    let stretch = length - rest_length;
    return 0.5 * k * stretch * stretch;
}
