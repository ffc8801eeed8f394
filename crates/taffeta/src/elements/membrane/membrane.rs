//! The membrane of a woven or knitted fabric: orthotropic St. Venant–Kirchhoff on triangles of constant strain.
//!
//! With F = [x₁−x₀ x₂−x₀] Dm⁻¹, whose columns are the warp and weft of the rest shape as they are now, and Green's strain
//! E = ½(FᵀF − I), the energy of a triangle of area A is A/2 (C₁₁E₁₁² + C₂₂E₂₂² + 2 C₁₂E₁₁E₂₂ + G γ²), γ = 2 E₁₂ [J]: Volino,
//! Magnenat-Thalmann, Faure, "A simple approach to nonlinear tensile stiffness for accurate cloth simulation", 2009. Damping is the
//! same form of the rates of strain, times a time [s].
//!
//! St. Venant–Kirchhoff softens under compression and gives way below a stretch of 0.577. Here the right Cauchy–Green tensor
//! C = FᵀF is continued below a principal stretch of [`LEAST_STRETCH`] by a straight line in the stretch, in place of its square.
//! Strain is then a straight line there, too, and the energy of a compression is convex.

use crate::elements::element::{Element, MODES, Mode, TENSIONS};
use crate::real::{Real, add, dot, scale, sub};

/// Principal stretch below which strain falls by a straight line.
pub const LEAST_STRETCH: f64 = 0.8;

/// What a squared stretch has more under the root: a triangle without width gives way smoothly.
pub const FLAT: f64 = 1e-6;

/// Squared stretch at which the square and the line meet, with one slope.
pub const LEAST_SQUARED: f64 = LEAST_STRETCH * LEAST_STRETCH - FLAT;

/// How many times stiffer a fabric is past its strain limit: 1 and a power of two, which no compiler can round otherwise.
pub const LIMITED: f64 = 9.0;

/// The Green strain of a fabric without a limit.
pub const NO_LIMIT: f64 = 1e30;

/// The formula. Its numbers are Dm⁻¹ [1/m] row by row, C₁₁, C₁₂, C₂₂ and G times the area [N·m], the damping time [s], and the
/// Green strain past which warp and weft are [`LIMITED`] times as stiff.
pub struct Membrane;

/// The numbers of an element by name.
#[derive(Clone, Copy, Debug)]
struct Sheet<T> {
    /// Dm⁻¹ row by row [1/m].
    inverse: [T; 4],
    /// C₁₁, C₁₂, C₂₂, G times the area [N·m].
    stiffness: [T; 4],
    /// [s]
    damping: T,
    /// Green strain.
    limit: T,
}

/// A symmetric tensor in the frame of warp and weft: 11, 22, 12.
type Tensor<T> = [T; 3];

/// Edge vectors from the first corner to columns of F, or of its rate.
#[inline(always)]
pub fn columns<T: Real>(x: [[T; 3]; 3], [a, b, c, d]: [T; 4]) -> [[T; 3]; 2] {
    let (u, v) = (sub(x[1], x[0]), sub(x[2], x[0]));
    [add(scale(u, a), scale(v, c)), add(scale(u, b), scale(v, d))]
}

/// Forces on the corners from what pulls on the columns.
#[inline(always)]
fn on_corners<T: Real>([warp, weft]: [[T; 3]; 2], [a, b, c, d]: [T; 4]) -> [[T; 3]; 3] {
    let first = add(scale(warp, a), scale(weft, b));
    let second = add(scale(warp, c), scale(weft, d));
    [scale(add(first, second), -T::ONE), first, second]
}

/// One of two tensors.
#[inline(always)]
fn choose<T: Real>(first: bool, one: Tensor<T>, other: Tensor<T>) -> Tensor<T> {
    [
        if first { one[0] } else { other[0] },
        if first { one[1] } else { other[1] },
        if first { one[2] } else { other[2] },
    ]
}

/// How a squared stretch counts, and the slope of that.
#[inline(always)]
fn continued<T: Real>(squared: T) -> [T; 2] {
    let (least, stretch) = (T::from_f64(LEAST_STRETCH), (squared + T::from_f64(FLAT)).sqrt());
    let line = [(stretch + stretch) * least - T::from_f64(LEAST_SQUARED + FLAT + FLAT), least / stretch];
    let is_green = squared >= T::from_f64(LEAST_SQUARED);
    [if is_green { squared } else { line[0] }, if is_green { T::ONE } else { line[1] }]
}

/// The strain of a triangle, and how it turns with C = FᵀF.
struct Strain<T> {
    /// E₁₁, E₂₂, γ.
    strain: Tensor<T>,
    /// Whether strain is Green's; else how it turns with C: cos 2φ and sin 2φ of the larger principal stretch's direction, and the
    /// slopes of both and between them.
    is_green: bool,
    direction: [T; 2],
    slopes: [T; 3],
}

