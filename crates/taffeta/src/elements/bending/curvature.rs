//! What the folds at a triangle's edges say of its curvature.
//!
//! Two answers are right on regular meshes, and err to either side on others. The *sum* 1/A Σ w l θ n nᵀ (Grinspun, Gingold,
//! Reisman, Zorin, 2006) has the right mean over many triangles, but single ones deviate from it, which costs energy: sheets are too
//! stiff. The *fit* is the quadratic surface with these folds. Its energy is right for every constant curvature, but it finds ways to
//! give way: sheets are too soft. Their mean is what is used.

use crate::real::hypot;

/// Places in the plane of a triangle, by warp and weft [m].
type Point = [f64; 2];

/// Curvatures 11, 22, 12 [1/m].
pub type Curvature = [f64; 3];

/// Curvatures of 1 along 11, 22 and 12.
const BASIS: [Curvature; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// What is across an edge of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Across {
    /// Nothing, or a triangle that counts as nothing.
    Border,
    /// A triangle that is held, and does not bend.
    Clamp,
    /// A triangle, whose third corner is so far along the edge and away from it, in lengths of the edge.
    Triangle([f64; 2]),
}

/// Entries of a matrix beyond those of its inverse, by their norms' product, where a fit is no longer used: six nodes that lie near
/// a conic fit any curvature.
const WORST_FIT: f64 = 30.0;

/// The curvature [1/m] that a fold of 1 rad at each edge means, where the other edges are not folded.
pub fn of_folds(corners: [Point; 3], across: [Across; 3]) -> [Curvature; 3] {
    let sums = [0, 1, 2].map(|e| Side::new(corners, e, across[e]).sum());
    let Some(fits) = fits(corners, across) else { return sums };
    [0, 1, 2].map(|e| [0, 1, 2].map(|i| 0.5 * (sums[e][i] + fits[e][i])))
}

/// The curvatures that are found of quadratic surfaces whose curvature is 1, along 11, 22 and 12.
pub fn found(corners: [Point; 3], across: [Across; 3]) -> [Curvature; 3] {
    let parts = of_folds(corners, across);
    let sides = [0, 1, 2].map(|e| Side::new(corners, e, across[e]));
    BASIS.map(|surface| {
        let folds = sides.each_ref().map(|side| side.fold(surface));
        [0, 1, 2].map(|i| (0..3).map(|e| folds[e] * parts[e][i]).sum())
    })
}

/// The folds at a triangle's edges [rad], by edge, of surfaces with the unit curvatures 11, 22, 12.
pub fn folds(corners: [Point; 3], across: [Across; 3]) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|e| BASIS.map(|surface| Side::new(corners, e, across[e]).fold(surface)))
}

/// An edge of a triangle.
pub struct Side {
    corners: [Point; 3],
    /// The corner across from it, and its ends.
    own: Point,
    ends: [Point; 2],
    /// [m].
    pub length: f64,
    /// Away from the triangle, of length 1.
    pub normal: Point,
    across: Across,
}

impl Side {
    /// That across from a corner.
    pub fn new(corners: [Point; 3], e: usize, across: Across) -> Self {
        let [own, from, to] = [0, 1, 2].map(|step| corners[(e + step) % 3]);
        let along = sub(to, from);
        let length = hypot(along[0], along[1]);
        let normal = [along[1] / length, -along[0] / length];
        let sign = if dot(normal, sub(own, from)) > 0.0 { -1.0 } else { 1.0 };
        Self { corners, own, ends: [from, to], length, normal: normal.map(|c| sign * c), across }
    }

    /// By the sum: w l n nᵀ/A.
    fn sum(&self) -> Curvature {
        let [a, b, c] = self.corners;
        let area = 0.5 * cross(sub(b, a), sub(c, a)).abs();
        let share = if self.across == Across::Clamp { 1.0 } else { 0.5 };
        let [u, v] = self.normal;
        [u * u, v * v, u * v].map(|part| share * self.length / area * part)
    }

    /// The fold of triangles whose nodes are on a quadratic surface [rad].
    fn fold(&self, surface: Curvature) -> f64 {
        let [from, to] = self.ends;
        let here = slope([self.own, from, to], surface);
        let there = match self.across {
            // The tangent in the middle of the edge.
            Across::Clamp => tangent([0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])], surface),
            Across::Border => slope([from, self.place(self.mirrored()), to], surface),
            Across::Triangle(apex) => slope([from, self.place(apex), to], surface),
        };
        dot(sub(there, here), self.normal)
    }

    /// The corner across from the edge on its other side, in lengths of the edge.
    fn mirrored(&self) -> [f64; 2] {
        let ([from, to], squared) = (self.ends, self.length * self.length);
        let own = sub(self.own, from);
        [dot(own, sub(to, from)) / squared, dot(own, self.normal).abs() / self.length]
    }

    fn place(&self, [along, away]: [f64; 2]) -> Point {
        let [from, to] = self.ends;
        [0, 1].map(|i| from[i] + along * (to[i] - from[i]) + away * self.length * self.normal[i])
    }
}

