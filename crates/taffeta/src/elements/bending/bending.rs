//! Bending by a shape operator of each triangle, from the fold angles at its three edges.
//!
//! S = Σ (θ_e − θ₀_e) P_e, where P_e [1/m] is what a fold at an edge says of the curvature (`curvature.rs`). The energy is
//! A/2 (B₁₁S₁₁² + B₂₂S₂₂² + 2 B₁₂S₁₁S₂₂ + 4 B₆₆S₁₂²) [J] with n and S in the frame of warp and weft: Grinspun, Gingold, Reisman,
//! Zorin, "Computing discrete shape operators on general meshes", 2006, with the orthotropic plate of Timoshenko,
//! Woinowsky-Krieger, "Theory of Plates and Shells", 1959, §85. It is a quadratic form of three angles, M, of which an element keeps the
//! factor L with M = L Lᵀ. A hinge of each edge alone would be 2.2 to 3 times too stiff across the diagonals of a grid.

use crate::elements::element::{Element, Mode};
use crate::elements::hinge::hinge::{angle_and_gradient, steepness, wrap};
use crate::real::{Real, add, dot, scale};

/// The formula. Its nodes are the corners, then those across from each; where no triangle is, the next corner. Its numbers are the
/// angles at rest [rad]; for each edge the Σ|∇θ|² [rad²/m²] past which it gets no stiffer; L [(N·m)^½] by columns, 11, 21, 31, 22, 32,
/// 33; and the damping time [s].
pub struct ShapeOperator;

/// A fold: its angle, and the gradient of that at both ends of the edge and at the nodes at either side.
#[derive(Clone, Copy)]
struct Fold<T> {
    angle: T,
    gradient: [[T; 3]; 4],
    /// Σ|∇θ|² [rad²/m²].
    steep: T,
    /// What the gradient is multiplied by: less than 1 on triangles that are squashed to slivers, where no step would be stable
    /// otherwise.
    factor: T,
}

impl<T: Real> Fold<T> {
    #[inline(always)]
    fn of(a: [T; 3], b: [T; 3], c: [T; 3], d: [T; 3], steepest: T) -> Self {
        let (angle, gradient) = angle_and_gradient([a, b, c, d]);
        let steep = steepness(&gradient);
        let less = (steepest / if steep > steepest { steep } else { T::ONE }).sqrt();
        Self { angle, gradient, steep, factor: if steep > steepest { less } else { T::ONE } }
    }

    /// How fast the angle changes [rad/s].
    #[inline(always)]
    fn rate(&self, a: [T; 3], b: [T; 3], c: [T; 3], d: [T; 3]) -> T {
        let [at_a, at_b, at_c, at_d] = self.gradient;
        dot(at_a, a) + dot(at_b, b) + dot(at_c, c) + dot(at_d, d)
    }
}

/// The folds at the edges across from each corner.
struct Folds<T> {
    a: Fold<T>,
    b: Fold<T>,
    c: Fold<T>,
}

impl<T: Real> Folds<T> {
    #[inline(always)]
    fn of(x: [[T; 3]; 6], steepest: [T; 3]) -> Self {
        Self {
            a: Fold::of(x[1], x[2], x[0], x[3], steepest[0]),
            b: Fold::of(x[2], x[0], x[1], x[4], steepest[1]),
            c: Fold::of(x[0], x[1], x[2], x[5], steepest[2]),
        }
    }

    /// How fast the angles change [rad/s].
    #[inline(always)]
    fn rates(&self, v: [[T; 3]; 6]) -> [T; 3] {
        [
            self.a.rate(v[1], v[2], v[0], v[3]),
            self.b.rate(v[2], v[0], v[1], v[4]),
            self.c.rate(v[0], v[1], v[2], v[5]),
        ]
    }

    /// Angles beyond those at rest.
    #[inline(always)]
    fn beyond(&self, rest: [T; 3]) -> [T; 3] {
        [wrap(self.a.angle - rest[0]), wrap(self.b.angle - rest[1]), wrap(self.c.angle - rest[2])]
    }

    /// Three numbers, each times what its edge's gradient is multiplied by.
    #[inline(always)]
    fn limited(&self, [x, y, z]: [T; 3]) -> [T; 3] {
        [self.a.factor * x, self.b.factor * y, self.c.factor * z]
    }

