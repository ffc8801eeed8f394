//! One triangle and a node: the nearest point (Ericson, "Real-Time Collision Detection", 2005, section 5.1.5), and
//! the crossing of a segment.

use crate::real::{Real, cross, dot, sub};

/// Corners [m].
pub type Corners<T> = [[T; 3]; 3];

/// The nearest point of a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Nearest<T> {
    /// Barycentric coordinates; exactly 0 if the point is on an edge or corner without that corner.
    pub barycentric: [T; 3],
    /// From the point to the position [m].
    pub apart: [T; 3],
    /// Squared length of that [m²].
    pub squared: T,
}

/// The point of a triangle nearest to `x`.
#[inline(always)]
pub fn nearest<T: Real>(x: [T; 3], corners: &Corners<T>) -> Nearest<T> {
    let barycentric = barycentric_of_nearest(x, corners);
    let apart = sub(x, mix(corners, barycentric));
    Nearest { barycentric, apart, squared: dot(apart, apart) }
}

/// Σ weight · corner.
#[inline(always)]
pub fn mix<T: Real>([a, b, c]: &Corners<T>, [u, v, w]: [T; 3]) -> [T; 3] {
    let along = |i: usize| a[i] * u + b[i] * v + c[i] * w;
    [along(0), along(1), along(2)]
}

/// The seven regions of space are distinguished without a branch, so that triangles can be computed side by side.
#[inline(always)]
fn barycentric_of_nearest<T: Real>(x: [T; 3], &[a, b, c]: &Corners<T>) -> [T; 3] {
    let (zero, one) = (T::ZERO, T::ONE);
    let (ab, ac) = (sub(b, a), sub(c, a));
    let (from_a, from_b, from_c) = (sub(x, a), sub(x, b), sub(x, c));
    let (d1, d2) = (dot(ab, from_a), dot(ac, from_a));
    let (d3, d4) = (dot(ab, from_b), dot(ac, from_b));
    let (d5, d6) = (dot(ab, from_c), dot(ac, from_c));
    // Areas along the normal, instead of differences of products of d1 to d6, which cancel for narrow triangles.
    let normal = cross(ab, ac);
    let all = dot(normal, normal);
    let (vb, vc) = (dot(cross(from_a, ac), normal), dot(cross(ab, from_a), normal));
    let va = all - vb - vc;
    let inverse = one / all;
    let (v, w) = (vb * inverse, vc * inverse);
    let on_ab = part(d1, d1 - d3);
    let on_ac = part(d2, d2 - d6);
    let on_bc = part(d4 - d3, (d4 - d3) + (d5 - d6));
    let pick = |is_in: bool, some: [T; 3], other: [T; 3]| {
        [
            if is_in { some[0] } else { other[0] },
            if is_in { some[1] } else { other[1] },
            if is_in { some[2] } else { other[2] },
        ]
    };
    let barycentric = [one - v - w, v, w];
    let barycentric = pick((va <= zero) & (d4 >= d3) & (d5 >= d6), [zero, one - on_bc, on_bc], barycentric);
    let barycentric =
        pick((vb <= zero) & (d2 >= zero) & (d6 <= zero), [one - on_ac, zero, on_ac], barycentric);
    let barycentric = pick((d6 >= zero) & (d5 <= d6), [zero, zero, one], barycentric);
    let barycentric =
        pick((vc <= zero) & (d1 >= zero) & (d3 <= zero), [one - on_ab, on_ab, zero], barycentric);
    let barycentric = pick((d3 >= zero) & (d4 <= d3), [zero, one, zero], barycentric);
    pick((d1 <= zero) & (d2 <= zero), [one, zero, zero], barycentric)
}

/// A fraction of an edge; 0 if the edge has no length.
#[inline(always)]
fn part<T: Real>(some: T, all: T) -> T {
    if all > T::ZERO { some / all } else { T::ZERO }
}