/// The curvatures of quadratic surfaces that are folded by 1 rad at one edge and flat at the others.
fn fits(corners: [Point; 3], across: [Across; 3]) -> Option<[Curvature; 3]> {
    let folds = folds(corners, across);
    let cofactor = |i: usize, j: usize| {
        let (a, b, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        folds[a][c] * folds[b][d] - folds[a][d] * folds[b][c]
    };
    let determinant: f64 = (0..3).map(|j| folds[0][j] * cofactor(0, j)).sum();
    let inverse = [0, 1, 2].map(|e| [0, 1, 2].map(|i| cofactor(e, i) / determinant));
    let norm = |all: &[[f64; 3]; 3]| all.iter().flatten().map(|entry| entry * entry).sum::<f64>().sqrt();
    // Also where the determinant is 0, or no number.
    (norm(&folds) * norm(&inverse) < WORST_FIT).then_some(inverse)
}

/// The slope of the plane through three points of the surface ½ xᵀKx.
fn slope([a, b, c]: [Point; 3], surface: Curvature) -> Point {
    let height = |point: Point| 0.5 * dot(point, tangent(point, surface));
    let (p, q) = (sub(b, a), sub(c, a));
    let [rise, other] = [b, c].map(|point| height(point) - height(a));
    let determinant = cross(p, q);
    [(rise * q[1] - other * p[1]) / determinant, (p[0] * other - q[0] * rise) / determinant]
}

/// The slope of the surface itself.
fn tangent([u, v]: Point, [k11, k22, k12]: Curvature) -> Point {
    [k11 * u + k12 * v, k12 * u + k22 * v]
}

fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SURFACE: Curvature = [0.7, -0.3, 0.4];

    /// The curvature that is found of a quadratic surface.
    fn found(corners: [Point; 3], across: [Across; 3], parts: [Curvature; 3]) -> Curvature {
        let folds = [0, 1, 2].map(|e| Side::new(corners, e, across[e]).fold(SURFACE));
        [0, 1, 2].map(|i| (0..3).map(|e| folds[e] * parts[e][i]).sum())
    }

    fn near(found: Curvature) -> bool {
        found.iter().zip(SURFACE).all(|(a, b)| (a - b).abs() < 1e-12)
    }

    #[test]
    fn a_quadratic_surface_has_its_curvature_on_regular_meshes() {
        // Half a square of a grid, and its neighbours; an equilateral triangle.
        let half = [[0.0, 0.0], [0.2, 0.0], [0.2, 0.2]];
        let grid = [Across::Triangle([1.0, 1.0]), Across::Triangle([0.5, 0.5]), Across::Triangle([0.0, 1.0])];
        let even = [[0.0, 0.0], [0.1, 0.0], [0.05, 0.1 * 0.75_f64.sqrt()]];
        let apex = Across::Triangle([0.5, 0.75_f64.sqrt()]);
        for (corners, across) in [(half, grid), (even, [apex; 3])] {
            let found = found(corners, across, of_folds(corners, across));
            assert!(near(found), "{found:?}");
        }
    }

    #[test]
    fn a_fit_has_the_curvature_on_any_mesh_and_beside_a_clamp() {
        let corners = [[0.0, 0.0], [0.3, 0.02], [0.1, 0.2]];
        let across = [Across::Triangle([0.3, 0.9]), Across::Clamp, Across::Triangle([0.6, 0.5])];
        assert!(near(found(corners, across, fits(corners, across).unwrap())));
    }

    #[test]
    fn nodes_on_a_conic_are_not_fitted() {
        let on_circle = |turn: f64| [(turn * 1.04).cos(), (turn * 1.04).sin()];
        let corners = [0.0, 2.0, 4.0].map(on_circle);
        let apex = |e: usize| {
            let side = Side::new(corners, e, Across::Border);
            let place = on_circle(2.0 * e as f64 + 3.0);
            let from = sub(place, side.ends[0]);
            let along = sub(side.ends[1], side.ends[0]);
            Across::Triangle(
                [dot(from, along), dot(from, side.normal) * side.length].map(|x| x / dot(along, along)),
            )
        };
        let across = [0, 1, 2].map(apex);
        assert!(fits(corners, across).is_none());
        assert!(of_folds(corners, across).iter().flatten().all(|part| part.is_finite()));
    }
}
