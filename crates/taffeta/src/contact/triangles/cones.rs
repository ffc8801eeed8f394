//! Normal cones: which pairs of triangles and edges push, so that each contact counts once.
//!
//! A vertex above a sheet is near several of its triangles. One has the nearest point of the sheet in it; the nearest points of the
//! others are on their edges, aside, and what pushes from there pushes along the sheet as well. Such a pair would brake cloth that
//! slides without friction. So a pair whose nearest point is on an edge or a corner counts only if the other side stands in the
//! normal cone there: where no face around is nearer.
//!
//! Source: Chen et al., "Offset Geometric Contact", 2025: the feasible region of a contact.

use crate::contact::triangles::surfaces::Kind;
use crate::real::{Real, add, dot, scale, sub};
use crate::topology::Csr;

/// By how much a cone is wider, as the squared sine of an angle: neighbouring cones overlap, so that rounding leaves no gap between
/// them. Where surfaces are flat, all edges that cross would count beside their faces if it were much more.
pub const WIDER: f64 = 1e-8;
/// The same for a pair that carried a force. What lies flat is a little bent one way or the other in each sub-step: pairs that came
/// and went would keep it from coming to rest.
pub const WIDER_KEPT: f64 = 1e-4;
/// What rounding in 32 bits adds to that: so much, (4e-7)², times the squared extent of a face by its squared distance.
pub const ROUNDED: f64 = 1.6e-13;

/// The triangles around a place: for each, its other two corners. `corners` is [`Csr::corners`] of the triangles.
pub fn fan<'a>(
    corners: &'a Csr,
    triangles: &'a [[u32; 3]],
    place: u32,
) -> impl Iterator<Item = [u32; 2]> + use<'a> {
    corners.row(place as usize).iter().map(|&corner| {
        let (triangle, at) = (triangles[corner as usize / 3], corner as usize % 3);
        [triangle[(at + 1) % 3], triangle[(at + 2) % 3]]
    })
}

/// A pair where it is nearest.
pub struct Nearest<T> {
    pub kind: Kind,
    /// Its nodes by place, with their weights.
    pub nodes: [u32; 4],
    pub weights: [T; 4],
    /// From the second side to the first [m].
    pub apart: [T; 3],
    /// Whether the pair carried a force in the last sub-step, or is known to the solver of this one.
    pub carries: bool,
}

impl<T: Real> Nearest<T> {
    /// Whether each side stands in the normal cone of the other, where `fan` has the other corners of the triangles around a place,
    /// and `x` are positions [m]. A vertex has no cone of its own.
    pub fn is_in_cones<F: Iterator<Item = [u32; 2]>>(
        &self,
        fan: impl Fn(u32) -> F,
        x: impl Fn(u32) -> [T; 3],
    ) -> bool {
        let Self { kind, nodes: [a, b, c, d], weights: [u, v, w, z], apart, carries } = *self;
        let wider = T::from_f64(if carries { WIDER_KEPT } else { WIDER });
        let way = scale(apart, -T::ONE);
        let edge = |ends: [u32; 2], weights: [T; 2], way: [T; 3]| {
            fan(ends[0]).filter(|two| two.contains(&ends[1])).all(|[one, other]| {
                let corner = x(if one == ends[1] { other } else { one });
                let part = |end: usize| scale(sub(x(ends[end]), corner), weights[end]);
                is_beyond(way, add(part(0), part(1)), wider)
            })
        };
        let corner = |at: u32| fan(at).flatten().all(|other| is_beyond(apart, sub(x(at), x(other)), wider));
        if kind == Kind::EdgeEdge {
            let are_inside = [u, v, w, z].iter().all(|&weight| weight != T::ZERO);
            return are_inside && edge([a, b], [u, v], way) && edge([c, d], [-w, -z], apart);
        }
        match [v, w, z].map(|weight| weight == T::ZERO) {
            [false, false, false] => true,
            [false, false, _] => edge([b, c], [-v, -w], apart),
            [_, false, false] => edge([c, d], [-w, -z], apart),
            [false, _, false] => edge([b, d], [-v, -z], apart),
            [false, ..] => corner(b),
            [_, false, _] => corner(c),
            [_, _, _] => corner(d),
        }
    }
}

