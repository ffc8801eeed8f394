//! Where a point lies with respect to closed surfaces: the triangles above it along a ray, found in a tree of boxes.
//! Half-open crossings (Haines, Point in Polygon Strategies, 1994) and exact predicates (Shewchuk, Adaptive Precision
//! Floating-Point Arithmetic and Fast Robust Geometric Predicates, 1997) count each sheet once, whichever edge or node
//! the ray passes.

use robust::{Coord, Coord3D, orient2d, orient3d};
use std::cell::Cell;

/// Boxes, or triangles, in a box.
const FAN: usize = 8;
/// Boxes of triangles that may be opened in all, so that no file takes longer than some seconds: forty for each of a
/// million parts.
pub(super) const BUDGET: u32 = 40_000_000;

type Point = [f64; 3];

/// Triangles of solids in a tree of boxes.
pub(super) struct BoxTree<'a> {
    triangles: &'a [[u32; 3]],
    nodes: &'a [Point],
    /// The triangles, near ones near each other, and the solid of each.
    listed: Vec<(u32, u32)>,
    /// Boxes around each [`FAN`] of those before, the first around triangles, the last around all.
    levels: Vec<Vec<Shade>>,
    /// Which axes lie across the ray, and which along it.
    axes: [usize; 3],
    /// Boxes of triangles that may still be opened.
    left: Cell<u32>,
}

/// The points that triangles may lie above.
#[derive(Clone, Copy)]
struct Shade {
    low: [f64; 2],
    high: [f64; 2],
    top: f64,
    /// Size of the largest solid.
    size: f64,
}

/// Where a point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Where {
    /// Within a solid.
    Inside,
    /// On its surface.
    On,
}

impl<'a> BoxTree<'a> {
    /// Sorts the `listed` triangles, each with the number of its solid, into boxes; `size` says how large a solid is.
    pub fn new(
        triangles: &'a [[u32; 3]],
        nodes: &'a [Point],
        listed: impl Iterator<Item = (u32, u32)> + Clone,
        size: impl Fn(u32) -> f64,
        budget: u32,
    ) -> Self {
        let corners = |triangle: u32| triangles[triangle as usize].map(|node| nodes[node as usize]);
        let [low, high] = bounds(listed.clone().flat_map(|(triangle, _)| corners(triangle)));
        let extent = [0, 1, 2].map(|i| high[i] - low[i]);
        // Along the shortest way, the fewest triangles are above each other.
        let along = (0..3).fold(0, |least, i| if extent[i] < extent[least] { i } else { least });
        let axes = [(along + 1) % 3, (along + 2) % 3, along];
        let cell = |triangle: u32| {
            let at = |i: usize| (corners(triangle)[0][i] - low[i]) / extent[i] * f64::from(u32::MAX);
            interleaved(at(axes[0]) as u32, at(axes[1]) as u32)
        };
        let mut keyed: Vec<_> = listed.map(|(triangle, solid)| (cell(triangle), triangle, solid)).collect();
        keyed.sort_unstable();
        let listed: Vec<(u32, u32)> =
            keyed.into_iter().map(|(_, triangle, solid)| (triangle, solid)).collect();
        let shade = |&(triangle, solid): &(u32, u32)| {
            Shade::of(corners(triangle).map(|p| axes.map(|axis| p[axis])), size(solid))
        };
        let first =
            listed.chunks(FAN).filter_map(|some| some.iter().map(shade).reduce(Shade::join)).collect();
        Self { triangles, nodes, listed, levels: levels(first), axes, left: Cell::new(budget) }
    }

    /// The solids, ascending, that `point` lies in or on, among those larger than `size` that `may` lets through.
    /// `None`: the budget is spent.
    pub fn around(&self, point: Point, size: f64, may: impl Fn(u32) -> bool) -> Option<Vec<(u32, Where)>> {
        let point = self.axes.map(|axis| point[axis]);
        let mut hits = Vec::new();
        // Boxes of a level whose inner ones are still to be looked at; on level 0 the inner ones are triangles.
        let mut open = vec![(self.levels.len() - 1, 0)];
        while let Some((level, at)) = open.pop() {
            if !self.levels[level].get(at).is_some_and(|shade| shade.size > size && shade.holds(point)) {
                continue;
            }
            let inner = FAN * at..FAN * (at + 1);
            if level > 0 {
                open.extend(inner.map(|at| (level - 1, at)));
                continue;
            }
            self.left.set(self.left.get().checked_sub(1)?);
            let inner = self.listed[inner.start..inner.end.min(self.listed.len())].iter();
            for &(triangle, solid) in inner.filter(|(_, solid)| may(*solid)) {
                let node = |node: u32| self.axes.map(|axis| self.nodes[node as usize][axis]);
                let place = hit(self.triangles[triangle as usize].map(node), point);
                hits.extend(place.map(|place| (solid, place)));
            }
        }
        hits.sort_unstable();
        let of_solid = |hits: &[(u32, Where)]| match hits.last() {
            Some(&(solid, Where::On)) => Some((solid, Where::On)),
            Some(&(solid, Where::Inside)) if hits.len() % 2 == 1 => Some((solid, Where::Inside)),
            _ => None,
        };
        Some(hits.chunk_by(|a, b| a.0 == b.0).filter_map(of_solid).collect())
    }
}

