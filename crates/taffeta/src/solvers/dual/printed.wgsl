// The row of a constraint as its paper prints it, to compare with.
//
// Source: Va, Choi, Hong, "Real-Time Cloth Simulation Using Compute Shader in Unity3D for AR/VR Contents", 2021, §2.2:
// Φ = l² − L² with the gradient 2 d, and no compliance.

/// s, s² D and Φ/s of a row with s = 2 l, so that s n is the gradient; from l² and l.
fn printed_row(squared: f32, length: f32, rest_length: f32) -> vec3f {
    let twice = length + length;
    return vec3f(twice, 0.0, (squared - rest_length * rest_length) / twice);
}
