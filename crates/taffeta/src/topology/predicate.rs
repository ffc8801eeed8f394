//! Whether triangles meet, answered without rounding: every branch is the sign of a determinant from adaptive
//! arithmetic (Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates", 1997).
//! Coordinates other than 0 must lie between 1e-70 and 1e70 in size.

use crate::topology::measure::{cross, sub};
use robust::{Coord, Coord3D};

pub(crate) type Point = [f64; 3];

/// Whether two triangles have a point in common; one that touches counts. Both have an area.
///
/// ```
/// use taffeta::topology::triangles_meet;
///
/// let floor = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 0.0, 4.0]];
/// // Its tip stands upon the floor, or just above.
/// let tip = |y: f64| [[1.0, y, 1.0], [1.0, 1.0, 1.0], [1.0, 1.0, 2.0]];
/// assert!(triangles_meet(floor, tip(0.0)));
/// assert!(!triangles_meet(floor, tip(1e-60)));
/// ```
pub fn triangles_meet(a: [Point; 3], b: [Point; 3]) -> bool {
    if kept_apart(a, b, 0) {
        return false;
    }
    let a_from_b = a.map(|p| side(b, p));
    if apart(a_from_b) {
        return false;
    }
    let b_from_a = b.map(|p| side(a, p));
    let edges = [[0, 1], [1, 2], [2, 0]];
    let any = |of: [Point; 3], sides: [i8; 3], with| {
        edges.iter().any(|edge| crosses(edge.map(|i| of[i]), edge.map(|i| sides[i]), with))
    };
    !apart(b_from_a) && (any(a, a_from_b, b) || any(b, b_from_a, a))
}

/// Whether a segment has a point in common with a triangle that has an area; one that touches counts. The ends of the segment
/// are no corners of the triangle.
pub(crate) fn segment_meets_triangle(ends: [Point; 2], triangle: [Point; 3]) -> bool {
    crosses(ends, ends.map(|p| side(triangle, p)), triangle)
}

/// Whether two triangles whose first corner is the same point meet beyond it. What two such triangles share is a star
/// around that corner, so it reaches the edge opposite of it in one of the two.
///
/// ```
/// use taffeta::topology::meet_beyond_corner;
///
/// let floor = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 0.0, 4.0]];
/// let above = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [1.0, 1.0, 2.0]];
/// let through = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [1.0, -1.0, 1.0]];
/// assert!(!meet_beyond_corner(floor, above));
/// assert!(meet_beyond_corner(floor, through));
/// ```
pub fn meet_beyond_corner(a: [Point; 3], b: [Point; 3]) -> bool {
    if kept_apart(a, b, 1) {
        return false;
    }
    let opposite = |of: [Point; 3], with: [Point; 3]| {
        let ends = [of[1], of[2]];
        crosses(ends, ends.map(|p| side(with, p)), with)
    };
    opposite(a, b) || opposite(b, a)
}

/// Whether the triangles (a, b, c) and (a, b, d) overlap beyond their edge: they lie in one plane, c and d at the
/// same side of the edge.
///
/// ```
/// use taffeta::topology::overlap_beyond_edge;
///
/// // Two triangles at an edge: spread out, half open, and folded flat.
/// let edge = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
/// let folded = |d| overlap_beyond_edge(edge, [0.5, 0.0, 1.0], d);
/// assert!(!folded([0.5, 0.0, -1.0]));
/// assert!(!folded([0.5, 1.0, 0.0]));
/// assert!(folded([0.5, 0.0, 0.8]));
/// ```
pub fn overlap_beyond_edge([a, b]: [Point; 2], c: Point, d: Point) -> bool {
    if side([a, b, c], d) != 0 {
        return false;
    }
    flat_axis([a, b, c]).is_some_and(|(axis, turn)| turn_along(axis, a, b, d) == turn)
}