/// The crossing of a segment and a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Crossing<T> {
    /// Fraction of the segment before it.
    pub fraction: T,
    /// Barycentric coordinates.
    pub barycentric: [T; 3],
    /// Unit normal of the triangle there, toward the segment's start.
    pub normal: [T; 3],
    /// Whether the segment goes inward: from the side to which the triangle's own normal points.
    pub inward: bool,
    /// Squared distance of its start from the triangle's plane at that time [m²].
    pub from: T,
}

/// The crossing of a node that moves straight from `start` to `end` and a triangle that moves from `before` to
/// `after`. Distances from its plane count as linear in time.
pub fn crossing<T: Real>(
    [start, end]: [[T; 3]; 2],
    before: &Corners<T>,
    after: &Corners<T>,
) -> Option<Crossing<T>> {
    let (first, last) = (normal_of(before), normal_of(after));
    let (above, below) = (dot(sub(start, before[0]), first), dot(sub(end, after[0]), last));
    let inward = above >= T::ZERO;
    if inward == (below >= T::ZERO) {
        return None;
    }
    let fraction = above / (above - below);
    let place = between(start, end, fraction);
    let corners = [0, 1, 2].map(|i| between(before[i], after[i], fraction));
    let normal = normal_of(&corners);
    let squared = dot(normal, normal);
    if squared <= T::TINY {
        return None;
    }
    // Slightly wider than the triangle, so that segments do not slip through between two.
    let least = squared * -T::from_f64(SLACK);
    let [a, b, c] = corners;
    let part = |p: [T; 3], q: [T; 3]| dot(cross(sub(q, p), sub(place, p)), normal);
    let parts = [part(b, c), part(c, a), part(a, b)];
    if parts.iter().any(|&part| part < least) {
        return None;
    }
    let inverse = T::ONE / squared;
    let unit = T::ONE / squared.sqrt();
    let side = if inward { unit } else { -unit };
    Some(Crossing {
        fraction,
        barycentric: parts.map(|part| part * inverse),
        normal: normal.map(|n| n * side),
        inward,
        from: above * above / (dot(first, first) + T::TINY),
    })
}

/// Twice the area of a triangle [m²] times its unit normal.
pub fn normal_of<T: Real>(&[a, b, c]: &Corners<T>) -> [T; 3] {
    cross(sub(b, a), sub(c, a))
}

/// Linear interpolation between two positions.
#[inline(always)]
pub fn between<T: Real>(from: [T; 3], to: [T; 3], fraction: T) -> [T; 3] {
    let along = |i: usize| from[i] + (to[i] - from[i]) * fraction;
    [along(0), along(1), along(2)]
}

/// The weight of a triangle's unit normal at a corner or an edge: its angle there, π for an edge (Bærentzen and
/// Aanæs, "Signed Distance Computation Using the Angle Weighted Pseudonormal", 2005). `at` are the corners of the
/// feature.
pub fn pseudonormal<T: Real>(corners: &Corners<T>, at: [bool; 3]) -> [T; 3] {
    let normal = normal_of(corners);
    let squared = dot(normal, normal);
    if squared <= T::TINY {
        return [T::ZERO; 3];
    }
    let corner = at.iter().position(|&at| at).unwrap_or(0);
    let weight = if at.iter().filter(|&&at| at).count() > 1 { T::ONE } else { angle_at(corners, corner) };
    let inverse = weight / squared.sqrt();
    normal.map(|n| n * inverse)
}

/// The angle at a corner [rad].
fn angle_at<T: Real>(corners: &Corners<T>, corner: usize) -> T {
    let [p, q, r] = [0, 1, 2].map(|i| corners[(corner + i) % 3]);
    let (a, b) = (sub(q, p), sub(r, p));
    let sine = cross(a, b);
    dot(sine, sine).sqrt().atan2(dot(a, b))
}

