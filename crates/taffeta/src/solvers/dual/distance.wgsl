// Springs as constraints: implicit constraint enforcement.
//
// Source: Va, Choi, Hong, "Real-Time Cloth Simulation Using Compute Shader in Unity3D for AR/VR Contents", 2021, §2.2;
// the compliance after Servin, Lacoursière and Melin, "Interactive Simulation of Elastic Deformable Materials", 2006.
//
// Between nodes a and b, with d = x_b − x_a, l = |d|, n = d/l and J u = n·(u_b − u_a): the forces λ [N] of all
// constraints solve
//
// (J W Jᵀ + D) λ = c + J v*/h,
//
// where v* is the velocity that all other forces would give. With stiffness k and damping e of the material,
// D = 1/(h (k h + e)) and c = k (l − L)/(h (k h + e)): that is, λ = k (l − L) + e l̇ at the end of the step, in which l
// changes along n. Each row and column is multiplied by its s, so that the diagonal of the system is 1.

#import gpu/wgsl/vector.wgsl
#import solvers/dual/printed.wgsl

/// The softness of a constraint.
struct Softness {
    /// Compliance 1/(h (k h + e)) [1/kg]; 0: none but `epsilon`.
    compliance: f32,
    /// Factor of the elongation in the right side, k/(h (k h + e)) [1/s²].
    rate: f32,
    /// Compliance relative to the diagonal.
    epsilon: f32,
    form: u32,
}

/// In `Softness`: C = l − L with compliance.
const COMPLIANT: u32 = 0u;
/// In `Softness`: as the paper has them, Φ = l² − L² without compliance.
const PRINTED_CONSTRAINT: u32 = 1u;

/// One row of the system.
struct ConstraintRow {
    /// s n, towards the second end.
    direction: vec3f,
    /// s² D.
    compliance: f32,
    /// s c.
    right: f32,
    /// s.
    scale: f32,
}

/// Of a spring of stiffness `k` [N/m] and damping `d` [kg/s] over a step `h` [s]. One of them is more than 0.
fn spring_softness(k: f32, d: f32, epsilon: f32, form: u32, h: f32) -> Softness {
    if form == PRINTED_CONSTRAINT {
        return stiff_softness(0.0, form, h);
    }
    let compliance = 1.0 / (h * (k * h + d));
    return Softness(compliance, k * compliance, epsilon, form);
}

/// Without a material: excess length is closed within a step `h` [s], as far as `epsilon` permits.
fn stiff_softness(epsilon: f32, form: u32, h: f32) -> Softness {
    return Softness(0.0, 1.0 / (h * h), select(epsilon, 0.0, form == PRINTED_CONSTRAINT), form);
}

/// The row of a constraint: `d` from its first to its second end [m], the sum of their inverse masses [1/kg], and the
/// target length [m]. With two pinned ends, the row is 0.
fn constraint_row(softness: Softness, d: vec3f, inverse_mass: f32, rest_length: f32) -> ConstraintRow {
    let length_squared = dot3(d, d);
    let squared = select(length_squared, TINY, length_squared < TINY);
    let length = sqrt(squared);
    let inverse = 1.0 / length;
    var compliance = softness.compliance + softness.epsilon * inverse_mass;
    var scale = 1.0 / sqrt(inverse_mass + compliance);
    var off = length - rest_length;
    if softness.form == PRINTED_CONSTRAINT {
        let printed = printed_row(squared, length, rest_length);
        scale = printed.x;
        compliance = printed.y;
        off = printed.z;
    }
    scale = select(0.0, scale, inverse_mass > 0.0);
    let along = scale * inverse;
    return ConstraintRow(along * d, scale * scale * compliance, scale * (softness.rate * off), scale);
}

/// Rounding error of a position near `x` [m] in the right side of a row. The solve is no more accurate than that.
fn row_noise(row: ConstraintRow, rate: f32, x: vec3f) -> f32 {
    return row.scale * (rate * (EPSILON * (abs(x.x) + abs(x.y) + abs(x.z))));
}

/// The scalars of conjugate gradients with one reduction an iteration.
///
/// Source: Chronopoulos and Gear, "s-step iterative methods for symmetric linear systems", 1989.
struct Conjugate {
    /// r·r of the iteration before.
    gamma: f32,
    /// Length of the step before.
    alpha: f32,
}

/// A step of conjugate gradients.
struct ConjugateStep {
    /// Along the new direction.
    alpha: f32,
    /// Factor of the old direction in the new one.
    beta: f32,
    /// Whether the curvature is positive.
    is_there: bool,
}

/// The step along the new direction, and the factor of the old one in it, from r·r and r·A r.
fn conjugate_step(before: Conjugate, gamma: f32, delta: f32) -> ConjugateStep {
    let first = before.gamma == 0.0;
    let beta = select(gamma / before.gamma, 0.0, first);
    let curvature = select(delta - beta * gamma / before.alpha, delta, first);
    let alpha = gamma / curvature;
    return ConjugateStep(alpha, beta, curvature > 0.0 && alpha <= LARGEST);
}

/// The largest finite number.
const LARGEST: f32 = 3.4028235e38;
