//! The volume inside a closed surface, kept by one Lagrange multiplier a body.
//!
//! Source: Va, Choi, Hong, "Real-Time Surface-Based Volume Constraints on Mass-Spring Model in Unity3D", 2023, eqs. 9–15
//! and algorithm 2; local weights after Hong, Jung, Choi, Welch, "Fast Volume Preservation for a Mass-Spring System",
//! 2006. What was mended, and why: docs/models/volume.md.
//!
//! With places r = x − o [m] from a node o of the body, and over the ring of a node's triangles (a, b, c):
//! g = ∂V/∂a = Σ (b − a)×(c − a)/6 [m²], V = Σ r·g/3 [m³].
//! With v* = v + h (w f + g₀), the velocity [m/s] without the constraint, Φ = V − V₀ and D = Σ w |g|²:
//! λ = (Φ/h² + Σ g·v*/h)/D [Pa], and the force of the constraint is −λ g [N].
//!
//! With weights W the force is −λ u, u = W g − m (A + Ω × (x − c)): the rigid motion of the whole body by which W g would
//! change its momenta is taken away, with A = Σ W g/M, Ω = I⁻¹ Σ (x − c) × W g; then D = Σ w g·u.

use crate::real::{Real, add, cross, dot, scale, sub};

/// How the multiplier is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Form {
    /// From the volume to keep, as above.
    Kept,
    /// As above with eq. 10 for the gradient, which is −3 g, and Φ for Φ/h² in eq. 14.
    PaperShader,
    /// As above with eq. 10 for the gradient.
    Printed,
    /// A pressure p [Pa]: λ = −p.
    Pressure,
}

/// A node as the sums over its body need it.
#[derive(Clone, Copy, Debug)]
pub struct Node<T> {
    /// Place from the body's reference node [m].
    pub place: [T; 3],
    /// Gradient of the volume by its place [m²].
    pub gradient: [T; 3],
    /// Velocity without the constraint [m/s].
    pub velocity: [T; 3],
    /// Inverse mass [1/kg]; 0: held.
    pub inverse_mass: T,
}

/// What all nodes of a body add up: 3 V [m³], Σ g·v* [m³/s], D [m⁴/kg].
pub const SUMS: usize = 3;
/// With weights in addition: M, Σ m r (3), Σ m r rᵀ (xx, yy, zz, xy, xz, yz), Σ W g (3), Σ r × W g (3), and over free
/// nodes Σ g (3), Σ r × g (3).
pub const WEIGHTED_SUMS: usize = SUMS + 22;

/// What a node adds to the sums.
#[inline(always)]
pub fn terms<T: Real>(node: &Node<T>) -> [T; SUMS] {
    let Node { place, gradient, velocity, inverse_mass } = *node;
    [dot(place, gradient), dot(gradient, velocity), inverse_mass * dot(gradient, gradient)]
}

/// What a node with weight `weight` and mass `mass` [kg] adds.
#[inline(always)]
pub fn weighted_terms<T: Real>(node: &Node<T>, weight: T, mass: T) -> [T; WEIGHTED_SUMS] {
    let ([volume, flux, response], r) = (terms(node), node.place);
    let push = scale(node.gradient, weight);
    let free = if node.inverse_mass > T::ZERO { node.gradient } else { [T::ZERO; 3] };
    let (m, turn, free_turn) = (scale(r, mass), cross(r, push), cross(r, free));
    [
        volume,
        flux,
        weight * response,
        mass,
        m[0],
        m[1],
        m[2],
        m[0] * r[0],
        m[1] * r[1],
        m[2] * r[2],
        m[0] * r[1],
        m[0] * r[2],
        m[1] * r[2],
        push[0],
        push[1],
        push[2],
        turn[0],
        turn[1],
        turn[2],
        free[0],
        free[1],
        free[2],
        free_turn[0],
        free_turn[1],
        free_turn[2],
    ]
}

/// The force that keeps a body's volume, or the way that restores it: −λ u.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Push<T> {
    /// λ [Pa], or [kg/m²·s²] where positions are moved.
    pub lambda: T,
    /// A [m²/kg].
    pub shift: [T; 3],
    /// Ω [m/kg].
    pub spin: [T; 3],
    /// c − o [m].
    pub centre: [T; 3],
}

/// The push of a sub-step of `h` [s] that ends at the volume `goal` [m³], or acts with the pressure `goal` [Pa].
pub fn push<T: Real>(form: Form, sums: &[T], goal: T, h: T) -> Push<T> {
    let three = T::from_f64(3.0);
    let off = sums[0] / three - goal;
    let flux = sums[1] / h;
    let mut push = rigid(sums);
    let response = response(sums, &push);
    push.lambda = match form {
        Form::Kept => share(off / (h * h) + flux, response),
        Form::PaperShader => share(flux - off / three, response),
        Form::Printed => share(flux - off / (three * h * h), response),
        Form::Pressure => -goal,
    };
    push
}

