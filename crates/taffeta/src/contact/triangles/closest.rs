//! Closest points of a vertex and a triangle, and of two edges.
//!
//! Source: Ericson, "Real-Time Collision Detection", 2005, sections 5.1.5 and 5.1.9, without branches.

use crate::real::{Real, add, cross, dot, scale, sub};

/// The closest points of two sides of a pair, whose four nodes are those of the one and then those of the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest<T> {
    /// Weights of the nodes: the sum of weight times position is the vector from the second point to the first.
    pub weights: [T; 4],
    /// That vector [m].
    pub apart: [T; 3],
}

/// A kind of pair.
pub trait Pair {
    /// How many of its four nodes are its first side.
    const FIRST: usize;
    /// Its closest points.
    fn closest<T: Real>(x: [[T; 3]; 4]) -> Closest<T>;
}

/// A vertex and a triangle.
pub struct VertexTriangle;

/// Two edges.
pub struct EdgeEdge;

impl Pair for VertexTriangle {
    const FIRST: usize = 1;
    #[inline(always)]
    fn closest<T: Real>(x: [[T; 3]; 4]) -> Closest<T> {
        vertex_triangle(x)
    }
}

impl Pair for EdgeEdge {
    const FIRST: usize = 2;
    #[inline(always)]
    fn closest<T: Real>(x: [[T; 3]; 4]) -> Closest<T> {
        edge_edge(x)
    }
}

/// Of a vertex `x[0]` and a triangle `x[1]`, `x[2]`, `x[3]` [m].
#[inline(always)]
pub fn vertex_triangle<T: Real>(x: [[T; 3]; 4]) -> Closest<T> {
    let [p, a, b, c] = x;
    let (ab, bc, ca) = (sub(b, a), sub(c, b), sub(a, c));
    let (ap, bp, cp) = (sub(p, a), sub(p, b), sub(p, c));
    let zero = T::ZERO;
    // On each edge.
    let [s, t, u] = [along(ap, ab), along(bp, bc), along(cp, ca)];
    let from_ab = sub(ap, scale(ab, s));
    let from_bc = sub(bp, scale(bc, t));
    let from_ca = sub(cp, scale(ca, u));
    let mut best = Nearest { squared: dot(from_ab, from_ab), apart: from_ab, weights: [T::ONE - s, s, zero] };
    best = best.or(from_bc, [zero, T::ONE - t, t]);
    best = best.or(from_ca, [u, zero, T::ONE - u]);
    // Inside.
    let normal = cross(ab, scale(ca, -T::ONE));
    let squared = dot(normal, normal);
    let by = if squared > T::TINY { squared } else { T::ONE };
    let in_b = dot(normal, cross(ca, ap)) / by;
    let in_c = dot(normal, cross(ab, ap)) / by;
    let in_a = T::ONE - in_b - in_c;
    let least = if in_b < in_c { in_b } else { in_c };
    let least = if in_a < least { in_a } else { least };
    let inside = squared > T::TINY && least >= zero;
    let above = scale(normal, dot(normal, ap) / by);
    let apart = pick(inside, above, best.apart);
    let [a, b, c] = pick(inside, [in_a, in_b, in_c], best.weights);
    Closest { weights: [T::ONE, -a, -b, -c], apart }
}

/// Of the edges from `x[0]` to `x[1]` and from `x[2]` to `x[3]` [m].
#[inline(always)]
pub fn edge_edge<T: Real>(x: [[T; 3]; 4]) -> Closest<T> {
    let [first, second, between] = [sub(x[1], x[0]), sub(x[3], x[2]), sub(x[0], x[2])];
    let (a, e) = (dot(first, first), dot(second, second));
    let (b, c, f) = (dot(first, second), dot(first, between), dot(second, between));
    let across = a * e - b * b;
    // Parallel edges have many closest points; any will do.
    let s = if across > T::EPSILON * a * e { clamp((b * f - c * e) / across) } else { T::ZERO };
    let t = part(b * s + f, e);
    let s = part(b * t - c, a);
    let t = part(b * s + f, e);
    // One product after the other, as some compilers of GPUs order them anyway.
    let apart = sub(add(between, scale(first, s)), scale(second, t));
    Closest { weights: [T::ONE - s, s, t - T::ONE, -t], apart }
}

/// The nearest point of some, seen from a vertex.
struct Nearest<T> {
    squared: T,
    apart: [T; 3],
    weights: [T; 3],
}

