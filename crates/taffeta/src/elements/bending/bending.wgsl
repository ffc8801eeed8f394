// Bending by a shape operator of each triangle, from the fold angles at its three edges.
//
// S = Σ (θ_e − θ₀_e) P_e, where P_e [1/m] is what a fold at an edge says of the curvature (curvature.rs). The energy is
// A/2 (B₁₁S₁₁² + B₂₂S₂₂² + 2 B₁₂S₁₁S₂₂ + 4 B₆₆S₁₂²) [J]: Grinspun, Gingold, Reisman, Zorin, "Computing discrete shape operators on
// general meshes", 2006. It is a quadratic form of three angles, M, of which an element keeps the factor L with M = L Lᵀ.

#import gpu/wgsl/angle.wgsl
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

/// What a fold gives the ends of its edge and the node on its other side.
struct Shares {
    first: vec3f,
    second: vec3f,
    far: vec3f,
}

/// A fold, and the triangle on its other side. The gradient of its angle is along the normals of both triangles.
struct Fold {
    /// Normal of the triangle on the other side, over its square [1/m²].
    normal: vec3f,
    theta: f32,
    /// Squared length of the edge [m²], and one over its length [1/m]: 0 where a triangle has no area.
    squared: f32,
    inverse: f32,
    /// The second end's share in where that triangle's height stands on the edge, times the squared length [m²].
    foot: f32,
    /// What the gradient is multiplied by: less than 1 on triangles that are squashed to slivers.
    factor: f32,
}

/// The folds at the edges across from each corner.
struct Folds {
    /// Normal of the triangle, over its square [1/m²].
    normal: vec3f,
    /// Shares of corners in where heights stand, times squared lengths [m²]: less the products of the edges that meet in c, a, b.
    feet: vec3f,
    a: Fold,
    b: Fold,
    c: Fold,
}

/// The triangle of an element: its normal, one over the square of that, and whether it has an area.
struct Own {
    normal: vec3f,
    inverse: f32,
    has_area: bool,
}

/// The fold at an edge, with `far` from its first end to the node on the other side. `feet`: shares of its first and second end
/// in where the triangle's own height stands, times the squared length [m²].
fn fold_at(own: Own, edge: vec3f, far: vec3f, feet: vec2f, steepest: f32) -> Fold {
    let normal = cross3(far, edge);
    let squared = dot3(edge, edge);
    let area = dot3(normal, normal);
    let foot = dot3(far, edge);
    if !(own.has_area && squared > TINY && area > TINY) {
        return Fold(normal, 0.0, squared, 0.0, foot, 1.0);
    }
    let length = sqrt(squared);
    let inverse = 1.0 / length;
    let over_area = 1.0 / area;
    let sine = -(dot3(own.normal, far) * length);
    let cosine = dot3(own.normal, normal);
    let theta = angle_of(sine, cosine);
    let rest = squared - foot;
    let at_ends = (feet.x * feet.x + feet.y * feet.y) * own.inverse
        + (foot * foot + rest * rest) * over_area
        + 2.0 * (cosine * own.inverse) * ((feet.x * rest + feet.y * foot) * over_area);
    let steep = squared * (own.inverse + over_area) + at_ends * (inverse * inverse);
    let factor = select(1.0, sqrt(steepest / select(1.0, steep, steep > steepest)), steep > steepest);
    return Fold(normal * over_area, theta, squared, inverse, foot, factor);
}

fn folds_of(x: Six, steepest: vec3f) -> Folds {
    let a = x.c - x.b;
    let b = x.a - x.c;
    let c = x.b - x.a;
    let normal = cross3(c, a);
    let square = dot3(normal, normal);
    let has_area = square > TINY;
    let own = Own(normal, 1.0 / select(1.0, square, has_area), has_area);
    let feet = vec3f(-dot3(a, b), -dot3(b, c), -dot3(c, a));
    return Folds(
        normal * own.inverse,
        feet,
        fold_at(own, a, x.d - x.b, feet.xz, steepest.x),
        fold_at(own, b, x.e - x.c, feet.yx, steepest.y),
        fold_at(own, c, x.f - x.a, feet.zy, steepest.z),
    );
}

fn factors_of(folds: Folds) -> vec3f {
    return vec3f(folds.a.factor, folds.b.factor, folds.c.factor);
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

/// What a number that is divided by the edge's length gives its first end, its second, and the far node.
fn share_of(fold: Fold, number: f32) -> Shares {
    return Shares(
        fold.normal * ((fold.squared - fold.foot) * number),
        fold.normal * (fold.foot * number),
        fold.normal * -(fold.squared * number),
    );
}

/// Sum of the edges' gradients, each times a number.
fn sum_of_folds(folds: Folds, times: vec3f) -> Six {
    let x = folds.a.inverse * times.x;
    let y = folds.b.inverse * times.y;
    let z = folds.c.inverse * times.z;
    // Between corners: from a to b, from b to c, from c to a.
    let ab = folds.feet.x * (y - x);
    let bc = folds.feet.y * (z - y);
    let ca = folds.feet.z * (x - z);
    let of_a = share_of(folds.a, x);
    let of_b = share_of(folds.b, y);
    let of_c = share_of(folds.c, z);
    return Six(
        folds.normal * (ab - ca) + (of_b.second + of_c.first),
        folds.normal * (bc - ab) + (of_c.second + of_a.first),
        folds.normal * (ca - bc) + (of_a.second + of_b.first),
        of_a.far,
        of_b.far,
        of_c.far,
    );
}

/// How fast a fold's angle changes, times the edge's length, where its second end and the far node move like this beside the first,
/// and the triangle itself does not move [m/s].
fn fold_rate(fold: Fold, second: vec3f, far: vec3f) -> f32 {
    return fold.foot * dot3(fold.normal, second) - fold.squared * dot3(fold.normal, far);
}

/// How fast the angles change [rad/s].
fn rates_of(folds: Folds, v: Six) -> vec3f {
    let a = v.c - v.b;
    let b = v.a - v.c;
    let c = v.b - v.a;
    let by_c = folds.feet.x * dot3(folds.normal, c);
    let by_a = folds.feet.y * dot3(folds.normal, a);
    let by_b = folds.feet.z * dot3(folds.normal, b);
    return vec3f(
        folds.a.inverse * (by_c - by_b + fold_rate(folds.a, a, v.d - v.b)),
        folds.b.inverse * (by_a - by_c + fold_rate(folds.b, b, v.e - v.c)),
        folds.c.inverse * (by_b - by_a + fold_rate(folds.c, c, v.f - v.a)),
    );
}

/// Forces [N] on the nodes at positions `x` [m] with velocities `v` [m/s].
fn bending_forces(plate: Plate, x: Six, v: Six) -> Six {
    let folds = folds_of(x, plate.steepest);
    let factors = factors_of(folds);
    let strain = factors * (beyond(folds, plate.rest) + plate.damping * rates_of(folds, v));
    let t = transposed_times(plate, strain);
    let moments = vec3f(
        plate.first.x * t.x,
        plate.first.y * t.x + plate.others.x * t.y,
        plate.first.z * t.x + plate.others.y * t.y + plate.others.z * t.z,
    );
    return sum_of_folds(folds, -(factors * moments));
}

/// Energy [J].
fn bending_energy(plate: Plate, x: Six) -> f32 {
    let t = transposed_times(plate, beyond(folds_of(x, plate.steepest), plate.rest));
    return 0.5 * (t.x * t.x + t.y * t.y + t.z * t.z);
}