/// Whether `point` lies on the triangle, or below it: then the ray upward enters or leaves a solid there.
fn hit(triangle: [Point; 3], point: Point) -> Option<Where> {
    if !Shade::of(triangle, 0.0).holds(point) {
        return None;
    }
    let [a, b, c] = triangle;
    let spatial = |p: Point| Coord3D { x: p[0], y: p[1], z: p[2] };
    // Positive, where the point lies below the plane and the corners are counter-clockwise seen from above.
    let side = orient3d(spatial(a), spatial(b), spatial(c), spatial(point));
    if side == 0.0 && [[0, 1], [1, 2], [2, 0]].iter().all(|axes| touches(triangle, point, *axes)) {
        return Some(Where::On);
    }
    let crossed = [(a, b), (b, c), (c, a)].iter().filter(|(from, to)| crosses(*from, *to, point)).count();
    let winding = flat_side(a, b, c, [0, 1]);
    (crossed == 1 && side * winding.signum() > 0.0).then_some(Where::Inside)
}

/// Whether the point is in the triangle or on its border, both seen along the axis that is not in `axes`.
fn touches([a, b, c]: [Point; 3], point: Point, axes: [usize; 2]) -> bool {
    let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| flat_side(from, to, point, axes));
    sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0)
}

/// Whether an edge lies to the right of the point, seen along the ray: as if the point were an infinitely small step
/// further right, and a far smaller one further up, so that no edge or corner is met exactly.
fn crosses(from: Point, to: Point, point: Point) -> bool {
    let (low, high) = if from[1] < to[1] { (from, to) } else { (to, from) };
    low[1] <= point[1] && point[1] < high[1] && flat_side(low, high, point, [0, 1]) > 0.0
}

/// Positive, where `point` lies to the left of the line.
fn flat_side(from: Point, to: Point, point: Point, axes: [usize; 2]) -> f64 {
    let flat = |p: Point| Coord { x: p[axes[0]], y: p[axes[1]] };
    orient2d(flat(from), flat(to), flat(point))
}

/// Lower and upper corner of the box around points.
pub(super) fn bounds(points: impl Iterator<Item = Point>) -> [Point; 2] {
    points.fold([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], |[low, high], p| {
        [[0, 1, 2].map(|i| low[i].min(p[i])), [0, 1, 2].map(|i| high[i].max(p[i]))]
    })
}

impl Shade {
    fn of([a, b, c]: [Point; 3], size: f64) -> Self {
        let of = |choose: fn(f64, f64) -> f64, i: usize| choose(a[i], choose(b[i], c[i]));
        let [low, high] = [f64::min, f64::max].map(|choose| [of(choose, 0), of(choose, 1)]);
        Self { low, high, top: of(f64::max, 2), size }
    }

    fn join(self, other: Self) -> Self {
        Self {
            low: [0, 1].map(|i| self.low[i].min(other.low[i])),
            high: [0, 1].map(|i| self.high[i].max(other.high[i])),
            top: self.top.max(other.top),
            size: self.size.max(other.size),
        }
    }

    fn holds(&self, point: Point) -> bool {
        (0..2).all(|i| self.low[i] <= point[i] && point[i] <= self.high[i]) && point[2] <= self.top
    }
}

/// Boxes around boxes, up to a single one.
fn levels(first: Vec<Shade>) -> Vec<Vec<Shade>> {
    let mut levels = vec![first];
    while let Some(last) = levels.last().filter(|last| last.len() > 1) {
        let next = last.chunks(FAN).filter_map(|some| some.iter().copied().reduce(Shade::join));
        levels.push(next.collect());
    }
    levels
}