    /// Sum of the edges' gradients, each times a number.
    #[inline(always)]
    fn sum(&self, [x, y, z]: [T; 3]) -> [[T; 3]; 6] {
        let (a, b, c) = (&self.a.gradient, &self.b.gradient, &self.c.gradient);
        [
            add(add(scale(a[2], x), scale(b[1], y)), scale(c[0], z)),
            add(add(scale(a[0], x), scale(b[2], y)), scale(c[1], z)),
            add(add(scale(a[1], x), scale(b[0], y)), scale(c[2], z)),
            scale(a[3], x),
            scale(b[3], y),
            scale(c[3], z),
        ]
    }

    /// The mode of a column of L.
    #[inline(always)]
    fn mode(&self, plate: &Plate<T>, column: [T; 3]) -> Mode<T, 6> {
        let directions = self.sum(self.limited(column));
        Mode { directions, k: T::ONE, d: plate.damping, stiffest: self.stiffest(plate.steepest) }
    }

    /// How many times stiffer the element may become where its triangles are squashed.
    #[inline(always)]
    fn stiffest(&self, [a, b, c]: [T; 3]) -> T {
        let ratio = |fold: &Fold<T>, steepest: T| {
            let is_steep = fold.steep > T::ZERO;
            let ratio = steepest / if is_steep { fold.steep } else { T::ONE };
            if is_steep { ratio } else { T::ONE }
        };
        T::ONE.max(ratio(&self.a, a)).max(ratio(&self.b, b)).max(ratio(&self.c, c))
    }
}

/// The numbers of an element by name.
struct Plate<T> {
    rest: [T; 3],
    steepest: [T; 3],
    /// L by columns.
    first: [T; 3],
    others: [T; 3],
    damping: T,
}

impl<T: Real> Plate<T> {
    #[inline(always)]
    fn new([r0, r1, r2, s0, s1, s2, l11, l21, l31, l22, l32, l33, damping]: [T; 13]) -> Self {
        Self {
            rest: [r0, r1, r2],
            steepest: [s0, s1, s2],
            first: [l11, l21, l31],
            others: [l22, l32, l33],
            damping,
        }
    }

    /// Lᵀ times three numbers, one for each edge.
    #[inline(always)]
    fn transposed_times(&self, [x, y, z]: [T; 3]) -> [T; 3] {
        let ([a, b, c], [d, e, f]) = (self.first, self.others);
        [a * x + b * y + c * z, d * y + e * z, f * z]
    }

    /// L times three numbers.
    #[inline(always)]
    fn times(&self, [x, y, z]: [T; 3]) -> [T; 3] {
        let ([a, b, c], [d, e, f]) = (self.first, self.others);
        [a * x, b * x + d * y, c * x + e * y + f * z]
    }
}

impl Element<6, 13> for ShapeOperator {
    #[inline(always)]
    fn forces<T: Real>(x: [[T; 3]; 6], v: [[T; 3]; 6], numbers: [T; 13]) -> [[T; 3]; 6] {
        let plate = Plate::new(numbers);
        let folds = Folds::of(x, plate.steepest);
        let strain = folds.limited(add(folds.beyond(plate.rest), scale(folds.rates(v), plate.damping)));
        let moments = folds.limited(plate.times(plate.transposed_times(strain)));
        folds.sum([-moments[0], -moments[1], -moments[2]])
    }

    #[inline(always)]
    fn energy<T: Real>(x: [[T; 3]; 6], numbers: [T; 13]) -> T {
        let plate = Plate::new(numbers);
        let t = plate.transposed_times(Folds::of(x, plate.steepest).beyond(plate.rest));
        T::from_f64(0.5) * dot(t, t)
    }

    /// One for each column of L; what a change of the gradients adds is left out (Gauss–Newton).
    #[inline(always)]
    fn modes<T: Real>(x: [[T; 3]; 6], numbers: [T; 13], mut see: impl FnMut(Mode<T, 6>)) {
        let plate = Plate::new(numbers);
        let folds = Folds::of(x, plate.steepest);
        let ([d, e, f], zero) = (plate.others, T::ZERO);
        see(folds.mode(&plate, plate.first));
        see(folds.mode(&plate, [zero, d, e]));
        see(folds.mode(&plate, [zero, zero, f]));
    }
}

#[cfg(test)]
mod tests;
