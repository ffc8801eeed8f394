// Products of vectors, in the order of operations of real.rs.

/// Smallest squared length that is divided by [m²]: keeps 1/l finite as l → 0.
const TINY: f32 = 1e-30;

fn dot3(a: vec3f, b: vec3f) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

fn cross3(a: vec3f, b: vec3f) -> vec3f {
    return vec3f(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

fn norm3(a: vec3f) -> f32 {
    return sqrt(dot3(a, a));
}
