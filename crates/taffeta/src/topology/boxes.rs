//! A tree of boxes over triangles, to find those that are near: leaves along a Hilbert curve, a complete binary tree
//! above them (after Lauterbach et al., "Fast BVH construction on GPUs", 2009, with equal leaves instead of splits).
//!
//! ```
//! use taffeta::topology::boxes::{around, leaf_order, tree_boxes};
//! use taffeta::topology::shapes::grid_surface;
//!
//! let sheet = grid_surface(5, 9, [0.8, 0.4]);
//! let corners = |t: u32| sheet.triangles[t as usize].map(|node| sheet.nodes[node as usize]);
//! let order = leaf_order(&sheet.nodes, &sheet.triangles);
//! let boxes = tree_boxes(order.iter().map(|&t| around(corners(t))));
//! // 64 triangles in 16 leaves; the root is around all of them.
//! assert_eq!(boxes.len(), 2 * 16);
//! assert_eq!(boxes[1], [[-0.4, 0.0, -0.2], [0.4, 0.0, 0.2]]);
//! ```

use crate::topology::measure::add_scaled;
use crate::topology::order::locality_order;
use crate::topology::predicate::Point;

/// Triangles of a leaf.
pub const LEAF: usize = 4;

/// The lower and the upper corner of a box [m].
pub type Bounds = [Point; 2];

/// No box yet.
pub const NOWHERE: Bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];

/// The box around two others.
pub fn join(a: Bounds, b: Bounds) -> Bounds {
    [[0, 1, 2].map(|i| a[0][i].min(b[0][i])), [0, 1, 2].map(|i| a[1][i].max(b[1][i]))]
}

/// The box around some points.
pub fn around(points: impl IntoIterator<Item = Point>) -> Bounds {
    points.into_iter().fold(NOWHERE, |all, point| join(all, [point; 2]))
}

/// Whether two boxes have a point in common.
pub(crate) fn overlap(a: &Bounds, b: &Bounds) -> bool {
    (0..3).all(|i| a[0][i] <= b[1][i] && b[0][i] <= a[1][i])
}

/// The boxes of a tree over triangles, whose own are given in the order of leaves: box 1 is the root, 2i and 2i + 1 are the
/// halves of box i, the leaves come last, a power of two of them. Box 0 and empty leaves are nowhere.
pub fn tree_boxes(triangles: impl ExactSizeIterator<Item = Bounds>) -> Vec<Bounds> {
    let width = triangles.len().div_ceil(LEAF).next_power_of_two();
    let mut boxes = vec![NOWHERE; 2 * width];
    for (place, triangle) in triangles.enumerate() {
        let leaf = &mut boxes[width + place / LEAF];
        *leaf = join(*leaf, triangle);
    }
    for i in (1..width).rev() {
        boxes[i] = join(boxes[2 * i], boxes[2 * i + 1]);
    }
    boxes
}

/// The tree.
pub(crate) struct BoxTree {
    /// Triangles, leaf after leaf.
    order: Vec<u32>,
    /// See [`tree_boxes`].
    boxes: Vec<Bounds>,
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
    pub(crate) fn new(nodes: &[Point], triangles: &[[u32; 3]]) -> Self {
        let order = leaf_order(nodes, triangles);
        let corners = |t: &u32| triangles[*t as usize].map(|node| nodes[node as usize]);
        let boxes = tree_boxes(order.iter().map(|t| around(corners(t))));
        let width = boxes.len() / 2;
        Self { order, boxes, width }
    }

    /// Number of leaves that hold triangles.
    pub(crate) fn leaves(&self) -> usize {
        self.order.len().div_ceil(LEAF)
    }

    /// Triangles of a leaf.
    pub(crate) fn members(&self, leaf: usize) -> &[u32] {
        &self.order[leaf * LEAF..self.order.len().min((leaf + 1) * LEAF)]
    }

    /// Leaves from `leaf` on whose box overlaps its box, itself first, until `visit` says that it is enough.
    pub(crate) fn near(&self, leaf: usize, mut visit: impl FnMut(usize) -> bool) {
        let around = self.boxes[self.width + leaf];
        let mut stack = vec![1_usize];
        while let Some(i) = stack.pop() {
            let last = ((i + 1) << (self.width.ilog2() - i.ilog2())) - 1 - self.width;
            if last < leaf || !overlap(&around, &self.boxes[i]) {
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
            let meets = |other: &usize| overlap(&tree.boxes[64 + leaf], &tree.boxes[64 + other]);
            assert_eq!(found, (leaf..52).filter(meets).collect::<Vec<_>>());
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
