// Normals of surfaces, in the order of operations of diagnostics/normals.rs.

#import gpu/wgsl/vector.wgsl

/// sum + (b − a) × (c − a): one product after the other, as some compilers order them anyway.
fn add_normal(sum: vec3f, a: vec3f, b: vec3f, c: vec3f) -> vec3f {
    let p = b - a;
    let q = c - a;
    return (sum + p.yzx * q.zxy) - p.zxy * q.yzx;
}

/// The unit vector along `sum`; +y where that has no length.
fn unit_or_up(sum: vec3f) -> vec3f {
    let squared = dot3(sum, sum);
    let some = squared > TINY;
    return select(vec3f(0.0, 1.0, 0.0), sum * sqrt(1.0 / select(1.0, squared, some)), some);
}
