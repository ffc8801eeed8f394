//! A tree of boxes over triangles: leaves of neighbours along a Hilbert curve, a complete binary tree above them (after
//! Lauterbach et al., "Fast BVH construction on GPUs", 2009, with equal leaves instead of splits).

use crate::real::{Real, dot, sub};
use crate::topology::boxes::{self, LEAF, leaf_order, tree_boxes};
use std::ops::Range;

/// The lower and the upper corner of a box [m].
type Bounds<T> = [[T; 3]; 2];

/// Some of a mesh's triangles.
pub trait Candidates<T> {
    /// Calls back with each triangle's index.
    fn visit(&self, job: impl FnMut(u32));
}

/// The tree. Box 1 is the root, 2i and 2i + 1 are the halves of box i; the leaves come last, four triangles each.
#[derive(Clone, Debug)]
pub struct Tree<T> {
    /// Box 0 is unused.
    pub boxes: Vec<Bounds<T>>,
    /// Number of triangles.
    triangles: u32,
    /// Squared rounding error [m²].
    pub rounding: T,
}

/// Most turns of the walks of a node through triangles on a software adapter. It runs eight nodes side by side, which
/// share the turns of a loop; this leaves the others for everything else.
#[cfg(feature = "gpu")]
pub const WALK_TURNS: u32 = 6_000;

/// Relative tolerance of squared distances, so that boxes do not hide triangles by rounding. With a rounding error e,
/// (d + e)² ≤ d² (1 + s) + e² (1 + 1/s).
pub const SLACK: f64 = 1e-3;

impl<T: Real> Tree<T> {
    /// From boxes of double precision.
    pub fn of(boxes: &[Bounds<f64>], triangles: usize) -> Self {
        let number = |corner: [f64; 3]| corner.map(T::from_f64);
        let extent = boxes[1].iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
        let lost = 8.0 * T::EPSILON.to_f64() * extent;
        Self {
            boxes: boxes.iter().map(|ends| ends.map(number)).collect(),
            triangles: triangles as u32,
            rounding: T::from_f64(lost * lost / SLACK),
        }
    }

    /// Triangles in the order of leaves, and the boxes around both ends of each interval between poses, and of the one
    /// before it, from which a sub-step may come.
    pub fn boxes(poses: &[Vec<[f64; 3]>], triangles: &[[u32; 3]]) -> (Vec<[u32; 3]>, Vec<Vec<Bounds<f64>>>) {
        let order = leaf_order(&poses[0], triangles);
        let ordered: Vec<[u32; 3]> = order.iter().map(|&t| triangles[t as usize]).collect();
        let intervals: Vec<&[Vec<[f64; 3]>]> = if poses.len() == 1 {
            vec![poses]
        } else {
            (1..poses.len()).map(|i| &poses[i.max(2) - 2..=i]).collect()
        };
        let boxes =
            intervals.into_iter().map(|ends| tree_boxes(ordered.iter().map(|t| swept(ends, t)))).collect();
        (ordered, boxes)
    }

    /// Number of leaves, empty ones included: a power of two.
    fn width(&self) -> usize {
        self.boxes.len() / 2
    }

    /// Squared distance of a position from a box [m²].
    #[inline(always)]
    fn squared(&self, index: usize, x: [T; 3]) -> T {
        let [lo, hi] = &self.boxes[index];
        let beyond = |i: usize| {
            let (below, above) = (lo[i] - x[i], x[i] - hi[i]);
            let most = if below > above { below } else { above };
            if most > T::ZERO { most } else { T::ZERO }
        };
        let beyond = [beyond(0), beyond(1), beyond(2)];
        dot(beyond, beyond)
    }

    /// Triangles of a box of the last two levels: of one leaf or two.
    fn members(&self, index: usize) -> Range<u32> {
        let leaves = if index < self.width() { 2 } else { 1 };
        let first = ((index * leaves - self.width()) * LEAF) as u32;
        self.triangles.min(first)..self.triangles.min(first + (leaves * LEAF) as u32)
    }

    /// Largest rounding error of a distance [m].
    pub fn lost(&self) -> T {
        (self.rounding * T::from_f64(SLACK)).sqrt()
    }

    /// Lower bound of the distance of a position from all triangles [m], if it exceeds their extent. They need no
    /// search then.
    pub fn far_from(&self, x: [T; 3]) -> Option<T> {
        let [lo, hi] = self.boxes[1];
        let across = sub(hi, lo);
        let squared = self.squared(1, x);
        (squared > dot(across, across)).then(|| squared.sqrt() - self.lost())
    }

    /// Whether a position is outside the box around all triangles.
    pub fn is_outside(&self, x: [T; 3]) -> bool {
        self.squared(1, x) > T::ZERO
    }