/// The bits of two numbers in turn: near cells have near numbers (Morton, A Computer Oriented Geodetic Data Base, 1966).
fn interleaved(a: u32, b: u32) -> u64 {
    let spread = |x: u32| {
        [(16, 0x0000_ffff_0000_ffff), (8, 0x00ff_00ff_00ff_00ff), (4, 0x0f0f_0f0f_0f0f_0f0f)]
            .into_iter()
            .chain([(2, 0x3333_3333_3333_3333), (1, 0x5555_5555_5555_5555)])
            .fold(u64::from(x), |x, (shift, mask)| (x | x << shift) & mask)
    };
    spread(a) | spread(b) << 1
}

#[cfg(test)]
mod tests {
    use super::{BoxTree, Point, Where};

    /// A cube from 0 to 2 whose faces meet at their middles, as triangles.
    fn cube() -> Vec<Point> {
        let mut corners = Vec::new();
        for axis in 0..3 {
            for side in [0.0, 2.0] {
                let at = |u: f64, v: f64| {
                    let mut p = [side; 3];
                    (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (u, v);
                    p
                };
                let ring = [at(0.0, 0.0), at(2.0, 0.0), at(2.0, 2.0), at(0.0, 2.0)];
                corners.extend((0..4).flat_map(|i| [ring[i], ring[(i + 1) % 4], at(1.0, 1.0)]));
            }
        }
        corners
    }

    /// Each three points are a triangle; the cube's are solid 0, the others solid 1.
    fn triangles(points: &[Point]) -> (Vec<[u32; 3]>, Vec<(u32, u32)>) {
        let count = points.len() as u32 / 3;
        let listed = (0..count).map(|t| (t, u32::from(t >= 24))).collect();
        ((0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(), listed)
    }

    #[test]
    fn a_point_is_in_on_or_out_even_below_nodes_and_edges() {
        let points = cube();
        let (triangles, listed) = triangles(&points);
        let tree = BoxTree::new(&triangles, &points, listed.into_iter(), |_| 1.0, 1000);
        let of = |p: Point| tree.around(p, 0.0, |_| true).unwrap();
        let steps = [-0.5, 0.0, 0.5, 1.0, 1.5, 2.0, 2.5];
        for (x, y, z) in steps.iter().flat_map(|x| steps.map(|y| steps.map(|z| (*x, y, z)))).flatten() {
            let within = [x, y, z].iter().all(|c| (0.0..=2.0).contains(c));
            let on = within && [x, y, z].iter().any(|c| [0.0, 2.0].contains(c));
            let expected = match (within, on) {
                (false, _) => vec![],
                (true, true) => vec![(0, Where::On)],
                (true, false) => vec![(0, Where::Inside)],
            };
            assert_eq!(of([x, y, z]), expected, "{x} {y} {z}");
        }
    }

    #[test]
    fn solids_are_told_apart_and_may_be_passed_over() {
        let smaller = cube().into_iter().map(|p| p.map(|x| 0.5 + 0.5 * x));
        let points: Vec<Point> = cube().into_iter().chain(smaller).collect();
        let (triangles, listed) = triangles(&points);
        let tree = BoxTree::new(&triangles, &points, listed.into_iter(), |_| 1.0, 1000);
        assert_eq!(tree.around([1.0; 3], 0.0, |_| true).unwrap(), [(0, Where::Inside), (1, Where::Inside)]);
        assert_eq!(tree.around([0.25; 3], 0.0, |_| true).unwrap(), [(0, Where::Inside)]);
        assert_eq!(tree.around([1.0; 3], 0.0, |solid| solid == 1).unwrap(), [(1, Where::Inside)]);
    }

    #[test]
    fn the_work_is_limited() {
        let points = cube();
        let (triangles, listed) = triangles(&points);
        // Each box of triangles of the cube is below the point or above it.
        let tree = BoxTree::new(&triangles, &points, listed.into_iter(), |_| 1.0, 4);
        assert!(tree.around([1.0; 3], 0.0, |_| true).is_some());
        assert_eq!(tree.around([1.0; 3], 2.0, |_| true), Some(vec![]), "there is none so large, and no work");
        assert_eq!([0, 1].map(|_| tree.around([1.0; 3], 0.0, |_| true)), [const { None }; 2]);
    }

    #[test]
    fn long_triangles_above_each_other_are_passed_over() {
        let mut points = cube();
        for i in 0..2000 {
            let x = f64::from(i) * 1e-3;
            points.extend([[0.0, x, 0.3], [2.0, 2.0 - x, 0.3], [2.0, 2.001 - x, 0.3]]);
        }
        let (triangles, listed) = triangles(&points);
        let tree = BoxTree::new(&triangles, &points, listed.into_iter(), |_| 1.0, 1000);
        assert_eq!(tree.around([1.0; 3], 0.0, |solid| solid == 0).unwrap(), [(0, Where::Inside)]);
    }
}