/// Whether a way from a point leads away from the face or edge that ends there, given by a vector from its inside, or is off by an
/// angle whose squared sine is no more than `wider`.
fn is_beyond<T: Real>(way: [T; 3], out: [T; 3], wider: T) -> bool {
    let (along, length) = (dot(way, out), dot(out, out));
    along >= T::ZERO || along * along <= (wider * dot(way, way) + T::from_f64(ROUNDED) * length) * length
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::triangles::closest::{edge_edge, vertex_triangle};
    use crate::real::norm;
    use crate::topology::random::SplitMix64;

    /// A box of edge 2 about the origin.
    const CORNERS: [[f64; 3]; 8] = [
        [-1.0, -1.0, -1.0],
        [1.0, -1.0, -1.0],
        [1.0, 1.0, -1.0],
        [-1.0, 1.0, -1.0],
        [-1.0, -1.0, 1.0],
        [1.0, -1.0, 1.0],
        [1.0, 1.0, 1.0],
        [-1.0, 1.0, 1.0],
    ];
    const FACES: [[u32; 3]; 12] = [
        [0, 2, 1],
        [0, 3, 2],
        [4, 5, 6],
        [4, 6, 7],
        [0, 1, 5],
        [0, 5, 4],
        [2, 3, 7],
        [2, 7, 6],
        [1, 2, 6],
        [1, 6, 5],
        [3, 0, 4],
        [3, 4, 7],
    ];

    /// Pairs of a point with all triangles: distance, direction from the triangle, whether it counts.
    fn pairs(point: [f64; 3], x: &[[f64; 3]], triangles: &[[u32; 3]]) -> Vec<(f64, [f64; 3], bool)> {
        let (own, corners) = (x.len() as u32, Csr::corners(x.len(), triangles));
        let at = |place: u32| if place == own { point } else { x[place as usize] };
        let of = |&[a, b, c]: &[u32; 3]| {
            let nodes = [own, a, b, c];
            let found = vertex_triangle(nodes.map(at));
            let nearest = Nearest {
                kind: Kind::VertexTriangle,
                nodes,
                weights: found.weights,
                apart: found.apart,
                carries: false,
            };
            let distance = norm(found.apart);
            (
                distance,
                scale(found.apart, 1.0 / distance),
                nearest.is_in_cones(|place| fan(&corners, triangles, place), at),
            )
        };
        triangles.iter().map(of).collect()
    }

    /// A grid of 5 by 5 nodes, 1 apart, whose height is given.
    fn sheet(height: impl Fn(f64, f64) -> f64) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        let nodes = (0..25).map(|node| (f64::from(node % 5), f64::from(node / 5)));
        let x = nodes.map(|(x, z)| [x, height(x, z), z]).collect();
        let cells = (0..16).map(|cell| cell / 4 * 5 + cell % 4);
        (x, cells.flat_map(|a| [[a, a + 5, a + 1], [a + 1, a + 5, a + 6]]).collect())
    }

    #[test]
    fn a_large_flat_sheet_pushes_whatever_the_rounding() {
        // Triangles ten thousand times as large as the distance, turned and far from the origin, in 32 bits.
        let (sin, cos) = 0.7_f64.sin_cos();
        let turned = |[x, y, z]: [f64; 3]| [x * cos - y * sin + 3.3, x * sin + y * cos - 5.7, z + 2.1];
        let (x, triangles) = sheet(|_, _| 0.0);
        let corners = Csr::corners(x.len(), &triangles);
        let mut random = SplitMix64::new(9);
        for _ in 0..2000 {
            // Above the diagonals.
            let (a, own) = (0.5 + 3.0 * random.unit(), x.len() as u32);
            let point = turned([a, 1e-4, 4.0 - a]);
            let at = |place: u32| {
                let place = place as usize;
                (if place < x.len() { turned(x[place]) } else { point }).map(|x| x as f32)
            };
            let counts = |&[a, b, c]: &[u32; 3]| {
                let nodes = [own, a, b, c];
                let relative = nodes.map(|node| sub(at(node), at(c)));
                let found = vertex_triangle(relative);
                let kind = Kind::VertexTriangle;
                let (weights, apart) = (found.weights, found.apart);
                Nearest { kind, nodes, weights, apart, carries: false }
                    .is_in_cones(|place| fan(&corners, &triangles, place), at)
            };
            let near = |one: &&[u32; 3]| one.iter().any(|&node| norm(sub(at(node), at(own))) < 1.5);
            assert!(triangles.iter().filter(near).any(counts), "{a}");
        }
    }

    #[test]
    fn a_flat_sheet_never_pushes_aside_and_always_pushes() {
        let (x, triangles) = sheet(|_, _| 0.0);
        let mut random = SplitMix64::new(3);
        for turn in 0..2000 {
            let mut along = || 1.0 + 2.0 * random.unit();
            // Some are exactly above edges and corners.
            let (a, b) = (along(), along());
            let [a, b] = match turn % 4 {
                0 => [a, b.round()],
                1 => [a.round(), b.round()],
                2 => [a, 5.0 - a],
                _ => [a, b],
            };
            let all = pairs([a, 0.7, b], &x, &triangles);
            let counted: Vec<_> = all.iter().filter(|(.., counts)| *counts).collect();
            assert!(!counted.is_empty(), "{a} {b}");
            assert!(counted.iter().all(|(_, way, _)| way[1] > 1.0 - WIDER), "{a} {b}: {counted:?}");
        }
    }

    #[test]
    fn the_nearest_part_of_a_surface_counts() {
        let bumpy = sheet(|x, z| 0.8 * (1.7 * x).sin() * (2.3 * z).cos());
        let mut random = SplitMix64::new(5);
        for (x, triangles) in [(CORNERS.to_vec(), FACES.to_vec()), bumpy] {
            for _ in 0..4000 {
                let point = [0; 3].map(|_| 6.0 * random.unit() - 2.0);
                let all = pairs(point, &x, &triangles);
                let least = all.iter().map(|one| one.0).fold(f64::INFINITY, f64::min);
                let nearest = all.iter().filter(|one| one.0 <= least * (1.0 + 1e-9));
                assert!(nearest.clone().all(|one| one.2), "{point:?}: {nearest:?}");
            }
        }
    }

    #[test]
    fn inside_a_corner_faces_push_and_edges_do_not() {
        let all = pairs([0.6, 0.7, 0.8], &CORNERS, &FACES);
        let counted: Vec<_> =
            all.iter().filter(|(.., counts)| *counts).map(|(distance, ..)| *distance).collect();
        let faces = [1.6, 1.7, 1.8, 0.4, 0.3, 0.2];
        assert_eq!(counted.len(), faces.len(), "{counted:?}");
        for face in faces {
            assert!(counted.iter().any(|distance| (distance - face).abs() < 1e-12), "{face}: {counted:?}");
        }
    }

    #[test]
    fn edges_that_cross_count_where_both_are_ridges() {
        // Two roofs whose ridges cross, the upper one upside down; each may be a valley instead.
        let crossing = |lower: f64, upper: f64, aside: f64| {
            let x = [
                [-1.0, 0.0, 0.1],
                [1.0, 0.0, 0.1],
                [0.0, -lower, 1.0],
                [0.0, -lower, -1.0],
                [aside, 0.5, -1.0],
                [aside, 0.5, 1.0],
                [aside + 1.0, 0.5 + upper, 0.0],
                [aside - 1.0, 0.5 + upper, 0.0],
            ];
            let roofs = [[0, 1, 2], [1, 0, 3], [4, 5, 6], [5, 4, 7]];
            let corners = Csr::corners(8, &roofs);
            let (nodes, at) = ([0, 1, 4, 5], |place: u32| x[place as usize]);
            let found = edge_edge(nodes.map(at));
            let nearest = Nearest {
                kind: Kind::EdgeEdge,
                nodes,
                weights: found.weights,
                apart: found.apart,
                carries: false,
            };
            nearest.is_in_cones(|place| fan(&corners, &roofs, place), at)
        };
        assert!(crossing(0.5, 0.5, 0.2) && crossing(0.0, 0.0, 0.2));
        assert!(!crossing(-0.1, 0.5, 0.2) && !crossing(0.5, -0.1, 0.2));
        assert!(!crossing(0.5, 0.5, 1.2), "past the end of one it is that end and the faces of the other");
    }
}