impl<T: Real> Strain<T> {
    #[inline(always)]
    fn of([warp, weft]: [[T; 3]; 2]) -> Self {
        let half = T::from_f64(0.5);
        let (c11, c22, c12) = (dot(warp, warp), dot(weft, weft), dot(warp, weft));
        let (mean, apart) = (half * (c11 + c22), half * (c11 - c22));
        let radius = (apart * apart + c12 * c12).sqrt();
        let is_green = mean - radius >= T::from_f64(LEAST_SQUARED);
        let green = [half * (c11 - T::ONE), half * (c22 - T::ONE), c12];
        // Both are computed, and one chosen, so that compilers can do this for many triangles at a time.
        let ([high, at_high], [low, at_low]) = (continued(mean + radius), continued(mean - radius));
        let between = half * (high - low);
        let is_round = radius <= T::EPSILON * mean;
        let divisor = if is_round { T::ONE } else { radius };
        let direction =
            [if is_round { T::ONE } else { apart / divisor }, if is_round { T::ZERO } else { c12 / divisor }];
        let slope = if is_round { at_low } else { between / divisor };
        let mean = half * (high + low);
        let [cos, sin] = [between * direction[0], between * direction[1]];
        let straight = [half * (mean + cos - T::ONE), half * (mean - cos - T::ONE), sin];
        Self {
            strain: choose(is_green, green, straight),
            is_green,
            direction,
            slopes: [at_high, at_low, slope],
        }
    }

    /// A tensor by the strain as one by Green's strain: what `tensor : dE` is of the strain's change.
    #[inline(always)]
    fn pulled_back(&self, [t11, t22, t12]: Tensor<T>) -> Tensor<T> {
        let ([cos, sin], [high, low, between]) = (self.direction, self.slopes);
        let half = T::from_f64(0.5);
        let (mean, apart) = (half * (t11 + t22), half * (t11 - t22));
        let along = apart * cos + t12 * sin;
        let (major, minor) = (high * (mean + along), low * (mean - along));
        let across = between * (t12 * cos - apart * sin);
        let (mean, along) = (half * (major + minor), half * (major - minor));
        let turned = along * cos - across * sin;
        choose(self.is_green, [t11, t22, t12], [mean + turned, mean - turned, along * sin + across * cos])
    }
}

impl<T: Real> Sheet<T> {
    #[inline(always)]
    fn new([a, b, c, d, c11, c12, c22, g, damping, limit]: [T; 10]) -> Self {
        Self { inverse: [a, b, c, d], stiffness: [c11, c12, c22, g], damping, limit }
    }

    /// Strain past the limit.
    #[inline(always)]
    fn past(&self, strain: T) -> T {
        if strain > self.limit { strain - self.limit } else { T::ZERO }
    }

    /// Stress times area [N·m] of a strain.
    #[inline(always)]
    fn stress(&self, [e11, e22, shear]: Tensor<T>) -> Tensor<T> {
        let ([c11, c12, c22, g], more) = (self.stiffness, T::from_f64(LIMITED - 1.0));
        [
            c11 * e11 + c12 * e22 + more * c11 * self.past(e11),
            c12 * e11 + c22 * e22 + more * c22 * self.past(e22),
            g * shear,
        ]
    }

    /// Stress times area [N·m] of a rate of strain.
    #[inline(always)]
    fn viscous(&self, [e11, e22, shear]: Tensor<T>) -> Tensor<T> {
        let [c11, c12, c22, g] = self.stiffness;
        scale([c11 * e11 + c12 * e22, c12 * e11 + c22 * e22, g * shear], self.damping)
    }

    /// Directions on the corners of what resists a strain, per unit of a tensor.
    #[inline(always)]
    fn directions(&self, columns: [[T; 3]; 2], strain: &Strain<T>, tensor: Tensor<T>) -> [[T; 3]; 3] {
        on_corners(times(columns, strain.pulled_back(tensor)), self.inverse)
    }

    /// Weights of the corners for what pulls along a direction.
    #[inline(always)]
    fn weights(&self, [along, across]: [T; 2]) -> [T; 3] {
        let [a, b, c, d] = self.inverse;
        let (first, second) = (along * a + across * b, along * c + across * d);
        [-(first + second), first, second]
    }

    /// Twice the energy [J] of a strain.
    #[inline(always)]
    fn twice_energy(&self, strain: Tensor<T>) -> T {
        let ([c11, c12, c22, g], more) = (self.stiffness, T::from_f64(LIMITED - 1.0));
        let ([e11, e22, shear], [p11, p22]) = (strain, [self.past(strain[0]), self.past(strain[1])]);
        c11 * e11 * e11
            + c22 * e22 * e22
            + (c12 + c12) * e11 * e22
            + g * shear * shear
            + more * (c11 * p11 * p11 + c22 * p22 * p22)
    }
}