impl<T: Real> Nearest<T> {
    /// This one, or another that is nearer.
    #[inline(always)]
    fn or(self, apart: [T; 3], weights: [T; 3]) -> Self {
        let squared = dot(apart, apart);
        let nearer = squared < self.squared;
        Self {
            squared: if nearer { squared } else { self.squared },
            apart: pick(nearer, apart, self.apart),
            weights: pick(nearer, weights, self.weights),
        }
    }
}

/// The first of two vectors, or the second.
#[inline(always)]
fn pick<T: Real>(first: bool, [a, b, c]: [T; 3], [d, e, f]: [T; 3]) -> [T; 3] {
    [if first { a } else { d }, if first { b } else { e }, if first { c } else { f }]
}

/// How far along an edge, from 0 to 1, the point is that is nearest to the end of a vector from its start.
#[inline(always)]
fn along<T: Real>(vector: [T; 3], edge: [T; 3]) -> T {
    part(dot(vector, edge), dot(edge, edge))
}

/// A part of a whole, from 0 to 1; 0 of nothing.
#[inline(always)]
fn part<T: Real>(some: T, whole: T) -> T {
    clamp(some / if whole > T::TINY { whole } else { T::ONE })
}

#[inline(always)]
fn clamp<T: Real>(x: T) -> T {
    let x = if x > T::ZERO { x } else { T::ZERO };
    if x < T::ONE { x } else { T::ONE }
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::real::norm;
    use crate::topology::random::SplitMix64;

    /// Four points in a cube, some of them in one plane or on one line.
    pub fn four(random: &mut SplitMix64) -> [[f64; 3]; 4] {
        let mut x = [[0.0; 3]; 4];
        x.iter_mut().flatten().for_each(|x| *x = 2.0 * random.unit() - 1.0);
        match random.below(8) {
            0 => x.iter_mut().for_each(|x| x[1] = 0.0),
            1 => x[3] = add(x[2], scale(sub(x[1], x[0]), 0.7)),
            2 => x[0] = add(scale(x[1], 0.3), scale(x[2], 0.7)),
            _ => {}
        }
        x
    }

    /// Whether the plane through each closest point, across the vector between them, has its own side beyond it. That makes
    /// them the closest ones, for both sides are convex.
    fn are_closest<P: Pair>(x: [[f64; 3]; 4]) {
        let found = P::closest(x);
        let weights = found.weights;
        let (first, second) = weights.split_at(P::FIRST);
        assert!(
            (first.iter().sum::<f64>() - 1.0).abs() < 1e-12
                && (second.iter().sum::<f64>() + 1.0).abs() < 1e-12
        );
        assert!(first.iter().all(|&w| w >= 0.0) && second.iter().all(|&w| w <= 0.0), "{weights:?}");
        let sum = (0..4).fold([0.0; 3], |sum, i| add(sum, scale(x[i], weights[i])));
        assert!(norm(sub(sum, found.apart)) < 1e-12, "{sum:?} {:?}", found.apart);
        let point = |range: std::ops::Range<usize>, sign: f64| {
            range.fold([0.0; 3], |sum, i| add(sum, scale(x[i], sign * weights[i])))
        };
        let (one, other) = (point(0..P::FIRST, 1.0), point(P::FIRST..4, -1.0));
        for i in 0..4 {
            let beyond = if i < P::FIRST {
                dot(found.apart, sub(x[i], one))
            } else {
                -dot(found.apart, sub(x[i], other))
            };
            assert!(beyond > -1e-12, "{i}: {beyond} of {x:?}");
        }
    }

    #[test]
    fn no_points_are_closer() {
        let mut random = SplitMix64::new(17);
        for _ in 0..20_000 {
            let x = four(&mut random);
            are_closest::<VertexTriangle>(x);
            are_closest::<EdgeEdge>(x);
        }
    }

    #[test]
    fn points_and_needles_have_closest_points_too() {
        let p = [0.3, 0.1, -0.2];
        for x in [
            [p; 4],
            [[0.0; 3], p, p, p],
            [[0.0; 3], p, scale(p, 2.0), scale(p, 3.0)],
            [p, p, [0.0; 3], [1.0, 0.0, 0.0]],
        ] {
            are_closest::<VertexTriangle>(x);
            are_closest::<EdgeEdge>(x);
        }
    }
}
