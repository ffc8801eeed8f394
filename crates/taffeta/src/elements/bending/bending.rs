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

/// The three edges of an element: both ends, then the nodes at either side.
pub const EDGES: [[usize; 4]; 3] = [[1, 2, 0, 3], [2, 0, 1, 4], [0, 1, 2, 5]];

/// Fold angles, and their gradients by edge and by node of the edge.
struct Folds<T> {
    angles: [T; 3],
    gradients: [[[T; 3]; 4]; 3],
    /// What an edge's gradient is multiplied by: less than 1 on triangles that are squashed to slivers, where no step would be
    /// stable otherwise.
    factors: [T; 3],
}

impl<T: Real> Folds<T> {
    fn of(x: [[T; 3]; 6], steepest: [T; 3]) -> Self {
        let folds = EDGES.map(|nodes| angle_and_gradient(nodes.map(|node| x[node])));
        let factor = |edge: usize| {
            let steep = steepness(&folds[edge].1);
            if steep > steepest[edge] { (steepest[edge] / steep).sqrt() } else { T::ONE }
        };
        Self {
            angles: folds.map(|fold| fold.0),
            gradients: folds.map(|fold| fold.1),
            factors: [0, 1, 2].map(factor),
        }
    }

    /// Lᵀ times three numbers, one for each edge.
    fn transposed([a, b, c, d, e, f]: [T; 6], [x, y, z]: [T; 3]) -> [T; 3] {
        [a * x + b * y + c * z, d * y + e * z, f * z]
    }

    /// Angles beyond those at rest.
    fn beyond(&self, rest: [T; 3]) -> [T; 3] {
        [0, 1, 2].map(|edge| wrap(self.angles[edge] - rest[edge]))
    }

    /// Sum of the edges' gradients, each times a number.
    fn sum(&self, times: [T; 3]) -> [[T; 3]; 6] {
        let mut all = [[T::ZERO; 3]; 6];
        for (edge, nodes) in EDGES.into_iter().enumerate() {
            for (node, gradient) in nodes.into_iter().zip(self.gradients[edge]) {
                all[node] = add(all[node], scale(gradient, times[edge]));
            }
        }
        all
    }
}

fn numbers<T: Real>(all: [T; 13]) -> ([T; 3], [T; 3], [T; 6], T) {
    let [r0, r1, r2, s0, s1, s2, a, b, c, d, e, f, damping] = all;
    ([r0, r1, r2], [s0, s1, s2], [a, b, c, d, e, f], damping)
}

impl Element<6, 13> for ShapeOperator {
    fn forces<T: Real>(x: [[T; 3]; 6], v: [[T; 3]; 6], all: [T; 13]) -> [[T; 3]; 6] {
        let (rest, steepest, factor, damping) = numbers(all);
        let folds = Folds::of(x, steepest);
        let beyond = folds.beyond(rest);
        let strain = [0, 1, 2].map(|edge: usize| {
            let rate = EDGES[edge]
                .into_iter()
                .zip(folds.gradients[edge])
                .fold(T::ZERO, |sum, (node, gradient)| sum + dot(gradient, v[node]));
            folds.factors[edge] * (beyond[edge] + damping * rate)
        });
        let [x, y, z] = Folds::transposed(factor, strain);
        let [a, b, c, d, e, f] = factor;
        let moments = [a * x, b * x + d * y, c * x + e * y + f * z];
        folds.sum([0, 1, 2].map(|edge| -(folds.factors[edge] * moments[edge])))
    }

    fn energy<T: Real>(x: [[T; 3]; 6], all: [T; 13]) -> T {
        let (rest, steepest, factor, _) = numbers(all);
        let [x, y, z] = Folds::transposed(factor, Folds::of(x, steepest).beyond(rest));
        T::from_f64(0.5) * (x * x + y * y + z * z)
    }

    /// One for each column of L; what a change of the gradients adds is left out (Gauss–Newton).
    fn modes<T: Real>(x: [[T; 3]; 6], all: [T; 13], mut see: impl FnMut(Mode<T, 6>)) {
        let (_, steepest, [a, b, c, d, e, f], damping) = numbers(all);
        let folds = Folds::of(x, steepest);
        let (zero, one) = (T::ZERO, T::ONE);
        for column in [[a, b, c], [zero, d, e], [zero, zero, f]] {
            let directions = folds.sum([0, 1, 2].map(|edge| folds.factors[edge] * column[edge]));
            see(Mode { directions, k: one, d: damping, stiffest: folds.stiffest(steepest) });
        }
    }
}

impl<T: Real> Folds<T> {
    /// How many times stiffer the element may become where its triangles are squashed.
    fn stiffest(&self, steepest: [T; 3]) -> T {
        let ratio = |edge: usize| {
            let steep = steepness(&self.gradients[edge]);
            if steep > T::ZERO { steepest[edge] / steep } else { T::ONE }
        };
        [0, 1, 2].map(ratio).into_iter().fold(T::ONE, |most, one| if one > most { one } else { most })
    }
}

#[cfg(test)]
mod tests;
