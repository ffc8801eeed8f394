//! Bending by a shape operator of each triangle, from the fold angles at its three edges.
//!
//! S = Σ (θ_e − θ₀_e) P_e, where P_e [1/m] is what a fold at an edge says of the curvature (`curvature.rs`). The energy is
//! A/2 (B₁₁S₁₁² + B₂₂S₂₂² + 2 B₁₂S₁₁S₂₂ + 4 B₆₆S₁₂²) [J] with n and S in the frame of warp and weft: Grinspun, Gingold, Reisman,
//! Zorin, "Computing discrete shape operators on general meshes", 2006, with the orthotropic plate of Timoshenko,
//! Woinowsky-Krieger, "Theory of Plates and Shells", 1959, §85. It is a quadratic form of three angles, M, of which an element keeps the
//! factor L with M = L Lᵀ. A hinge of each edge alone would be 2.2 to 3 times too stiff across the diagonals of a grid.

use crate::elements::element::{Element, MODES, Mode};
use crate::real::{Real, add, cross, dot, scale, sub, wrap};

/// The formula. Its nodes are the corners, then those across from each; where no triangle is, the next corner. Its numbers are the
/// angles at rest [rad]; for each edge the Σ|∇θ|² [rad²/m²] past which it gets no stiffer; L [(N·m)^½] by columns, 11, 21, 31, 22, 32,
/// 33; and the damping time [s].
pub struct ShapeOperator;

/// A fold, and the triangle on its other side. The gradient of its angle is along the normals of both triangles.
#[derive(Clone, Copy)]
struct Fold<T> {
    angle: T,
    /// Squared length of the edge [m²], and one over its length [1/m]: 0 where a triangle has no area.
    squared: T,
    inverse: T,
    /// Normal of the triangle on the other side, over its square [1/m²].
    normal: [T; 3],
    /// The second end's share in where that triangle's height stands on the edge, times the squared length [m²].
    foot: T,
    /// Σ|∇θ|² [rad²/m²].
    steep: T,
    /// What the gradient is multiplied by: less than 1 on triangles that are squashed to slivers, where no step would be stable
    /// otherwise.
    factor: T,
}

/// The triangle of an element: its normal, one over the square of that, and whether it has an area.
#[derive(Clone, Copy)]
struct Own<T> {
    normal: [T; 3],
    inverse: T,
    has_area: bool,
}

impl<T: Real> Own<T> {
    #[inline(always)]
    fn of(normal: [T; 3]) -> Self {
        let squared = dot(normal, normal);
        let has_area = squared > T::TINY;
        Self { normal, inverse: T::ONE / if has_area { squared } else { T::ONE }, has_area }
    }
}

impl<T: Real> Fold<T> {
    /// At an edge, with `far` from its first end to the node on the other side. `feet`: shares of its first and second end in
    /// where the triangle's own height stands, times the squared length [m²].
    #[inline(always)]
    fn of(own: &Own<T>, edge: [T; 3], far: [T; 3], feet: [T; 2], steepest: T) -> Self {
        let normal = cross(far, edge);
        let (squared, area, foot) = (dot(edge, edge), dot(normal, normal), dot(far, edge));
        let has_area = own.has_area & (squared > T::TINY) & (area > T::TINY);
        // Chosen, not branched to, so that compilers can do this for many folds at a time.
        let valid = |size: T| if has_area { size } else { T::ONE };
        let length = valid(squared).sqrt();
        let inverse = T::ONE / length;
        let over_area = T::ONE / valid(area);
        let (sine, cosine) = (-(dot(own.normal, far) * length), dot(own.normal, normal));
        let angle = sine.atan2(cosine);
        let rest = squared - foot;
        let at_ends = (feet[0] * feet[0] + feet[1] * feet[1]) * own.inverse
            + (foot * foot + rest * rest) * over_area
            + T::from_f64(2.0) * (cosine * own.inverse) * ((feet[0] * rest + feet[1] * foot) * over_area);
        let steep = squared * (own.inverse + over_area) + at_ends * (inverse * inverse);
        let steep = if has_area { steep } else { T::ZERO };
        let less = (steepest / if steep > steepest { steep } else { T::ONE }).sqrt();
        Self {
            angle: if has_area { angle } else { T::ZERO },
            squared,
            inverse: if has_area { inverse } else { T::ZERO },
            normal: scale(normal, over_area),
            foot,
            steep,
            factor: if steep > steepest { less } else { T::ONE },
        }
    }

