//! Triangles of polygons: the valid diagonal of a quad, ears of larger ones.

mod blunt;
mod ears;
mod plane;

use ears::Ears;
use plane::{Point, Projection, normal_of};
use robust::{Coord, orient2d};

/// Area below which a triangle counts as flat, relative to its longest edge squared. A little above the bound below
/// which flat triangles are dropped, so that none of a polygon's triangles is lost.
const FLAT: f64 = 4e-12;

/// Boxes that may be looked at for each corner of a polygon. The hardest of 100,000 corners that do not cross take 400.
const EFFORT: u64 = 1000;

/// Collects the triangles of polygons.
#[derive(Default)]
pub(super) struct Triangulator {
    /// Triangles of nodes.
    pub triangles: Vec<[u32; 3]>,
    /// Polygons with fewer than three different neighbouring corners, and quads that go back the way they came.
    pub collapsed: usize,
    /// Polygons that cross themselves however they are flattened: their triangles overlap.
    pub crossed: usize,
    ring: Vec<u32>,
    ears: Ears,
}

impl Triangulator {
    /// Adds a polygon of vertices.
    pub fn add(&mut self, polygon: &[u32], node_of_vertex: &[u32], nodes: &[[f64; 3]]) {
        self.ring.clear();
        self.ring.extend(polygon.iter().map(|&vertex| node_of_vertex[vertex as usize]));
        self.ring.dedup();
        while self.ring.len() > 1 && self.ring.first() == self.ring.last() {
            self.ring.pop();
        }
        match *self.ring {
            [] | [_] | [_, _] => self.collapsed += 1,
            [a, b, c] => self.triangles.push([a, b, c]),
            [a, b, c, d] if a == c || b == d => self.collapsed += 1,
            [a, b, c, d] => match split([a, b, c, d], nodes) {
                Some(halves) => self.triangles.extend(halves),
                None => self.cut(nodes),
            },
            _ => self.cut(nodes),
        }
    }

    /// Cuts the ears off the ring. One that is warped may cross itself in one projection and not in another.
    fn cut(&mut self, nodes: &[[f64; 3]]) {
        let normal = normal_of(&self.ring, nodes);
        let before = self.triangles.len();
        self.ears.effort = EFFORT * self.ring.len() as u64;
        let whole = Projection::of_normal(normal).any(|projection| {
            self.triangles.truncate(before);
            self.ears_in(projection, nodes, false)
        });
        if !whole {
            self.triangles.truncate(before);
            self.crossed += 1;
            self.ears_in(Projection::major(normal), nodes, true);
        }
    }

    /// Whether the projected ring came apart into triangles that do not overlap.
    fn ears_in(&mut self, projection: Projection, nodes: &[[f64; 3]], force: bool) -> bool {
        let Self { triangles, ring, ears, .. } = self;
        ears.load(projection.points(ring, nodes));
        ears.cut(force, |corners| triangles.push(corners.map(|corner| ring[corner as usize])))
    }
}

/// The triangles on both sides of the shorter diagonal, or of the other one where the shorter lies outside; `None`
/// where both do.
fn split([a, b, c, d]: [u32; 4], nodes: &[[f64; 3]]) -> Option<[[u32; 3]; 2]> {
    let place = |node: u32| nodes[node as usize];
    let projection = Projection::major(normal_of(&[a, b, c, d], nodes));
    let [p, q, r, s] = [a, b, c, d].map(|node| projection.point(place(node)));
    let ac = bulges(p, q, r) && bulges(p, r, s);
    let bd = bulges(p, q, s) && bulges(q, r, s);
    let square = |u: u32, v: u32| (0..3).map(|i| (place(u)[i] - place(v)[i]).powi(2)).sum::<f64>();
    match (ac, bd) {
        (false, false) => None,
        (false, true) => Some([[a, b, d], [b, c, d]]),
        (true, true) if square(b, d) < square(a, c) => Some([[a, b, d], [b, c, d]]),
        (true, _) => Some([[a, b, c], [a, c, d]]),
    }
}

/// Whether three points are counter-clockwise, and clearly so.
fn bulges(a: Point, b: Point, c: Point) -> bool {
    turn(a, b, c) > FLAT * longest(a, b, c)
}

/// Twice the signed area; the sign is exact (Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust
/// Geometric Predicates, 1997).
fn turn([ax, ay]: Point, [bx, by]: Point, [cx, cy]: Point) -> f64 {
    orient2d(Coord { x: ax, y: ay }, Coord { x: bx, y: by }, Coord { x: cx, y: cy })
}

/// Square of the longest edge.
fn longest(a: Point, b: Point, c: Point) -> f64 {
    square(a, b).max(square(b, c)).max(square(c, a))
}

fn square(a: Point, b: Point) -> f64 {
    (b[0] - a[0]).powi(2) + (b[1] - a[1]).powi(2)
}

#[cfg(test)]
mod tests;
