//! A tree of boxes over triangles: leaves of neighbours along a Hilbert curve, a complete binary tree above them (after
//! Lauterbach et al., "Fast BVH construction on GPUs", 2009, with equal leaves instead of splits).

use super::mesh::Candidates;
use crate::real::{Real, dot, sub};
use crate::topology::boxes::{LEAF, leaf_order};

/// The lower and the upper corner of a box [m].
type Bounds<T> = [[T; 3]; 2];

/// The tree. Box 1 is the root, 2i and 2i + 1 are the halves of box i; the leaves come last, four triangles each.
#[derive(Clone, Debug)]
pub struct Tree<T> {
    /// Box 0 is none.
    pub boxes: Vec<Bounds<T>>,
    /// Number of triangles.
    triangles: u32,
    /// Squared length that rounding may hide [m²].
    pub grain: T,
}

/// By how much more than what is wanted, relative to it, squared distances are looked at: boxes must not hide what rounding
/// brings near. With a length e that is lost, (d + e)² ≤ d² (1 + s) + e² (1 + 1/s).
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
            grain: T::from_f64(lost * lost / SLACK),
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
        let boxes = intervals.into_iter().map(|ends| around(ends, &ordered)).collect();
        (ordered, boxes)
    }

    /// Number of leaves, empty ones included: a power of two.
    fn width(&self) -> usize {
        self.boxes.len() / 2
    }

    /// Squared distance of a place from a box [m²].
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

    fn leaf(&self, index: usize) -> std::ops::Range<u32> {
        let first = ((index - self.width()) * LEAF) as u32;
        first..self.triangles.min(first + LEAF as u32)
    }

    /// What is lost of distances by rounding, at most [m].
    pub fn lost(&self) -> T {
        self.grain.sqrt()
    }

    /// Distance of a place from all triangles [m], at least, if that is more than they are across: no need to look at them.
    pub fn far_from(&self, x: [T; 3]) -> Option<T> {
        let [lo, hi] = self.boxes[1];
        let across = sub(hi, lo);
        let squared = self.squared(1, x);
        (squared > dot(across, across)).then(|| squared.sqrt() - self.lost())
    }

    /// Triangles around a place, nearer boxes first.
    pub fn around(&self, x: [T; 3]) -> Around<'_, T> {
        Around { tree: self, x }
    }

    /// Triangles whose boxes a way may meet.
    pub fn along(&self, way: [[T; 3]; 2]) -> Along<'_, T> {
        let [a, b] = way;
        let less = |i: usize| if a[i] < b[i] { a[i] } else { b[i] };
        let more = |i: usize| if a[i] < b[i] { b[i] } else { a[i] };
        Along { tree: self, bounds: [[0, 1, 2].map(less), [0, 1, 2].map(more)] }
    }
}

/// The boxes of triangles in their order, at all of some poses.
fn around(poses: &[Vec<[f64; 3]>], ordered: &[[u32; 3]]) -> Vec<Bounds<f64>> {
    const EMPTY: Bounds<f64> = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    let join = |a: Bounds<f64>, b: &Bounds<f64>| {
        [[0, 1, 2].map(|i| a[0][i].min(b[0][i])), [0, 1, 2].map(|i| a[1][i].max(b[1][i]))]
    };
    let width = ordered.len().div_ceil(LEAF).next_power_of_two();
    let mut boxes = vec![EMPTY; 2 * width];
    for (leaf, members) in boxes[width..].iter_mut().zip(ordered.chunks(LEAF)) {
        for node in members.iter().flatten() {
            for pose in poses {
                *leaf = join(*leaf, &[pose[*node as usize]; 2]);
            }
        }
    }
    for i in (1..width).rev() {
        boxes[i] = join(boxes[2 * i], &boxes[2 * i + 1]);
    }
    boxes
}

/// See [`Tree::around`].
pub struct Around<'a, T> {
    tree: &'a Tree<T>,
    x: [T; 3],
}

impl<T: Real> Candidates<T> for Around<'_, T> {
    fn visit(&self, mut job: impl FnMut(u32) -> T) {
        let (tree, slack) = (self.tree, T::from_f64(1.0 + SLACK));
        let mut bound = T::FAR;
        // One box a level waits, and the tree has less than 32 levels.
        let mut stack = [(0_usize, T::ZERO); 40];
        let mut waiting = 1;
        stack[0] = (1, tree.squared(1, self.x));
        while waiting > 0 {
            waiting -= 1;
            let (index, squared) = stack[waiting];
            if squared > bound * slack + tree.grain {
                continue;
            }
            if index >= tree.width() {
                for triangle in tree.leaf(index) {
                    bound = job(triangle);
                }
                continue;
            }
            let [left, right] = [2 * index, 2 * index + 1].map(|child| (child, tree.squared(child, self.x)));
            let (near, far) = if right.1 < left.1 { (right, left) } else { (left, right) };
            stack[waiting] = far;
            stack[waiting + 1] = near;
            waiting += 2;
        }
    }
}

/// See [`Tree::along`].
pub struct Along<'a, T> {
    tree: &'a Tree<T>,
    bounds: Bounds<T>,
}

impl<T: Real> Candidates<T> for Along<'_, T> {
    fn visit(&self, mut job: impl FnMut(u32) -> T) {
        let tree = self.tree;
        let [lo, hi] = self.bounds;
        let meets = |[from, to]: &Bounds<T>| (0..3).all(|i| from[i] <= hi[i] && lo[i] <= to[i]);
        let mut stack = [1_usize; 40];
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let index = stack[waiting];
            if !meets(&tree.boxes[index]) {
                continue;
            }
            if index >= tree.width() {
                tree.leaf(index).for_each(|triangle| {
                    job(triangle);
                });
                continue;
            }
            stack[waiting] = 2 * index + 1;
            stack[waiting + 1] = 2 * index;
            waiting += 2;
        }
    }
}
