// The membrane of a woven or knitted fabric: orthotropic St. Venant–Kirchhoff on triangles of constant strain.
//
// With F = [x₁−x₀ x₂−x₀] Dm⁻¹, whose columns are the warp and weft of the rest shape as they are now, and Green's strain
// E = ½(FᵀF − I), the energy of a triangle of area A is A/2 (C₁₁E₁₁² + C₂₂E₂₂² + 2 C₁₂E₁₁E₂₂ + G γ²), γ = 2 E₁₂ [J]: Volino,
// Magnenat-Thalmann, Faure, "A simple approach to nonlinear tensile stiffness for accurate cloth simulation", 2009. Damping is the
// same form of the rates of strain, times a time [s].
//
// Below a principal stretch of LEAST_STRETCH, C = FᵀF is continued by a straight line in the stretch, so that the energy of a
// compression is convex.

#import gpu/wgsl/vector.wgsl

/// Principal stretch below which strain falls by a straight line.
const LEAST_STRETCH: f32 = 0.8;
/// What a squared stretch has more under the root: a triangle without width gives way smoothly.
const FLAT_STRETCH: f32 = 1e-6;
/// Squared stretch at which the square and the line meet, with one slope; what the line is lower by.
const LEAST_SQUARED: f32 = 0.639999;
const LINE_OFFSET: f32 = 0.640001;
/// How many times stiffer a fabric is past its strain limit: 1 and a power of two, which no compiler can round otherwise.
const LIMITED: f32 = 9.0;

/// Dm⁻¹ row by row [1/m]; C₁₁, C₁₂, C₂₂, G times the area [N·m]; damping time [s]; the Green strain of the limit.
struct Sheet {
    inverse: vec4f,
    stiffness: vec4f,
    damping: f32,
    limit: f32,
}

/// F, or what pulls on its columns.
struct Columns {
    warp: vec3f,
    weft: vec3f,
}

/// One vector for each corner.
struct Three {
    a: vec3f,
    b: vec3f,
    c: vec3f,
}

/// E₁₁, E₂₂, γ; whether strain is other than Green's, and then cos 2φ and sin 2φ of the larger principal stretch's direction,
/// and the slopes of both and between them.
struct Strain {
    strain: vec3f,
    is_turned: bool,
    direction: vec2f,
    slopes: vec3f,
}

fn columns_of(u: vec3f, v: vec3f, inverse: vec4f) -> Columns {
    return Columns(u * inverse.x + v * inverse.z, u * inverse.y + v * inverse.w);
}

fn on_corners(pull: Columns, inverse: vec4f) -> Three {
    let first = pull.warp * inverse.x + pull.weft * inverse.y;
    let second = pull.warp * inverse.z + pull.weft * inverse.w;
    return Three(-(first + second), first, second);
}

/// How a squared stretch counts, and the slope of that.
fn continued(squared: f32) -> vec2f {
    if squared >= LEAST_SQUARED {
        return vec2f(squared, 1.0);
    }
    let stretch = sqrt(squared + FLAT_STRETCH);
    return vec2f((stretch + stretch) * LEAST_STRETCH - LINE_OFFSET, LEAST_STRETCH / stretch);
}

fn strain_of(f: Columns) -> Strain {
    let c11 = dot3(f.warp, f.warp);
    let c22 = dot3(f.weft, f.weft);
    let c12 = dot3(f.warp, f.weft);
    let mean = 0.5 * (c11 + c22);
    let apart = 0.5 * (c11 - c22);
    let radius = sqrt(apart * apart + c12 * c12);
    if mean - radius >= LEAST_SQUARED {
        return Strain(vec3f(0.5 * (c11 - 1.0), 0.5 * (c22 - 1.0), c12), false, vec2f(0.0), vec3f(0.0));
    }
    let high = continued(mean + radius);
    let low = continued(mean - radius);
    let between = 0.5 * (high.x - low.x);
    var direction = vec2f(1.0, 0.0);
    var slope = low.y;
    if radius > EPSILON * mean {
        direction = vec2f(apart / radius, c12 / radius);
        slope = between / radius;
    }
    let middle = 0.5 * (high.x + low.x);
    let turned = between * direction;
    let strain = vec3f(0.5 * (middle + turned.x - 1.0), 0.5 * (middle - turned.x - 1.0), turned.y);
    return Strain(strain, true, direction, vec3f(high.y, low.y, slope));
}

