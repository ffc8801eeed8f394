//! Whether a segment meets any triangle of a surface: a tree of boxes over the triangles.

use crate::topology::measure::{add_scaled, bounds, cross, dot, norm, sub};

/// Most triangles of a leaf.
const LEAF: usize = 4;

type Point = [f64; 3];

/// Triangles of a surface, ready to be asked.
pub(crate) struct Obstacles<'a> {
    nodes: &'a [Point],
    triangles: &'a [[u32; 3]],
    /// Triangles by leaf.
    order: Vec<u32>,
    boxes: Vec<Node>,
    /// Distance at which a segment counts as touching [m].
    reach: f64,
}

/// A box of the tree, and `count` triangles from `start` on; the two halves of an inner box are at `start` and
/// `start` + 1, and its count is 0.
#[derive(Clone, Copy)]
struct Node {
    lo: Point,
    hi: Point,
    start: u32,
    count: u32,
}

impl<'a> Obstacles<'a> {
    pub(crate) fn new(nodes: &'a [Point], triangles: &'a [[u32; 3]]) -> Self {
        let [lo, hi] = bounds(nodes);
        let reach = 1e-9 * norm(sub(hi, lo));
        let order = (0..triangles.len() as u32).collect();
        let mut obstacles = Self { nodes, triangles, order, boxes: Vec::new(), reach };
        let root = obstacles.around(0..triangles.len());
        obstacles.boxes.push(root);
        let mut next = 0;
        while next < obstacles.boxes.len() {
            obstacles.halve(next);
            next += 1;
        }
        obstacles
    }

    /// A leaf of some of the ordered triangles, its box a little larger than they.
    fn around(&self, range: std::ops::Range<usize>) -> Node {
        let corners: Vec<Point> = self.order[range.clone()].iter().flat_map(|t| self.corners(*t)).collect();
        let [lo, hi] = bounds(&corners);
        let [lo, hi] = [lo.map(|x| x - self.reach), hi.map(|x| x + self.reach)];
        Node { lo, hi, start: range.start as u32, count: range.len() as u32 }
    }

    /// Splits a leaf at the median along its longest side, unless it is small.
    fn halve(&mut self, index: usize) {
        let Node { lo, hi, start, count } = self.boxes[index];
        if count as usize <= LEAF {
            return;
        }
        let size = sub(hi, lo);
        let axis = (0..3).fold(0, |best, i| if size[i] > size[best] { i } else { best });
        let (start, end) = (start as usize, (start + count) as usize);
        let middle = (start + end) / 2;
        let (nodes, triangles) = (self.nodes, self.triangles);
        let along = |t: &u32| triangles[*t as usize].iter().map(|i| nodes[*i as usize][axis]).sum::<f64>();
        let by_place = |s: &u32, t: &u32| along(s).total_cmp(&along(t)).then(s.cmp(t));
        self.order[start..end].select_nth_unstable_by(middle - start, by_place);
        (self.boxes[index].start, self.boxes[index].count) = (self.boxes.len() as u32, 0);
        let halves = [self.around(start..middle), self.around(middle..end)];
        self.boxes.extend(halves);
    }

    fn corners(&self, triangle: u32) -> [Point; 3] {
        self.triangles[triangle as usize].map(|i| self.nodes[i as usize])
    }

    /// Whether the segment between two nodes meets a triangle that has neither of them.
    pub(crate) fn block(&self, ends: [u32; 2]) -> bool {
        let [p, q] = ends.map(|i| self.nodes[i as usize]);
        let inverse = sub(q, p).map(|x| 1.0 / x);
        let mut stack = vec![0];
        while let Some(index) = stack.pop() {
            let node = &self.boxes[index as usize];
            if !enters(p, inverse, node) {
                continue;
            }
            if node.count == 0 {
                stack.extend([node.start, node.start + 1]);
                continue;
            }
            let here = &self.order[node.start as usize..(node.start + node.count) as usize];
            let apart = |t: &&u32| !self.triangles[**t as usize].iter().any(|corner| ends.contains(corner));
            if here.iter().filter(apart).any(|t| touches(p, q, self.corners(*t), self.reach)) {
                return true;
            }
        }
        false
    }
}

/// Whether a segment from `p` with the inverse direction `inverse` enters a box.
fn enters(p: Point, inverse: Point, node: &Node) -> bool {
    let (mut from, mut to) = (0.0f64, 1.0f64);
    for i in 0..3 {
        if inverse[i].is_infinite() {
            if p[i] < node.lo[i] || p[i] > node.hi[i] {
                return false;
            }
            continue;
        }
        let [s, t] = [node.lo[i], node.hi[i]].map(|x| (x - p[i]) * inverse[i]);
        from = from.max(s.min(t));
        to = to.min(s.max(t));
    }
    from <= to
}