/// Whether a line along an edge keeps two triangles apart but for their first `shared` corners, none or one, seen along
/// the axis in which one is widest: an answer for most. Spares triangles of one plane the determinants in space, which
/// are zero and so take all digits.
fn kept_apart(a: [Point; 3], b: [Point; 3], shared: usize) -> bool {
    let axis = widest_axis(a);
    keeps_out(axis, a, b, shared) || keeps_out(axis, b, a, shared)
}

/// Whether an edge of a triangle has the own corners of another one beyond it. A shared corner must be on that edge.
fn keeps_out(axis: usize, [a, b, c]: [Point; 3], other: [Point; 3], shared: usize) -> bool {
    let inside = turn_along(axis, a, b, c);
    let beyond =
        |[u, v]: &[Point; 2]| other[shared..].iter().all(|p| turn_along(axis, *u, *v, *p) == -inside);
    inside != 0 && [[a, b], [c, a], [b, c]][..3 - shared].iter().any(beyond)
}

/// The axis along which a triangle has the largest area, or nearly so.
fn widest_axis([a, b, c]: [Point; 3]) -> usize {
    let normal = cross(sub(b, a), sub(c, a)).map(f64::abs);
    if normal[0] >= normal[1] && normal[0] >= normal[2] {
        0
    } else if normal[1] >= normal[2] {
        1
    } else {
        2
    }
}

/// Whether all three corners are strictly at one side.
fn apart(sides: [i8; 3]) -> bool {
    sides[0] != 0 && sides[0] == sides[1] && sides[1] == sides[2]
}

/// Whether an edge of another triangle has a point in common with a triangle; `sides` says at which side of its plane
/// the ends are.
fn crosses([p, q]: [Point; 2], sides: [i8; 2], triangle: [Point; 3]) -> bool {
    match sides {
        [0, 0] => crosses_in_plane([p, q], triangle),
        [s, t] if s == t => false,
        _ => {
            // The line passes all three edges in the same sense, or through one of them.
            let [a, b, c] = triangle;
            let turns = [[a, b], [b, c], [c, a]].map(|[u, v]| side([p, q, u], v));
            turns.iter().all(|t| *t >= 0) || turns.iter().all(|t| *t <= 0)
        }
    }
}

/// As [`crosses`], for a segment in the triangle's plane: seen along an axis in which the triangle has an area.
fn crosses_in_plane([p, q]: [Point; 2], triangle: [Point; 3]) -> bool {
    let Some((axis, inside)) = flat_axis(triangle) else { return false };
    let turn = |u, v, w| turn_along(axis, u, v, w);
    let [a, b, c] = triangle;
    let edges = [[a, b], [b, c], [c, a]];
    let within = |x| edges.iter().all(|[u, v]| turn(*u, *v, x) != -inside);
    let through = |[u, v]: [Point; 2]| turn(p, q, u) * turn(p, q, v) < 0 && turn(u, v, p) * turn(u, v, q) < 0;
    // A segment that only passes a corner is found from the other triangle, which has the corner within it.
    within(p) || within(q) || edges.into_iter().any(through)
}

/// An axis along which a triangle is seen with an area, and the sense in which it is seen; `None` without an area.
fn flat_axis([a, b, c]: [Point; 3]) -> Option<(usize, i8)> {
    (0..3).map(|axis| (axis, turn_along(axis, a, b, c))).find(|(_, turn)| *turn != 0)
}

/// Side of a triangle's plane on which a point lies: 1 where its normal points, a to b to c by the right hand; 0: in the plane.
pub(crate) fn side_of_triangle(triangle: [Point; 3], point: Point) -> i8 {
    -side(triangle, point)
}

/// Side of a triangle's plane on which a point lies, -1 where its normal points; 0: in the plane.
fn side(triangle: [Point; 3], point: Point) -> i8 {
    let [a, b, c] = triangle.map(coord);
    sign(robust::orient3d(a, b, c, coord(point)))
}