    /// How fast the angle changes, times the edge's length, where its second end and the far node move like this beside the first,
    /// and the triangle itself does not move [m/s].
    #[inline(always)]
    fn rate(&self, second: [T; 3], far: [T; 3]) -> T {
        self.foot * dot(self.normal, second) - self.squared * dot(self.normal, far)
    }

    /// What a number that is divided by the edge's length gives its first and second end and the far node.
    #[inline(always)]
    fn share(&self, number: T) -> [[T; 3]; 3] {
        [(self.squared - self.foot) * number, self.foot * number, -(self.squared * number)]
            .map(|along| scale(self.normal, along))
    }
}

/// The folds at the edges across from each corner.
struct Folds<T> {
    /// Normal of the triangle, over its square [1/m²].
    normal: [T; 3],
    /// Shares of corners in where heights stand, times squared lengths [m²]: less the products of the edges that meet in c, a, b.
    feet: [T; 3],
    a: Fold<T>,
    b: Fold<T>,
    c: Fold<T>,
}

impl<T: Real> Folds<T> {
    #[inline(always)]
    fn of(x: [[T; 3]; 6], steepest: [T; 3]) -> Self {
        let (a, b, c) = (sub(x[2], x[1]), sub(x[0], x[2]), sub(x[1], x[0]));
        let own = Own::of(cross(c, a));
        let [at_c, at_a, at_b] = [-dot(a, b), -dot(b, c), -dot(c, a)];
        Self {
            normal: scale(own.normal, own.inverse),
            feet: [at_c, at_a, at_b],
            a: Fold::of(&own, a, sub(x[3], x[1]), [at_c, at_b], steepest[0]),
            b: Fold::of(&own, b, sub(x[4], x[2]), [at_a, at_c], steepest[1]),
            c: Fold::of(&own, c, sub(x[5], x[0]), [at_b, at_a], steepest[2]),
        }
    }

    /// How fast the angles change [rad/s].
    #[inline(always)]
    fn rates(&self, v: [[T; 3]; 6]) -> [T; 3] {
        let (a, b, c) = (sub(v[2], v[1]), sub(v[0], v[2]), sub(v[1], v[0]));
        let [at_c, at_a, at_b] = self.feet;
        let along = |to: [T; 3]| dot(self.normal, to);
        let (by_c, by_a, by_b) = (at_c * along(c), at_a * along(a), at_b * along(b));
        [
            self.a.inverse * (by_c - by_b + self.a.rate(a, sub(v[3], v[1]))),
            self.b.inverse * (by_a - by_c + self.b.rate(b, sub(v[4], v[2]))),
            self.c.inverse * (by_b - by_a + self.c.rate(c, sub(v[5], v[0]))),
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
        let (x, y, z) = (self.a.inverse * x, self.b.inverse * y, self.c.inverse * z);
        let [at_c, at_a, at_b] = self.feet;
        // Between corners: from a to b, from b to c, from c to a.
        let (ab, bc, ca) = (at_c * (y - x), at_a * (z - y), at_b * (x - z));
        let own = [ab - ca, bc - ab, ca - bc].map(|along| scale(self.normal, along));
        let ([a_b, a_c, d], [b_c, b_a, e], [c_a, c_b, f]) =
            (self.a.share(x), self.b.share(y), self.c.share(z));
        [add(own[0], add(b_a, c_a)), add(own[1], add(c_b, a_b)), add(own[2], add(a_c, b_c)), d, e, f]
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
    fn modes<T: Real>(x: [[T; 3]; 6], numbers: [T; 13]) -> [Mode<T, 6>; MODES] {
        let plate = Plate::new(numbers);
        let folds = Folds::of(x, plate.steepest);
        let ([d, e, f], zero) = (plate.others, T::ZERO);
        [
            folds.mode(&plate, plate.first),
            folds.mode(&plate, [zero, d, e]),
            folds.mode(&plate, [zero, zero, f]),
        ]
    }
}

#[cfg(test)]
mod tests;