/// A symmetric tensor (11, 22, 12) by the strain as one by Green's strain.
fn pulled_back(strain: Strain, t: vec3f) -> vec3f {
    if !strain.is_turned {
        return t;
    }
    let cosine = strain.direction.x;
    let sine = strain.direction.y;
    let mean = 0.5 * (t.x + t.y);
    let apart = 0.5 * (t.x - t.y);
    let along = apart * cosine + t.z * sine;
    let major = strain.slopes.x * (mean + along);
    let minor = strain.slopes.y * (mean - along);
    let across = strain.slopes.z * (t.z * cosine - apart * sine);
    let middle = 0.5 * (major + minor);
    let half = 0.5 * (major - minor);
    let turned = half * cosine - across * sine;
    return vec3f(middle + turned, middle - turned, half * sine + across * cosine);
}

/// Strain past the limit.
fn past(strain: f32, limit: f32) -> f32 {
    return select(0.0, strain - limit, strain > limit);
}

/// Stress times area [N·m] of a strain.
fn stress_of(sheet: Sheet, e: vec3f) -> vec3f {
    let c = sheet.stiffness;
    return vec3f(
        c.x * e.x + c.y * e.y + (LIMITED - 1.0) * c.x * past(e.x, sheet.limit),
        c.y * e.x + c.z * e.y + (LIMITED - 1.0) * c.z * past(e.y, sheet.limit),
        c.w * e.z,
    );
}

/// Energy [J] of a strain.
fn membrane_energy(sheet: Sheet, e: vec3f) -> f32 {
    let c = sheet.stiffness;
    let first = past(e.x, sheet.limit);
    let second = past(e.y, sheet.limit);
    return 0.5 * (c.x * e.x * e.x + c.z * e.y * e.y + (c.y + c.y) * e.x * e.y + c.w * e.z * e.z
        + (LIMITED - 1.0) * (c.x * first * first + c.z * second * second));
}

/// F times a symmetric tensor.
fn columns_times(f: Columns, t: vec3f) -> Columns {
    return Columns(f.warp * t.x + f.weft * t.z, f.warp * t.z + f.weft * t.y);
}

/// Forces [N] on the corners of a triangle whose edges from the first corner are `f` and move with `rates`.
fn membrane_forces(sheet: Sheet, f: Columns, rates: Columns) -> Three {
    let strain = strain_of(f);
    let e = vec3f(
        dot3(f.warp, rates.warp),
        dot3(f.weft, rates.weft),
        dot3(f.warp, rates.weft) + dot3(f.weft, rates.warp),
    );
    let c = sheet.stiffness;
    let viscous = sheet.damping * vec3f(c.x * e.x + c.y * e.y, c.y * e.x + c.z * e.y, c.w * e.z);
    let stress = pulled_back(strain, stress_of(sheet, strain.strain)) + viscous;
    let pull = on_corners(columns_times(f, stress), sheet.inverse);
    return Three(-pull.a, -pull.b, -pull.c);
}

/// Principal directions of a stress: cosine and sine of the larger one's, then the stress along each where it pulls, else 0.
fn pulling(s: vec3f) -> vec4f {
    let mean = 0.5 * (s.x + s.y);
    let apart = 0.5 * (s.x - s.y);
    let radius = sqrt(apart * apart + s.z * s.z);
    // From the double angle, by the half that does not cancel.
    let long = abs(apart) + radius;
    let size = sqrt(long * long + s.z * s.z);
    var found = vec2f(1.0, 0.0);
    if size > 0.0 {
        found = vec2f(long / size, s.z / size);
    }
    if apart < 0.0 {
        found = found.yx;
    }
    let major = mean + radius;
    let minor = mean - radius;
    return vec4f(found, select(0.0, major, major > 0.0), select(0.0, minor, minor > 0.0));
}