/// The push that moves nodes so that the volume is `goal` [m³]; `None` where it is already, to `tolerance`. In place of
/// Σ g·v* the sums have D of all nodes, also of those that must not move. Where these are nearly all, the few others
/// would be thrown across the scene; so they give back a part, and the rest stays as an error.
pub fn projection<T: Real>(sums: &[T], goal: T, tolerance: T) -> Option<Push<T>> {
    let off = sums[0] / T::from_f64(3.0) - goal;
    if off.abs() <= tolerance * goal {
        return None;
    }
    let mut push = rigid(sums);
    let (response, least) = (response(sums, &push), T::from_f64(FEW) * sums[1]);
    push.lambda = share(off, if response > least { response } else { least });
    Some(push)
}

/// Share of a body's response below which the nodes that may move are few.
const FEW: f64 = 0.0625;

/// A quotient; 0 where nothing can move.
fn share<T: Real>(wanted: T, response: T) -> T {
    if response > T::TINY { wanted / response } else { T::ZERO }
}

/// −u of a node: what λ is multiplied by.
#[inline(always)]
pub fn direction<T: Real>(push: &Push<T>, node: (&[T; 3], &[T; 3]), weight: T, mass: T) -> [T; 3] {
    let (place, gradient) = node;
    let turned = cross(push.spin, sub(*place, push.centre));
    sub(scale(add(push.shift, turned), mass), scale(*gradient, weight))
}

/// The rigid motion that weights would cause; without weights none.
fn rigid<T: Real>(sums: &[T]) -> Push<T> {
    let mut push = Push::default();
    let &[_, _, _, mass, mx, my, mz, xx, yy, zz, xy, xz, yz, px, py, pz, tx, ty, tz, ..] = sums else {
        return push;
    };
    if mass <= T::ZERO {
        return push;
    }
    let (force, c) = ([px, py, pz], [mx / mass, my / mass, mz / mass]);
    push.centre = c;
    push.shift = [px / mass, py / mass, pz / mass];
    let torque = sub([tx, ty, tz], cross(c, force));
    let [xx, yy, zz] = [xx - mx * c[0], yy - my * c[1], zz - mz * c[2]];
    let [xy, xz, yz] = [xy - mx * c[1], xz - mx * c[2], yz - my * c[2]];
    push.spin = solve([yy + zz, xx + zz, xx + yy], [-xy, -xz, -yz], torque);
    push
}

/// D: with weights, what is left of it once the rigid motion is taken away.
fn response<T: Real>(sums: &[T], push: &Push<T>) -> T {
    let &[_, _, plain, .., _, _, gx, gy, gz, tx, ty, tz] = sums else { return sums[2] };
    let (free, turn) = ([gx, gy, gz], [tx, ty, tz]);
    let turn = sub(turn, cross(push.centre, free));
    plain - (dot(free, push.shift) + dot(turn, push.spin))
}

/// x of A x = b with A symmetric, by cofactors: `d` its diagonal, `o` = (A₁₂, A₁₃, A₂₃); 0 where A has no inverse.
fn solve<T: Real>(d: [T; 3], o: [T; 3], b: [T; 3]) -> [T; 3] {
    let trace = d[0] + d[1] + d[2];
    if trace <= T::ZERO {
        return [T::ZERO; 3];
    }
    // Of size 1, so that a small determinant tells a flat matrix and not small units.
    let [d, o, b] = [d, o, b].map(|v| [v[0] / trace, v[1] / trace, v[2] / trace]);
    let c = [d[1] * d[2] - o[2] * o[2], o[1] * o[2] - o[0] * d[2], o[0] * o[2] - d[1] * o[1]];
    let determinant = d[0] * c[0] + o[0] * c[1] + o[1] * c[2];
    if determinant <= T::from_f64(FLAT) {
        return [T::ZERO; 3];
    }
    let [e, f, g] = [d[0] * d[2] - o[1] * o[1], o[0] * o[1] - d[0] * o[2], d[0] * d[1] - o[0] * o[0]];
    let x = [dot(c, b), dot([c[1], e, f], b), dot([c[2], f, g], b)];
    [x[0] / determinant, x[1] / determinant, x[2] / determinant]
}

/// Determinant below which a tensor of inertia, divided by its trace, is that of a line.
const FLAT: f64 = 1e-7;

/// Weight of a node at a `distance` [m] from the centre of a ball of `radius` [m]: eq. 15 with the missing π, cut off at
/// the radius.
pub fn weight(distance: f64, radius: f64) -> f64 {
    if distance < radius { 0.5 * (libm::cos(std::f64::consts::PI * distance / radius) + 1.0) } else { 0.0 }
}
