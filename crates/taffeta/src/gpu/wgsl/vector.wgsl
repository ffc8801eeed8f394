// Products of vectors, in the order of operations of real.rs.

/// Smallest squared length that is divided by [m²]: keeps 1/l finite as l → 0.
const TINY: f32 = 1e-30;
/// Distance from 1 to the next number.
const EPSILON: f32 = 1.1920929e-7;
/// A length beyond all scenes [m].
const FAR: f32 = 1e30;

fn dot3(a: vec3f, b: vec3f) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

fn cross3(a: vec3f, b: vec3f) -> vec3f {
    return vec3f(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

fn norm3(a: vec3f) -> f32 {
    return sqrt(dot3(a, a));
}

/// Whether a number is infinite or none. Comparisons may be taken to be of finite numbers; bits are not.
fn is_odd(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) == 0x7f800000u;
}

fn are_odd(x: vec3f) -> bool {
    return is_odd(x.x) || is_odd(x.y) || is_odd(x.z);
}