/// Whether a segment comes as near to a triangle as `reach` [m]: through its inside, along its plane, or past an
/// edge.
fn touches(p: Point, q: Point, [a, b, c]: [Point; 3], reach: f64) -> bool {
    let normal = cross(sub(b, a), sub(c, a));
    let size = norm(normal);
    let [above_p, above_q] = [p, q].map(|x| dot(normal, sub(x, a)) / size);
    if above_p.min(above_q) > reach || above_p.max(above_q) < -reach {
        return false;
    }
    let drop = above_p - above_q;
    let fraction = if drop.abs() > reach { (above_p / drop).clamp(0.0, 1.0) } else { 0.5 };
    let foot = add_scaled(p, fraction, sub(q, p));
    let within = |from: Point, to: Point| dot(normal, cross(sub(to, from), sub(foot, from))) >= 0.0;
    let inside = within(a, b) && within(b, c) && within(c, a);
    inside || [[a, b], [b, c], [c, a]].iter().any(|[s, t]| distance_squared(p, q, *s, *t) <= reach * reach)
}

/// Squared distance of two segments [m²]; Ericson, Real-Time Collision Detection (2005), 5.1.9.
fn distance_squared(p: Point, q: Point, s: Point, t: Point) -> f64 {
    let [d, e, r] = [sub(q, p), sub(t, s), sub(p, s)];
    let [dd, ee, de] = [dot(d, d), dot(e, e), dot(d, e)];
    let [dr, er] = [dot(d, r), dot(e, r)];
    let determinant = dd * ee - de * de;
    let free = if determinant > 0.0 { ((de * er - dr * ee) / determinant).clamp(0.0, 1.0) } else { 0.0 };
    let along_e = ((de * free + er) / ee).clamp(0.0, 1.0);
    let along_d = ((de * along_e - dr) / dd).clamp(0.0, 1.0);
    let gap = sub(add_scaled(p, along_d, d), add_scaled(s, along_e, e));
    dot(gap, gap)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [Point; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn a_segment_touches_a_triangle_inside_on_its_rim_and_in_its_plane() {
        let touches = |p: Point, q: Point| touches(p, q, TRIANGLE, 1e-9);
        assert!(touches([0.2, 0.2, -1.0], [0.3, 0.3, 1.0]));
        assert!(!touches([0.2, 0.2, 0.1], [0.3, 0.3, 1.0]), "ends above");
        assert!(!touches([0.8, 0.8, -1.0], [0.8, 0.8, 1.0]), "beside");
        assert!(touches([0.5, 0.5, -1.0], [0.5, 0.5, 1.0]), "through the rim");
        assert!(touches([-1.0, 0.2, 0.0], [2.0, 0.2, 0.0]), "across its plane");
        assert!(touches([0.1, 0.1, 0.0], [0.2, 0.2, 0.0]), "within its plane");
        assert!(!touches([-1.0, -0.2, 0.0], [2.0, -0.2, 0.0]), "in its plane, beside");
    }

    #[test]
    fn distances_of_segments_are_those_of_their_nearest_points() {
        let x = |y: f64, from: f64, to: f64| [[from, y, 0.0], [to, y, 0.0]];
        let distance = |[p, q]: [Point; 2], [s, t]: [Point; 2]| distance_squared(p, q, s, t);
        assert_eq!(distance(x(0.0, 0.0, 1.0), x(2.0, 0.5, 3.0)), 4.0);
        assert_eq!(distance(x(0.0, 0.0, 1.0), x(0.0, 3.0, 4.0)), 4.0);
        assert_eq!(distance(x(0.0, -1.0, 1.0), [[0.5, -1.0, 3.0], [0.5, 1.0, 3.0]]), 9.0);
    }

    #[test]
    fn the_tree_finds_what_a_loop_over_all_triangles_finds() {
        let surface = super::super::shapes::surface(&crate::scene::Mesh::Torus(crate::scene::Torus {
            major: 1.0,
            minor: 0.4,
            rings: 12,
            segments: 8,
        }))
        .unwrap();
        let obstacles = Obstacles::new(&surface.nodes, &surface.triangles);
        let mut blocked = 0;
        for [a, b] in (0..96).flat_map(|a| (0..a).map(move |b| [a, b])) {
            let [p, q] = [a, b].map(|i: u32| surface.nodes[i as usize]);
            let apart = surface.triangles.iter().filter(|t| !t.contains(&a) && !t.contains(&b));
            let corners = |t: &[u32; 3]| t.map(|i| surface.nodes[i as usize]);
            let any = apart.into_iter().any(|t| touches(p, q, corners(t), obstacles.reach));
            assert_eq!(obstacles.block([a, b]), any, "{a} {b}");
            blocked += usize::from(any);
        }
        assert!(blocked > 1000 && blocked < 96 * 95 / 2);
    }
}