/// Relative excess of the area in which a triangle is crossed.
pub const SLACK: f64 = 1e-4;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::real::add;

    const FLAT: Corners<f64> = [[0.0, 0.0, 0.0], [0.0, 0.0, 2.0], [3.0, 0.0, 0.0]];

    #[test]
    fn the_nearest_point_is_in_a_face_on_an_edge_or_at_a_corner() {
        let at = |x| {
            let found = nearest(x, &FLAT);
            (mix(&FLAT, found.barycentric), found.squared)
        };
        assert_eq!(at([0.5, 2.0, 0.5]), ([0.5, 0.0, 0.5], 4.0));
        assert_eq!(at([1.5, 0.0, -1.0]), ([1.5, 0.0, 0.0], 1.0));
        assert_eq!(at([-1.0, 0.0, 1.0]), ([0.0, 0.0, 1.0], 1.0));
        assert_eq!(at([4.0, 0.0, -1.0]).0, [3.0, 0.0, 0.0]);
        assert_eq!(at([-1.0, 1.0, -1.0]), ([0.0; 3], 3.0));
        let slanted = nearest([3.0, 0.0, 2.0], &FLAT);
        assert_eq!(slanted.barycentric[0], 0.0);
        assert!((slanted.squared - 36.0 / 13.0).abs() < 1e-12);
    }

    #[test]
    fn narrow_triangles_are_as_near_in_32_bits_as_in_64() {
        // One side of a plate of 0.8 m that is 0.1 mm thick, from beside it.
        let narrow: Corners<f32> = [[-0.4, -5e-5, -0.4], [-0.4, -5e-5, 0.4], [-0.4, 5e-5, 0.4]];
        let exact = narrow.map(|corner| corner.map(f64::from));
        let mut worst = 0.0_f64;
        for (y, z) in (0..40).flat_map(|i| (0..40).map(move |j| (i as f32, j as f32))) {
            let x = [-0.41, -6e-5 + 3e-6 * y, -0.39 + 0.02 * z];
            let (seen, true_one) = (nearest(x, &narrow), nearest(x.map(f64::from), &exact));
            worst = worst.max((f64::from(seen.squared) / true_one.squared - 1.0).abs());
        }
        assert!(worst < 1e-4, "{worst}");
    }

    #[test]
    fn a_way_goes_through_once_and_from_a_side() {
        let through = |from: [f64; 3], to| crossing([from, to], &FLAT, &FLAT);
        let down = through([0.5, 3.0, 0.5], [0.5, -1.0, 0.5]).unwrap();
        assert_eq!((down.fraction, down.normal, down.inward), (0.75, [0.0, 1.0, 0.0], true));
        assert_eq!(mix(&FLAT, down.barycentric), [0.5, 0.0, 0.5]);
        let up = through([0.5, -1.0, 0.5], [0.5, 3.0, 0.5]).unwrap();
        assert_eq!((up.fraction, up.normal, up.inward), (0.25, [0.0, -1.0, 0.0], false));
        assert!(through([0.5, 3.0, 0.5], [0.5, 1.0, 0.5]).is_none());
        assert!(through([3.0, 3.0, 2.0], [3.0, -1.0, 2.0]).is_none());
    }

    #[test]
    fn a_triangle_that_moves_is_met_where_it_is_then() {
        let lifted = FLAT.map(|[x, _, z]| [x, 2.0, z]);
        let met = crossing([[0.5, 1.0, 0.5], [0.5, 1.0, 0.5]], &FLAT, &lifted).unwrap();
        assert_eq!((met.fraction, met.normal, met.inward), (0.5, [0.0, 1.0, 0.0], true));
    }

    #[test]
    fn the_corner_of_a_cube_has_its_diagonal_as_pseudonormal() {
        let one = |a: [f64; 3], b| pseudonormal(&[[0.0; 3], a, b], [true, false, false]);
        let faces = [
            one([1.0, 0.0, 0.0], [1.0, 1.0, 0.0]),
            one([1.0, 1.0, 0.0], [0.0, 1.0, 0.0]),
            one([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]),
            one([0.0, 0.0, 1.0], [1.0, 0.0, 0.0]),
        ];
        let sum = faces.into_iter().fold([0.0; 3], add);
        assert!((sum[0] - sum[1]).abs() < 1e-6 && (sum[1] - sum[2]).abs() < 1e-6, "{sum:?}");
    }
}
