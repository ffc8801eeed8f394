// The volume inside a closed surface, kept by one Lagrange multiplier a body.
//
// Source: Va, Choi, Hong, "Real-Time Surface-Based Volume Constraints on Mass-Spring Model in Unity3D", 2023, eqs. 9–15
// and algorithm 2; local weights after Hong, Jung, Choi, Welch, "Fast Volume Preservation for a Mass-Spring System",
// 2006. What was corrected, and why: docs/models/volume.md.
//
// With places r = x − o [m] from a node o of the body, and over the ring of a node's triangles (a, b, c):
// g = ∂V/∂a = Σ (b − a)×(c − a)/6 [m²], V = Σ r·g/3 [m³].
// With v* = v + h (w f + g₀), the velocity [m/s] without the constraint, Φ = V − V₀ and D = Σ w |g|²:
// λ = (Φ/h² + Σ g·v*/h)/D [Pa], and the force of the constraint is −λ g [N].
//
// With weights W the force is −λ u, u = W g − m (A + Ω × (x − c)). This subtracts the rigid motion of the whole body
// by which W g would change its momenta, A = Σ W g/M, Ω = I⁻¹ Σ (x − c) × W g. If nodes are pinned, the pins take up
// the momenta, and u = W g. D = Σ w g·u = Σ w W |g|²: the gradients of a free body have neither resultant nor moment.

#import gpu/wgsl/vector.wgsl
#import volume/printed.wgsl

/// How the multiplier is found: from the volume to keep; as the paper's programs do; as the paper prints; a pressure.
const KEPT: u32 = 0u;
const PAPER_SHADER: u32 = 1u;
const PRINTED: u32 = 2u;
const PRESSURE: u32 = 3u;

/// Determinant below which a tensor of inertia, divided by its trace, is that of a line.
const FLAT: f32 = 1e-7;
/// Fraction of a body's response below which the movable nodes are few.
const FEW: f32 = 0.0625;
/// Relative error of a volume that is restored by moving nodes.
const PROJECTED: f32 = 1e-6;

/// The numbers of a node in the sums of its body.
struct VolumeNode {
    /// Position relative to the body's reference node [m].
    place: vec3f,
    /// Inverse mass [1/kg]; 0: held.
    inverse_mass: f32,
    /// Gradient of the volume with respect to its position [m²].
    gradient: vec3f,
    /// Mass [kg].
    mass: f32,
    /// Velocity without the constraint [m/s].
    velocity: vec3f,
    weight: f32,
}

/// The force that keeps a body's volume, or the translation that restores it: −λ u.
struct VolumeCorrection {
    /// A [m²/kg].
    shift: vec3f,
    /// λ [Pa], or [kg/m²·s²] where positions are moved.
    lambda: f32,
    /// Ω [m/kg].
    spin: vec3f,
    /// c − o [m].
    centre: vec3f,
}

/// Sums over all nodes of a body; all but `plain` are for bodies with weights.
struct VolumeSums {
    /// 3 V [m³], Σ g·v* [m³/s], D [m⁴/kg].
    plain: vec3f,
    /// M [kg].
    mass: f32,
    /// Σ m r.
    moment: vec3f,
    /// Σ m r rᵀ: xx, yy, zz.
    diagonal: vec3f,
    /// Pinned nodes.
    held: f32,
    /// xy, xz, yz.
    other: vec3f,
    /// Σ W g.
    weighted_gradient: vec3f,
    /// Σ r × W g.
    turn: vec3f,
}

/// The terms of a node.
fn volume_terms(node: VolumeNode) -> vec3f {
    let g = node.gradient;
    return vec3f(dot3(node.place, g), dot3(g, node.velocity), node.inverse_mass * dot3(g, g));
}

/// The terms of a node with a weight.
fn weighted_terms(node: VolumeNode) -> VolumeSums {
    let plain = volume_terms(node);
    let r = node.place;
    let p = node.gradient * node.weight;
    let held = select(1.0, 0.0, node.inverse_mass > 0.0);
    let m = r * node.mass;
    return VolumeSums(
        vec3f(plain.x, plain.y, node.weight * plain.z), node.mass, m,
        vec3f(m.x * r.x, m.y * r.y, m.z * r.z), held, vec3f(m.x * r.y, m.x * r.z, m.y * r.z),
        p, cross3(r, p),
    );
}

