// The volume inside a closed surface, kept by one Lagrange multiplier a body.
//
// Source: Va, Choi, Hong, "Real-Time Surface-Based Volume Constraints on Mass-Spring Model in Unity3D", 2023, eqs. 9–15
// and algorithm 2; local weights after Hong, Jung, Choi, Welch, "Fast Volume Preservation for a Mass-Spring System",
// 2006. What was mended, and why: docs/models/volume.md.
//
// With places r = x − o [m] from a node o of the body, and over the ring of a node's triangles (a, b, c):
// g = ∂V/∂a = Σ (b − a)×(c − a)/6 [m²], V = Σ r·g/3 [m³].
// With v* = v + h (w f + g₀), the velocity [m/s] without the constraint, Φ = V − V₀ and D = Σ w |g|²:
// λ = (Φ/h² + Σ g·v*/h)/D [Pa], and the force of the constraint is −λ g [N].
//
// With weights W the force is −λ u, u = W g − m (A + Ω × (x − c)): the rigid motion of the whole body by which W g would
// change its momenta is taken away, with A = Σ W g/M, Ω = I⁻¹ Σ (x − c) × W g; then D = Σ w g·u.

/// How the multiplier is found: from the volume to keep; as the paper's programs do; as the paper prints; a pressure.
const KEPT: u32 = 0u;
const PAPER_SHADER: u32 = 1u;
const PRINTED: u32 = 2u;
const PRESSURE: u32 = 3u;

/// Numbers that all nodes of a body add up: 3 V [m³], Σ g·v* [m³/s], D [m⁴/kg]; with weights in addition M, Σ m r (3),
/// Σ m r rᵀ (xx, yy, zz, xy, xz, yz), Σ W g (3), Σ r × W g (3), and over free nodes Σ g (3), Σ r × g (3).
const VOLUME_SUMS: u32 = 25u;
/// Determinant below which a tensor of inertia, divided by its trace, is that of a line.
const FLAT: f32 = 1e-7;
/// Share of a body's response below which the nodes that may move are few.
const FEW: f32 = 0.0625;

/// A node as the sums over its body need it.
struct VolumeNode {
    /// Place from the body's reference node [m].
    place: vec3f,
    /// Inverse mass [1/kg]; 0: held.
    inverse_mass: f32,
    /// Gradient of the volume by its place [m²].
    gradient: vec3f,
    /// Mass [kg].
    mass: f32,
    /// Velocity without the constraint [m/s].
    velocity: vec3f,
    weight: f32,
}

/// The force that keeps a body's volume, or the way that restores it: −λ u.
struct Push {
    /// A [m²/kg].
    shift: vec3f,
    /// λ [Pa], or [kg/m²·s²] where positions are moved.
    lambda: f32,
    /// Ω [m/kg].
    spin: vec3f,
    /// c − o [m].
    centre: vec3f,
}

/// What a node adds to the sums.
fn volume_terms(node: VolumeNode) -> vec3f {
    let g = node.gradient;
    return vec3f(dot3(node.place, g), dot3(g, node.velocity), node.inverse_mass * dot3(g, g));
}

/// What a node with a weight adds.
fn weighted_terms(node: VolumeNode) -> array<f32, VOLUME_SUMS> {
    let plain = volume_terms(node);
    let r = node.place;
    let p = node.gradient * node.weight;
    let g = select(vec3f(0.0), node.gradient, node.inverse_mass > 0.0);
    let m = r * node.mass;
    let t = cross3(r, p);
    let s = cross3(r, g);
    return array<f32, VOLUME_SUMS>(
        plain.x, plain.y, node.weight * plain.z, node.mass, m.x, m.y, m.z,
        m.x * r.x, m.y * r.y, m.z * r.z, m.x * r.y, m.x * r.z, m.y * r.z,
        p.x, p.y, p.z, t.x, t.y, t.z, g.x, g.y, g.z, s.x, s.y, s.z,
    );
}

/// A quotient; 0 where nothing can move.
fn volume_share(wanted: f32, response: f32) -> f32 {
    let some = response > TINY;
    return select(0.0, wanted / select(1.0, response, some), some);
}

/// x of A x = b with A symmetric, by cofactors: `diagonal`, and `other` = (A₁₂, A₁₃, A₂₃); 0 where A has no inverse.
fn solve_symmetric(diagonal: vec3f, other: vec3f, right: vec3f) -> vec3f {
    let trace = diagonal.x + diagonal.y + diagonal.z;
    if trace <= 0.0 {
        return vec3f(0.0);
    }
    // Of size 1, so that a small determinant tells a flat matrix and not small units.
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

/// The rigid motion that weights would cause.
fn rigid_push(sums: array<f32, VOLUME_SUMS>) -> Push {
    let mass = sums[3];
    if mass <= 0.0 {
        return Push(vec3f(0.0), 0.0, vec3f(0.0), vec3f(0.0));
    }
    let m = vec3f(sums[4], sums[5], sums[6]);
    let c = m / mass;
    let force = vec3f(sums[13], sums[14], sums[15]);
    let torque = vec3f(sums[16], sums[17], sums[18]) - cross3(c, force);
    let xx = sums[7] - m.x * c.x;
    let yy = sums[8] - m.y * c.y;
    let zz = sums[9] - m.z * c.z;
    let other = vec3f(sums[10] - m.x * c.y, sums[11] - m.x * c.z, sums[12] - m.y * c.z);
    let spin = solve_symmetric(vec3f(yy + zz, xx + zz, xx + yy), -other, torque);
    return Push(force / mass, 0.0, spin, c);
}

/// D of weighted nodes: what is left of it once the rigid motion is taken away.
fn weighted_response(sums: array<f32, VOLUME_SUMS>, push: Push) -> f32 {
    let free = vec3f(sums[19], sums[20], sums[21]);
    let turn = vec3f(sums[22], sums[23], sums[24]) - cross3(push.centre, free);
    return sums[2] - (dot3(free, push.shift) + dot3(turn, push.spin));
}

/// λ of a sub-step of `h` [s] that ends at the volume `goal` [m³], or acts with the pressure `goal` [Pa]; `sums` are 3 V,
/// Σ g·v* and D.
fn multiplier(form: u32, sums: vec3f, goal: f32, h: f32) -> f32 {
    let off = sums.x / 3.0 - goal;
    let flux = sums.y / h;
    switch form {
        case PAPER_SHADER: {
            return volume_share(flux - off / 3.0, sums.z);
        }
        case PRINTED: {
            return volume_share(flux - off / (3.0 * h * h), sums.z);
        }
        case PRESSURE: {
            return -goal;
        }
        default: {
            return volume_share(off / (h * h) + flux, sums.z);
        }
    }
}

/// λ by which nodes are moved so that the volume is `goal` [m³]; 0 where it is already, to `tolerance`. In place of
/// Σ g·v* the sums have D of all nodes, also of those that must not move. Where these are nearly all, the few others
/// would be thrown across the scene; so they give back a part, and the rest stays as an error.
fn projection(sums: vec3f, goal: f32, tolerance: f32) -> f32 {
    let off = sums.x / 3.0 - goal;
    if abs(off) <= tolerance * goal {
        return 0.0;
    }
    let least = FEW * sums.y;
    return volume_share(off, select(least, sums.z, sums.z > least));
}

/// −u of a node: what λ is multiplied by.
fn push_direction(push: Push, place: vec3f, gradient: vec3f, weight: f32, mass: f32) -> vec3f {
    let turned = cross3(push.spin, place - push.centre);
    return (push.shift + turned) * mass - gradient * weight;
}
