//! A tree of boxes over leaves of triangles, in a backend's numbers.

use crate::real::Real;

/// The lower and the upper corner of a box [m].
pub type Box3<T> = [[T; 3]; 2];

/// No box yet.
pub fn nowhere<T: Real>() -> Box3<T> {
    [[T::FAR; 3], [-T::FAR; 3]]
}

/// The box around a box and a point.
pub fn around<T: Real>([low, high]: Box3<T>, x: [T; 3]) -> Box3<T> {
    join([low, high], [x, x])
}

/// The box around two others.
pub fn join<T: Real>(a: Box3<T>, b: Box3<T>) -> Box3<T> {
    let least = |axis: usize| if a[0][axis] < b[0][axis] { a[0][axis] } else { b[0][axis] };
    let most = |axis: usize| if a[1][axis] > b[1][axis] { a[1][axis] } else { b[1][axis] };
    [std::array::from_fn(least), std::array::from_fn(most)]
}

/// Whether boxes are nearer than a distance along every axis.
#[inline(always)]
pub fn are_near<T: Real>(a: &Box3<T>, b: &Box3<T>, reach: T) -> bool {
    (0..3).all(|axis| a[0][axis] - b[1][axis] <= reach && b[0][axis] - a[1][axis] <= reach)
}

/// Box 1 is the root, 2i and 2i + 1 are the halves of box i, the leaves come last, a power of two of them.
pub struct Tree<T> {
    boxes: Vec<Box3<T>>,
    stack: Vec<u32>,
}

impl<T> Default for Tree<T> {
    fn default() -> Self {
        Self { boxes: Vec::new(), stack: Vec::new() }
    }
}

impl<T: Real> Tree<T> {
    /// Builds the tree over leaves.
    pub fn build(&mut self, leaves: &[Box3<T>]) {
        let width = leaves.len().next_power_of_two();
        self.boxes.clear();
        self.boxes.resize(width, nowhere());
        self.boxes.extend_from_slice(leaves);
        self.boxes.resize(2 * width, nowhere());
        for at in (1..width).rev() {
            self.boxes[at] = join(self.boxes[2 * at], self.boxes[2 * at + 1]);
        }
    }

    /// Calls `visit` with each leaf nearer than `reach` [m] to a box, ascending.
    pub fn near(&mut self, around: &Box3<T>, reach: T, mut visit: impl FnMut(usize)) {
        let width = self.boxes.len() / 2;
        self.stack.clear();
        self.stack.push(1);
        while let Some(at) = self.stack.pop() {
            if !are_near(around, &self.boxes[at as usize], reach) {
                continue;
            }
            if (at as usize) < width {
                self.stack.extend([2 * at + 1, 2 * at]);
            } else {
                visit(at as usize - width);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::random::SplitMix64;

    #[test]
    fn every_near_leaf_is_visited_once_in_order() {
        let mut random = SplitMix64::new(5);
        for leaves in [1, 2, 3, 37] {
            let mut tree = Tree::default();
            let boxes: Vec<Box3<f32>> = (0..leaves)
                .map(|_| {
                    let low = [0.0; 3].map(|_: f32| random.unit() as f32);
                    [low, low.map(|x| x + 0.1)]
                })
                .collect();
            tree.build(&boxes);
            for own in &boxes {
                let mut found = Vec::new();
                tree.near(own, 0.2, |leaf| found.push(leaf));
                let wanted: Vec<usize> =
                    (0..leaves).filter(|&leaf| are_near(own, &boxes[leaf], 0.2)).collect();
                assert_eq!(found, wanted);
            }
        }
    }
}