/// a + b × c, one product after the other: some shader compilers do so whatever the parentheses are.
fn add_cross(a: vec3f, b: vec3f, c: vec3f) -> vec3f {
    return vec3f(a.x + b.y * c.z - b.z * c.y, a.y + b.z * c.x - b.x * c.z, a.z + b.x * c.y - b.y * c.x);
}

/// A quotient; 0 if nothing can move.
fn volume_quotient(wanted: f32, response: f32) -> f32 {
    let some = response > TINY;
    return select(0.0, wanted / select(1.0, response, some), some);
}

/// Solves A x = b with A symmetric, by cofactors: `diagonal`, and `other` = (A₁₂, A₁₃, A₂₃). 0 if A is singular.
fn solve_symmetric(diagonal: vec3f, other: vec3f, right: vec3f) -> vec3f {
    let trace = diagonal.x + diagonal.y + diagonal.z;
    if trace <= 0.0 {
        return vec3f(0.0);
    }
    // Scaled to size 1, so that a small determinant means a flat matrix, not small units.
    let d = diagonal / trace;
    let o = other / trace;
    let b = right / trace;
    let c = vec3f(d.y * d.z - o.z * o.z, o.y * o.z - o.x * d.z, o.x * o.z - d.y * o.y);
    let determinant = d.x * c.x + o.x * c.y + o.y * c.z;
    if determinant <= FLAT {
        return vec3f(0.0);
    }
    let e = d.x * d.z - o.y * o.y;
    let f = o.x * o.y - d.x * o.z;
    let g = d.x * d.y - o.x * o.x;
    let x = vec3f(dot3(c, b), dot3(vec3f(c.y, e, f), b), dot3(vec3f(c.z, f, g), b));
    return x / determinant;
}

/// The rigid motion that weights would cause; none if nodes are pinned. λ is 0.
fn rigid_correction(sums: VolumeSums) -> VolumeCorrection {
    if sums.mass <= 0.0 || sums.held > 0.0 {
        return VolumeCorrection(vec3f(0.0), 0.0, vec3f(0.0), vec3f(0.0));
    }
    let m = sums.moment;
    let c = m / sums.mass;
    let torque = add_cross(sums.turn, sums.weighted_gradient, c);
    let xx = sums.diagonal.x - m.x * c.x;
    let yy = sums.diagonal.y - m.y * c.y;
    let zz = sums.diagonal.z - m.z * c.z;
    let other = vec3f(sums.other.x - m.x * c.y, sums.other.y - m.x * c.z, sums.other.z - m.y * c.z);
    let spin = solve_symmetric(vec3f(yy + zz, xx + zz, xx + yy), -other, torque);
    return VolumeCorrection(sums.weighted_gradient / sums.mass, 0.0, spin, c);
}

/// λ of a sub-step of `h` [s] that ends at the volume `goal` [m³], or has the pressure `goal` [Pa]; `sums` are 3 V, Σ
/// g·v* and D.
fn multiplier(form: u32, sums: vec3f, goal: f32, h: f32) -> f32 {
    let off = sums.x / 3.0 - goal;
    let flux = sums.y / h;
    switch form {
        case PAPER_SHADER: {
            return volume_quotient(volume_of_programs(off, flux), sums.z);
        }
        case PRINTED: {
            return volume_quotient(volume_as_printed(off, flux, h), sums.z);
        }
        case PRESSURE: {
            return -goal;
        }
        default: {
            return volume_quotient(off / (h * h) + flux, sums.z);
        }
    }
}

/// Whether a volume is within tolerance; `sums` as above.
fn is_restored(sums: vec3f, goal: f32) -> bool {
    return abs(sums.x / 3.0 - goal) <= PROJECTED * goal;
}

/// λ that moves nodes so that the volume is `goal` [m³]. Instead of Σ g·v*, the sums have D of all nodes, including
/// those that must not move. If these are nearly all nodes, the few others would be thrown across the scene. So they
/// restore a part only, and the rest remains as an error.
fn projection(sums: vec3f, goal: f32) -> f32 {
    let least = FEW * sums.y;
    return volume_quotient(sums.x / 3.0 - goal, select(least, sums.z, sums.z > least));
}

/// −u of a node: the factor of λ.
fn correction_direction(correction: VolumeCorrection, place: vec3f, gradient: vec3f, weight: f32, mass: f32) -> vec3f {
    return add_cross(correction.shift, correction.spin, place - correction.centre) * mass - gradient * weight;
}
