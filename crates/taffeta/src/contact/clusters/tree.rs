//! A tree of boxes: boxes around groups of clusters, boxes around sixteen boxes, and so on. It finds the groups near
//! one group.
//!
//! Each worker has a tree of its own groups, whose shape follows from their number.

use crate::contact::clusters::packed::{GROUP, Packed};
use crate::cpu::simd::Kernel;
use crate::real::Real;
use crate::topology::LANES;
use std::ops::Range;

/// Sixteen boxes, by axis [m].
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Boxes<T> {
    least: [[T; LANES]; 3],
    most: [[T; LANES]; 3],
}

/// One box.
pub type Bound<T> = [[T; 3]; 2];

/// Where the boxes of a worker are.
#[derive(Clone, Debug)]
pub struct Tree {
    /// Its groups.
    pub groups: Range<usize>,
    /// Its boxes by level: of groups, of their sixteens, up to the last sixteen.
    levels: Vec<Range<usize>>,
    /// All of them.
    pub boxes: Range<usize>,
}

impl Tree {
    /// Of some groups; boxes begin at `first`.
    pub fn new(groups: Range<usize>, first: usize) -> Self {
        let (mut levels, mut count, mut next) = (Vec::new(), groups.len(), first);
        while count > 0 {
            let boxes = count.div_ceil(LANES);
            levels.push(next..next + boxes);
            next += boxes;
            count = if boxes > 1 { boxes } else { 0 };
        }
        Self { groups, levels, boxes: first..next }
    }

    /// Number of boxes at a level.
    fn count(&self, level: usize) -> usize {
        if level == 0 { self.groups.len() } else { self.levels[level - 1].len() }
    }

    /// The box of a group.
    pub fn bound<T: Real>(&self, boxes: &[Boxes<T>], group: usize) -> Bound<T> {
        let at = group - self.groups.start;
        boxes[self.levels[0].start + at / LANES].lane(at % LANES)
    }
}

impl<T: Real> Boxes<T> {
    /// Empty boxes: they are near nothing.
    pub fn empty() -> Self {
        Self { least: [[T::FAR; LANES]; 3], most: [[-T::FAR; LANES]; 3] }
    }

    /// The boxes of up to sixteen clusters.
    #[inline(always)]
    pub fn of(clusters: &[Packed<T>]) -> Self {
        let mut boxes = Self::empty();
        for (lane, cluster) in clusters.iter().enumerate() {
            for axis in 0..3 {
                let (mut least, mut most) = ([T::FAR; LANES], [-T::FAR; LANES]);
                // By halves, for vectors. A NaN is in no box.
                let mut half = LANES;
                for i in 0..LANES {
                    let x = cluster.0[axis][i];
                    least[i] = if x < least[i] { x } else { least[i] };
                    most[i] = if x > most[i] { x } else { most[i] };
                }
                while half > 1 {
                    half /= 2;
                    for i in 0..half {
                        least[i] = if least[i + half] < least[i] { least[i + half] } else { least[i] };
                        most[i] = if most[i + half] > most[i] { most[i + half] } else { most[i] };
                    }
                }
                (boxes.least[axis][lane], boxes.most[axis][lane]) = (least[0], most[0]);
            }
        }
        boxes
    }

    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Bound<T> {
        [self.least.map(|axis| axis[lane]), self.most.map(|axis| axis[lane])]
    }

    fn set(&mut self, lane: usize, [least, most]: Bound<T>) {
        for axis in 0..3 {
            (self.least[axis][lane], self.most[axis][lane]) = (least[axis], most[axis]);
        }
    }

    /// The box around all sixteen.
    #[inline(always)]
    fn about(&self) -> Bound<T> {
        let least = self.least.map(|axis| axis.into_iter().fold(T::FAR, |a, b| if b < a { b } else { a }));
        let most = self.most.map(|axis| axis.into_iter().fold(-T::FAR, |a, b| if b > a { b } else { a }));
        [least, most]
    }
}

/// Squared distance of two boxes [m²]; 0 if one of them is not finite.
#[inline(always)]
pub fn squared_distance<T: Real>(a: &Bound<T>, b: &Bound<T>) -> T {
    let mut sum = T::ZERO;
    for axis in 0..3 {
        let (above, below) = (b[0][axis] - a[1][axis], a[0][axis] - b[1][axis]);
        let gap = if above > below { above } else { below };
        let gap = if gap > T::ZERO { gap } else { T::ZERO };
        sum += gap * gap;
    }
    sum
}

/// Kernel: fills a worker's tree.
pub struct Fill<'a, T> {
    pub tree: &'a Tree,
    /// Its clusters, group by group.
    pub packed: &'a [Packed<T>],
    /// Its boxes.
    pub boxes: &'a mut [Boxes<T>],
}

impl<T: Real> Kernel for Fill<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { tree, packed, boxes } = self;
        boxes.fill(Boxes::empty());
        for (at, group) in packed.chunks(GROUP).enumerate() {
            boxes[at / LANES].set(at % LANES, Boxes::of(group).about());
        }
        let first = tree.boxes.start;
        for pair in tree.levels.windows(2) {
            for (at, below) in pair[0].clone().enumerate() {
                let about = boxes[below - first].about();
                boxes[pair[1].start - first + at / LANES].set(at % LANES, about);
            }
        }
    }
}

/// Kernel: finds the groups of a worker whose boxes are nearer to one than a distance.
pub struct Query<'a, T> {
    pub tree: &'a Tree,
    /// Those of all workers.
    pub boxes: &'a [Boxes<T>],
    /// The box to compare with.
    pub bound: &'a Bound<T>,
    /// The distance [m], squared.
    pub squared: T,
    /// Boxes yet to be looked into, by level and place: empty before and after.
    pub stack: &'a mut Vec<(usize, usize)>,
    /// The groups that were found.
    pub found: &'a mut Vec<u32>,
}

impl<T: Real> Kernel for Query<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { tree, boxes, bound, squared, stack, found } = self;
        stack.extend(tree.levels.len().checked_sub(1).map(|top| (top, 0)));
        while let Some((level, at)) = stack.pop() {
            let sixteen = &boxes[tree.levels[level].start + at];
            let mut near = 0_u32;
            for lane in 0..LANES {
                let is_near = squared_distance(bound, &sixteen.lane(lane)) < squared;
                near |= u32::from(is_near) << lane;
            }
            // A box that is infinitely wide is near nothing, too.
            near &= u32::MAX >> (32 - LANES.min(tree.count(level) - at * LANES));
            while near != 0 {
                let child = at * LANES + near.trailing_zeros() as usize;
                near &= near - 1;
                if level > 0 {
                    stack.push((level - 1, child));
                } else {
                    found.push((tree.groups.start + child) as u32);
                }
            }
        }
    }
}