/// Sense of the turn u → v → w, seen along an axis; 0: straight.
fn turn_along(axis: usize, u: Point, v: Point, w: Point) -> i8 {
    let flat = |p: Point| Coord { x: p[(axis + 1) % 3], y: p[(axis + 2) % 3] };
    sign(robust::orient2d(flat(u), flat(v), flat(w)))
}

fn coord([x, y, z]: Point) -> Coord3D<f64> {
    Coord3D { x, y, z }
}

fn sign(x: f64) -> i8 {
    i8::from(x > 0.0) - i8::from(x < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLOOR: [Point; 3] = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];

    fn meets(other: [Point; 3]) -> bool {
        let forth = triangles_meet(FLOOR, other);
        assert_eq!(forth, triangles_meet(other, FLOOR), "{other:?}");
        assert_eq!(forth, triangles_meet(FLOOR, [other[2], other[1], other[0]]), "{other:?} turned over");
        forth
    }

    #[test]
    fn triangles_meet_where_one_pierces_or_touches_the_other() {
        assert!(meets([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [9.0, 9.0, 1.0]]), "pierces");
        assert!(meets([[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [1.0, 2.0, 1.0]]), "a corner stands on it");
        assert!(meets([[2.0, 2.0, -1.0], [2.0, 2.0, 1.0], [9.0, 9.0, 0.0]]), "touches its longest edge");
        assert!(!meets([[1.0, 1.0, 1e-300], [1.0, 1.0, 1.0], [1.0, 2.0, 1.0]]), "just above");
        assert!(!meets([[3.0, 3.0, -1.0], [3.0, 3.0, 1.0], [9.0, 9.0, 0.0]]), "beside");
    }

    #[test]
    fn triangles_in_one_plane_meet_by_crossing_containing_and_touching() {
        let flat = |p: [[f64; 2]; 3]| p.map(|[x, y]| [x, y, 0.0]);
        assert!(meets(flat([[1.0, 1.0], [1.5, 1.0], [1.0, 1.5]])), "inside it");
        assert!(meets(flat([[-9.0, -9.0], [30.0, -9.0], [-9.0, 30.0]])), "around it");
        assert!(meets(flat([[1.0, -1.0], [2.0, -1.0], [1.5, 9.0]])), "across it");
        assert!(meets(flat([[1.0, 0.0], [2.0, 0.0], [1.5, -1.0]])), "along an edge");
        assert!(meets(flat([[4.0, 0.0], [5.0, 0.0], [5.0, -1.0]])), "at a corner");
        assert!(
            !meets(flat([[4.5, 0.0], [5.0, 0.0], [5.0, -1.0]])),
            "on the line of an edge, beyond its end"
        );
        assert!(!meets(flat([[2.0, 2.0 + 1e-15], [3.0, 3.0], [2.0, 3.0]])), "beside by one part in 1e15");
    }

    #[test]
    fn neighbours_overlap_only_beyond_what_they_share() {
        let beyond = |b, c| meet_beyond_corner(FLOOR, [FLOOR[0], b, c]);
        assert!(!beyond([-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]), "opposite in one plane");
        assert!(!beyond([1.0, 1.0, 1.0], [2.0, 1.0, 1.0]), "above");
        assert!(beyond([1.0, 1.0, 1.0], [1.0, 1.0, -1.0]), "through");
        assert!(beyond([1.0, 1.0, 0.0], [1.0, 2.0, 0.0]), "folded upon it");
        assert!(beyond([9.0, 0.0, 0.0], [9.0, -1.0, 0.0]), "along an edge");
        let edge = [FLOOR[0], FLOOR[1]];
        assert!(overlap_beyond_edge(edge, FLOOR[2], [1.0, 1.0, 0.0]));
        assert!(!overlap_beyond_edge(edge, FLOOR[2], [1.0, 1.0, 1e-300]));
        assert!(!overlap_beyond_edge(edge, FLOOR[2], [1.0, -1.0, 0.0]));
    }
}
