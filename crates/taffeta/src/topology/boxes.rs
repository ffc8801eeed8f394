//! A tree of boxes over triangles, to find those that are near: leaves along a Hilbert curve, a complete binary tree
//! above them (after Lauterbach et al., "Fast BVH construction on GPUs", 2009, with equal leaves instead of splits).

use super::measure::add_scaled;
use super::order::locality_order;
use super::predicate::Point;

/// Triangles of a leaf.
pub const LEAF: usize = 4;

/// An axis-aligned box [m].
#[derive(Clone, Copy)]
pub(super) struct Aabb {
    lo: Point,
    hi: Point,
}

impl Aabb {
    const EMPTY: Self = Self { lo: [f64::INFINITY; 3], hi: [f64::NEG_INFINITY; 3] };

    pub(super) fn of(points: &[Point]) -> Self {
        points.iter().fold(Self::EMPTY, |b, p| b.with(&Self { lo: *p, hi: *p }))
    }

    fn with(&self, other: &Self) -> Self {
        Self {
            lo: [0, 1, 2].map(|i| self.lo[i].min(other.lo[i])),
            hi: [0, 1, 2].map(|i| self.hi[i].max(other.hi[i])),
        }
    }

    /// Whether two boxes have a point in common.
    pub(super) fn overlaps(&self, other: &Self) -> bool {
        (0..3).all(|i| self.lo[i] <= other.hi[i] && other.lo[i] <= self.hi[i])
    }
}

/// The tree. Box 1 is the root, 2i and 2i + 1 are the halves of box i, the leaves come last.
pub(super) struct BoxTree {
    /// Triangles, leaf after leaf.
    order: Vec<u32>,
    boxes: Vec<Aabb>,
    /// Number of leaves, empty ones included: a power of two.
    width: usize,
}

/// Triangles in the order of leaves.
pub fn leaf_order(nodes: &[Point], triangles: &[[u32; 3]]) -> Vec<u32> {
    let threefold = |[a, b, c]: [Point; 3]| add_scaled(add_scaled(a, 1.0, b), 1.0, c);
    let centres: Vec<Point> = triangles.iter().map(|t| threefold(t.map(|i| nodes[i as usize]))).collect();
    locality_order(&centres)
}

impl BoxTree {
    pub(super) fn new(nodes: &[Point], triangles: &[[u32; 3]]) -> Self {
        let corners = |t: &[u32; 3]| t.map(|i| nodes[i as usize]);
        let order = leaf_order(nodes, triangles);
        let width = order.len().div_ceil(LEAF).next_power_of_two();
        let mut boxes = vec![Aabb::EMPTY; 2 * width];
        for (leaf, members) in boxes[width..].iter_mut().zip(order.chunks(LEAF)) {
            let around = |b: Aabb, t: &u32| b.with(&Aabb::of(&corners(&triangles[*t as usize])));
            *leaf = members.iter().fold(Aabb::EMPTY, around);
        }
        for i in (1..width).rev() {
            boxes[i] = boxes[2 * i].with(&boxes[2 * i + 1]);
        }
        Self { order, boxes, width }
    }

    /// Number of leaves that hold triangles.
    pub(super) fn leaves(&self) -> usize {
        self.order.len().div_ceil(LEAF)
    }

    /// Triangles of a leaf.
    pub(super) fn members(&self, leaf: usize) -> &[u32] {
        &self.order[leaf * LEAF..self.order.len().min((leaf + 1) * LEAF)]
    }

    /// Leaves from `leaf` on whose box overlaps its box, itself first, until `visit` says that it is enough.
    pub(super) fn near(&self, leaf: usize, mut visit: impl FnMut(usize) -> bool) {
        let around = self.boxes[self.width + leaf];
        let mut stack = vec![1_usize];
        while let Some(i) = stack.pop() {
            let last = ((i + 1) << (self.width.ilog2() - i.ilog2())) - 1 - self.width;
            if last < leaf || !around.overlaps(&self.boxes[i]) {
                continue;
            }
            if i < self.width {
                stack.extend([2 * i + 1, 2 * i]);
            } else if !visit(i - self.width) {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_of_overlapping_leaves_is_visited_once() {
        let surface = crate::topology::shapes::grid_surface(9, 14, [1.0, 2.0]);
        let tree = BoxTree::new(&surface.nodes, &surface.triangles);
        assert_eq!(tree.leaves(), 52);
        let mut all: Vec<u32> = (0..52).flat_map(|leaf| tree.members(leaf)).copied().collect();
        all.sort_unstable();
        assert_eq!(all, (0..208).collect::<Vec<u32>>());
        for leaf in 0..52 {
            let mut found = Vec::new();
            tree.near(leaf, |other| {
                found.push(other);
                true
            });
            let overlap = |other: &usize| tree.boxes[64 + leaf].overlaps(&tree.boxes[64 + other]);
            assert_eq!(found, (leaf..52).filter(overlap).collect::<Vec<_>>());
        }
    }

    #[test]
    fn one_triangle_is_a_tree() {
        let tree = BoxTree::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]);
        let mut visits = 0;
        tree.near(0, |leaf| {
            visits += leaf + 1;
            true
        });
        assert_eq!((tree.leaves(), visits), (1, 1));
    }
}