    /// Visits triangles around a position, eight at most at a time, those in nearer boxes first. `job` returns how
    /// close others must be. One is known to be within `within`. Returns a lower bound of the distance of those left
    /// out [m²].
    pub fn visit_around(&self, x: [T; 3], within: T, mut job: impl FnMut(Range<u32>) -> T) -> T {
        let slack = T::from_f64(1.0 + SLACK);
        let (mut bound, mut left_out) = (within, T::FAR);
        // One box a level waits, and the tree has less than 32 levels.
        let mut stack = [(0_u32, T::ZERO); 40];
        let mut waiting = 1;
        stack[0] = (1, self.squared(1, x));
        while waiting > 0 {
            waiting -= 1;
            let (index, squared) = (stack[waiting].0 as usize, stack[waiting].1);
            if squared > bound * slack + self.rounding {
                left_out = if squared < left_out { squared } else { left_out };
                continue;
            }
            if 2 * index >= self.width() {
                let wanted = job(self.members(index));
                bound = if wanted < bound { wanted } else { bound };
                continue;
            }
            let child = |index: usize| (index as u32, self.squared(index, x));
            let (left, right) = (child(2 * index), child(2 * index + 1));
            let (near, far) = if right.1 < left.1 { (right, left) } else { (left, right) };
            stack[waiting] = far;
            stack[waiting + 1] = near;
            waiting += 2;
        }
        left_out
    }

    /// Triangles with a point within `within` [m²], and more.
    pub fn around(&self, x: [T; 3], within: T) -> Around<'_, T> {
        Around { tree: self, x, within }
    }

    /// Triangles whose boxes a segment may intersect.
    pub fn along(&self, [start, end]: [[T; 3]; 2]) -> Along<'_, T> {
        let half = T::from_f64(0.5);
        let middle = |i: usize| (start[i] + end[i]) * half;
        let reach = |i: usize| (end[i] - start[i]) * half;
        Along {
            tree: self,
            middle: [middle(0), middle(1), middle(2)],
            half: [reach(0), reach(1), reach(2)],
            lost: self.lost(),
        }
    }
}

/// The box around a triangle at all of some poses.
fn swept(poses: &[Vec<[f64; 3]>], triangle: &[u32; 3]) -> Bounds<f64> {
    boxes::around(poses.iter().flat_map(|pose| triangle.map(|node| pose[node as usize])))
}

/// See [`Tree::around`].
pub struct Around<'a, T> {
    tree: &'a Tree<T>,
    x: [T; 3],
    within: T,
}

impl<T: Real> Candidates<T> for Around<'_, T> {
    fn visit(&self, mut job: impl FnMut(u32)) {
        self.tree.visit_around(self.x, self.within, |triangles| {
            triangles.for_each(&mut job);
            self.within
        });
    }
}

/// See [`Tree::along`].
pub struct Along<'a, T> {
    tree: &'a Tree<T>,
    middle: [T; 3],
    /// Half the segment.
    half: [T; 3],
    lost: T,
}

impl<T: Real> Along<'_, T> {
    /// Whether the segment may intersect a box: no axis, and no cross product of an axis with it, separates the two
    /// (Ericson, "Real-Time Collision Detection", 2005, section 5.3.3).
    #[inline(always)]
    fn meets(&self, [lo, hi]: &Bounds<T>) -> bool {
        let (half, wide) = (T::from_f64(0.5), T::from_f64(0.5 * (1.0 + SLACK)));
        let d = self.half;
        let c = |i: usize| self.middle[i] - (lo[i] + hi[i]) * half;
        let e = |i: usize| (hi[i] - lo[i]) * wide + self.lost;
        // An empty box consists of infinities and intersects nothing.
        let along = |i: usize| c(i).abs() <= e(i) + d[i].abs();
        let across =
            |i: usize, j: usize| (c(i) * d[j] - c(j) * d[i]).abs() <= e(i) * d[j].abs() + e(j) * d[i].abs();
        along(0) & along(1) & along(2) && across(1, 2) & across(2, 0) & across(0, 1)
    }
}

impl<T: Real> Candidates<T> for Along<'_, T> {
    fn visit(&self, mut job: impl FnMut(u32)) {
        let tree = self.tree;
        let mut stack = [1_usize; 40];
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let index = stack[waiting];
            if !self.meets(&tree.boxes[index]) {
                continue;
            }
            if index >= tree.width() {
                tree.members(index).for_each(&mut job);
                continue;
            }
            stack[waiting] = 2 * index + 1;
            stack[waiting + 1] = 2 * index;
            waiting += 2;
        }
    }
}