/// F times a symmetric tensor.
#[inline(always)]
fn times<T: Real>([warp, weft]: [[T; 3]; 2], [t11, t22, t12]: Tensor<T>) -> [[T; 3]; 2] {
    [add(scale(warp, t11), scale(weft, t12)), add(scale(warp, t12), scale(weft, t22))]
}

impl Element<3, 10> for Membrane {
    #[inline(always)]
    fn forces<T: Real>(x: [[T; 3]; 3], v: [[T; 3]; 3], numbers: [T; 10]) -> [[T; 3]; 3] {
        let sheet = Sheet::new(numbers);
        let [warp, weft] = columns(x, sheet.inverse);
        let [warp_rate, weft_rate] = columns(v, sheet.inverse);
        let strain = Strain::of([warp, weft]);
        let rate = [dot(warp, warp_rate), dot(weft, weft_rate), dot(warp, weft_rate) + dot(weft, warp_rate)];
        let (elastic, viscous) = (strain.pulled_back(sheet.stress(strain.strain)), sheet.viscous(rate));
        let [a, b, c] = on_corners(times([warp, weft], add(elastic, viscous)), sheet.inverse);
        [scale(a, -T::ONE), scale(b, -T::ONE), scale(c, -T::ONE)]
    }

    #[inline(always)]
    fn energy<T: Real>(x: [[T; 3]; 3], numbers: [T; 10]) -> T {
        let sheet = Sheet::new(numbers);
        let strain = Strain::of(columns(x, sheet.inverse));
        T::from_f64(0.5) * sheet.twice_energy(strain.strain)
    }

    /// Those of the material.
    #[inline(always)]
    fn modes<T: Real>(x: [[T; 3]; 3], numbers: [T; 10]) -> [Mode<T, 3>; MODES] {
        let sheet = Sheet::new(numbers);
        let columns = columns(x, sheet.inverse);
        let strain = Strain::of(columns);
        let [c11, c12, c22, g] = sheet.stiffness;
        let limited_by = |strain: T| if strain > sheet.limit { T::from_f64(LIMITED) } else { T::ONE };
        let (zero, one) = (T::ZERO, T::ONE);
        // Past its limit a fabric is that much stiffer, and otherwise as much as at a stretch of 15 %.
        let has_limit = sheet.limit < T::from_f64(NO_LIMIT);
        let stiffest = if has_limit { T::from_f64(LIMITED) } else { T::from_f64(1.5) };
        let limited = limited_by(strain.strain[0]) * c11;
        let (follows, rest) = (c12 / limited, limited_by(strain.strain[1]) * c22 - c12 * c12 / limited);
        let viscous_rest = c22 - c12 * c12 / c11;
        let [along, across, sheared] = [
            sheet.directions(columns, &strain, [one, follows, zero]),
            sheet.directions(columns, &strain, [zero, one, zero]),
            sheet.directions(columns, &strain, [zero, zero, one]),
        ];
        [
            Mode { directions: along, k: limited, d: sheet.damping * c11, stiffest },
            Mode { directions: across, k: rest, d: sheet.damping * viscous_rest, stiffest },
            Mode { directions: sheared, k: g, d: sheet.damping * g, stiffest },
        ]
    }

    /// Along each principal stress that pulls: a string under tension resists across itself. Those of stresses that push are left
    /// out, and what is left is positive semidefinite (Teran, Sifakis, Irving, Fedkiw, "Robust quasistatic finite elements and
    /// flesh simulation", 2005).
    #[inline(always)]
    fn tensions<T: Real>(x: [[T; 3]; 3], numbers: [T; 10]) -> [([T; 3], T); TENSIONS] {
        let sheet = Sheet::new(numbers);
        let strain = Strain::of(columns(x, sheet.inverse));
        let principal = pulling(strain.pulled_back(sheet.stress(strain.strain)));
        principal.map(|(direction, stress)| (sheet.weights(direction), stress))
    }
}

/// Principal directions of a stress, and the stress along them where it pulls, else 0.
#[inline(always)]
fn pulling<T: Real>([s11, s22, s12]: Tensor<T>) -> [([T; 2], T); 2] {
    let half = T::from_f64(0.5);
    let (mean, apart) = (half * (s11 + s22), half * (s11 - s22));
    let radius = (apart * apart + s12 * s12).sqrt();
    // (cos φ, sin φ) from the double angle, by the half that does not cancel.
    let (long, short) = (apart.abs() + radius, s12);
    let size = (long * long + short * short).sqrt();
    let divisor = if size > T::ZERO { size } else { T::ONE };
    let long = if size > T::ZERO { long / divisor } else { T::ONE };
    let short = if size > T::ZERO { short / divisor } else { T::ZERO };
    let is_second = apart < T::ZERO;
    let major = [if is_second { short } else { long }, if is_second { long } else { short }];
    let positive = |stress: T| if stress > T::ZERO { stress } else { T::ZERO };
    [(major, positive(mean + radius)), ([-major[1], major[0]], positive(mean - radius))]
}

#[cfg(test)]
mod tests;
