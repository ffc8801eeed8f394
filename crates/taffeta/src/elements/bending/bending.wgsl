// Bending by a shape operator of each triangle, from the fold angles at its three edges.
//
// S = Σ (θ_e − θ₀_e) P_e, where P_e [1/m] is what a fold at an edge says of the curvature (curvature.rs). The energy is
// A/2 (B₁₁S₁₁² + B₂₂S₂₂² + 2 B₁₂S₁₁S₂₂ + 4 B₆₆S₁₂²) [J]: Grinspun, Gingold, Reisman, Zorin, "Computing discrete shape operators on
// general meshes", 2006. It is a quadratic form of three angles, M, of which an element keeps the factor L with M = L Lᵀ.

#import elements/hinge/hinge.wgsl
#import gpu/wgsl/vector.wgsl

/// Angles at rest [rad]; the Σ|∇θ|² [rad²/m²] past which an edge gets no stiffer; L by columns: 11, 21, 31 and 22, 32, 33;
/// damping time [s].
struct Plate {
    rest: vec3f,
    steepest: vec3f,
    first: vec3f,
    others: vec3f,
    damping: f32,
}

/// One vector for each node.
struct Six {
    a: vec3f,
    b: vec3f,
    c: vec3f,
    d: vec3f,
    e: vec3f,
    f: vec3f,
}

/// The folds at the edges across from each corner, and what their gradients are multiplied by.
struct Folds {
    a: Fold,
    b: Fold,
    c: Fold,
    factors: vec3f,
}

fn factor_of(fold: Fold, steepest: f32) -> f32 {
    let steep = steepness(fold);
    return select(1.0, sqrt(steepest / select(1.0, steep, steep > steepest)), steep > steepest);
}

fn folds_of(x: Six, steepest: vec3f) -> Folds {
    let a = fold_of(x.b, x.c, x.a, x.d);
    let b = fold_of(x.c, x.a, x.b, x.e);
    let c = fold_of(x.a, x.b, x.c, x.f);
    return Folds(a, b, c, vec3f(factor_of(a, steepest.x), factor_of(b, steepest.y), factor_of(c, steepest.z)));
}

/// Angles beyond those at rest.
fn beyond(folds: Folds, rest: vec3f) -> vec3f {
    return vec3f(
        wrap(folds.a.theta - rest.x),
        wrap(folds.b.theta - rest.y),
        wrap(folds.c.theta - rest.z),
    );
}

/// Lᵀ times three numbers, one for each edge.
fn transposed_times(plate: Plate, v: vec3f) -> vec3f {
    return vec3f(
        plate.first.x * v.x + plate.first.y * v.y + plate.first.z * v.z,
        plate.others.x * v.y + plate.others.y * v.z,
        plate.others.z * v.z,
    );
}

/// Sum of the edges' gradients, each times a number.
fn sum_of_folds(folds: Folds, times: vec3f) -> Six {
    return Six(
        folds.a.at_c * times.x + folds.b.at_b * times.y + folds.c.at_a * times.z,
        folds.a.at_a * times.x + folds.b.at_c * times.y + folds.c.at_b * times.z,
        folds.a.at_b * times.x + folds.b.at_a * times.y + folds.c.at_c * times.z,
        folds.a.at_d * times.x,
        folds.b.at_d * times.y,
        folds.c.at_d * times.z,
    );
}

/// How fast a fold's angle changes [rad/s].
fn fold_rate(fold: Fold, a: vec3f, b: vec3f, c: vec3f, d: vec3f) -> f32 {
    return dot3(fold.at_a, a) + dot3(fold.at_b, b) + dot3(fold.at_c, c) + dot3(fold.at_d, d);
}

/// Forces [N] on the nodes at positions `x` [m] with velocities `v` [m/s].
fn bending_forces(plate: Plate, x: Six, v: Six) -> Six {
    let folds = folds_of(x, plate.steepest);
    let rates = vec3f(
        fold_rate(folds.a, v.b, v.c, v.a, v.d),
        fold_rate(folds.b, v.c, v.a, v.b, v.e),
        fold_rate(folds.c, v.a, v.b, v.c, v.f),
    );
    let strain = folds.factors * (beyond(folds, plate.rest) + plate.damping * rates);
    let t = transposed_times(plate, strain);
    let moments = vec3f(
        plate.first.x * t.x,
        plate.first.y * t.x + plate.others.x * t.y,
        plate.first.z * t.x + plate.others.y * t.y + plate.others.z * t.z,
    );
    return sum_of_folds(folds, -(folds.factors * moments));
}

/// Energy [J].
fn bending_energy(plate: Plate, x: Six) -> f32 {
    let t = transposed_times(plate, beyond(folds_of(x, plate.steepest), plate.rest));
    return 0.5 * (t.x * t.x + t.y * t.y + t.z * t.z);
}
