//! The broad phase: pairs of leaves whose triangles may come near each other.
//!
//! A search pairs groups of leaves up to a margin, which lasts until nodes anywhere have moved by it against each other. A
//! pair of groups lists its pairs of leaves that are near, and each pair of leaves is looked at when it may have come near
//! contact. So what is found does not depend on when a search was made.

use crate::contact::clusters::bounds::{Distances, GroupPair, approach, is_over};
use crate::contact::clusters::margin::{Margin, extent};
use crate::contact::clusters::packed::{GROUP, Packed, about, motion};
use crate::contact::clusters::tree::{Boxes, Fill, Query, Tree};
use crate::contact::triangles::cpu::narrow_phase::Sixteen;
use crate::contact::triangles::cpu::pose::{Pose, Then, weights};
use crate::contact::triangles::filter::{ALLOWANCE, reach_together};
use crate::contact::triangles::impulse::KEEPS;
use crate::contact::triangles::leaves::Leaf;
use crate::contact::triangles::surfaces::Surfaces;
use crate::cpu::numbers::Numbers;
use crate::cpu::shared::Shared;
use crate::cpu::simd::{Kernel, SimdLevel};
use crate::real::{Real, dot};
use crate::topology::LANES;
use crate::topology::boxes::{Bounds, NOWHERE, around, join};
use std::ops::Range;

/// Distance up to which leaves are listed, relative to the mean diagonal of a leaf.
const LISTED: f64 = 0.12;

/// What workers know of the leaves.
pub struct Leaves<T> {
    /// Mean diagonals of a leaf and of a group of bodies at the start [m].
    diagonals: [f64; 2],
    pub allowance: f64,
    trees: Vec<Tree>,
    /// Positions of the nodes of each leaf [m].
    packed: Shared<Packed<T>>,
    /// Weights of the nodes of each leaf that give its frame.
    weights: Vec<[[T; LANES]; 3]>,
    /// Their positions in their frames, and the frames.
    local: Shared<Packed<T>>,
    poses: Shared<Pose<T>>,
    /// Motion of each leaf's nodes in the sub-step to come, as [`motion`] defines it [m].
    steps: Shared<[f64; 4]>,
    /// Of each group: motion of its nodes since the last look, and in the sub-step to come [m].
    balls: Shared<[[f64; 4]; 2]>,
    /// The same of each worker's leaves.
    motion: Numbers<12>,
    boxes: Shared<Boxes<T>>,
}

/// A pair of leaves.
pub struct LeafPair<T> {
    /// The leaves, the second not before the first.
    pub leaves: [u32; 2],
    /// The number of what is known of their nodes.
    pub ring: u32,
    /// How far its pairs of primitives were from contact, and those that are not listed, when they were last looked at [m];
    /// and how the leaves were then.
    nearest: f64,
    others: f64,
    then: Then<T>,
    /// The motion of the groups at which it is looked at [m].
    due: f64,
    /// Pairs of primitives that are near contact.
    pub list: Vec<Sixteen<T>>,
}

/// What a look at two leaves is for.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// How far beyond contact pairs matter [m].
    pub needs: f64,
    /// How far those that are not listed are from contact, at least [m].
    pub others: f64,
}

/// What a look has found: how far pairs are from contact, and those that are not listed [m].
pub struct Looked {
    pub nearest: f64,
    pub others: f64,
}

impl Looked {
    /// Nothing is known: they must be looked at again.
    pub const AGAIN: Self = Self { nearest: 0.0, others: 0.0 };
}

/// What a worker knows of pairs of its leaves, and of those with later ones.
pub struct Pairs<T> {
    pub search: Margin,
    /// How much nearer pairs may come than nodes say, besides [m].
    pub extra: f64,
    groups: Vec<GroupPair<LeafPair<T>>>,
    around: Vec<u32>,
    stack: Vec<(usize, usize)>,
    squared: [[T; GROUP]; GROUP],
}

impl<T: Real> Pairs<T> {
    pub fn new() -> Self {
        Self {
            search: Margin::default(),
            extra: 0.0,
            groups: Vec::new(),
            around: Vec::new(),
            stack: Vec::new(),
            squared: [[T::ZERO; GROUP]; GROUP],
        }
    }

    /// Has the next sub-step search, and look at all.
    pub fn forget(&mut self) {
        self.search.forget();
        self.groups.clear();
    }

    /// Bytes that the lists take now.
    pub fn bytes(&self) -> usize {
        let of_pair = |pair: &LeafPair<T>| pair.list.capacity() * size_of::<Sixteen<T>>();
        let of_groups = |groups: &GroupPair<LeafPair<T>>| {
            groups.pairs.capacity() * size_of::<LeafPair<T>>()
                + groups.pairs.iter().map(of_pair).sum::<usize>()
        };
        size_of_val(&self.groups[..]) + self.groups.iter().map(of_groups).sum::<usize>()
    }
}

impl<T: Real> Leaves<T> {
    /// Those of surfaces, for so many workers.
    pub fn new(surfaces: &Surfaces, workers: usize) -> Self {
        let leaves = surfaces.leaves.len();
        let weights_of = |leaf: &Leaf| {
            weights(&leaf.own().iter().map(|&node| surfaces.start[node as usize]).collect::<Vec<_>>())
                .map(|row| row.map(T::from_f64))
        };
        let groups = leaves.div_ceil(GROUP);
        let mut trees: Vec<Tree> = Vec::new();
        for worker in 0..workers {
            let boxes = trees.last().map_or(0, |tree| tree.boxes.end);
            trees.push(Tree::new(groups * worker / workers..groups * (worker + 1) / workers, boxes));
        }
        let boxes = trees.last().map_or(0, |tree| tree.boxes.end);
        Self {
            diagonals: [1, GROUP].map(|count| mean_diagonal(surfaces, count)),
            allowance: ALLOWANCE * surfaces.mean_edge,
            trees,
            packed: vec![Packed([[T::ZERO; LANES]; 3]); leaves].into(),
            weights: surfaces.leaves.iter().map(weights_of).collect(),
            local: vec![Packed([[T::ZERO; LANES]; 3]); leaves].into(),
            poses: vec![Pose::NONE; leaves].into(),
            steps: vec![[0.0; 4]; leaves].into(),
            balls: vec![[[0.0; 4]; 2]; groups].into(),
            motion: Numbers::all(workers, flat([NOWHERE; 2])),
            boxes: vec![Boxes::empty(); boxes].into(),
        }
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        self.packed.bytes()
            + size_of_val(&self.weights[..])
            + self.local.bytes()
            + self.poses.bytes()
            + self.steps.bytes()
            + self.balls.bytes()
            + self.boxes.bytes()
    }

    /// Forgets how far nodes have moved: some may have been lost.
    pub fn forget(&mut self) {
        self.poses.get_mut().fill(Pose::NONE);
    }

    /// Number of leaves.
    fn len(&self) -> usize {
        self.packed.len()
    }

    /// The leaves of groups.
    fn leaves_of(&self, groups: Range<usize>) -> Range<usize> {
        groups.start * GROUP..self.len().min(groups.end * GROUP)
    }

    /// The worker of a leaf.
    pub fn worker_of(&self, leaf: usize) -> usize {
        self.trees.iter().position(|tree| tree.groups.contains(&(leaf / GROUP))).unwrap_or(0)
    }

    /// Positions of the nodes of leaves.
    pub fn packed(&self) -> &[Packed<T>] {
        // SAFETY: written before a barrier, and again after another.
        unsafe { self.packed.read() }
    }

    fn poses(&self) -> &[Pose<T>] {
        // SAFETY: as above.
        unsafe { self.poses.read() }
    }

    fn steps(&self) -> &[[f64; 4]] {
        // SAFETY: as above.
        unsafe { self.steps.read() }
    }

    /// The longest way of a node of two leaves in the sub-step to come [m].
    pub fn longest_way(&self, leaves: [u32; 2]) -> f64 {
        let steps = self.steps();
        let [a, b] = leaves.map(|leaf| {
            let [x, y, z, radius] = steps[leaf as usize];
            dot([x, y, z], [x, y, z]).sqrt() + radius
        });
        a.max(b)
    }

    /// Notes where the nodes of a worker's leaves are, and where they would go, [m] by place. Others may read it after the next
    /// barrier.
    pub fn follow(&self, worker: usize, surfaces: &Surfaces, columns: [[&[T]; 3]; 2], level: SimdLevel) {
        let groups = self.trees[worker].groups.clone();
        let own = self.leaves_of(groups.clone());
        let (leaves, weights) = (&surfaces.leaves[own.clone()], &self.weights[own.clone()]);
        let [before, after] = columns;
        // SAFETY: its own.
        let motion = unsafe {
            let (packed, local) = (self.packed.write(own.clone()), self.local.write(own.clone()));
            let poses = self.poses.write(own.clone());
            let (steps, balls) = (self.steps.write(own), self.balls.write(groups));
            level.run(Follow { leaves, weights, before, after, packed, local, poses, steps, balls })
        };
        self.motion.set(worker, flat(motion));
    }

    /// Makes sure that all pairs of groups are listed that may come into contact in the sub-step to come. All workers call it,
    /// after a barrier that follows [`Self::follow`]; `synchronise` is one.
    pub fn advance(
        &self,
        worker: usize,
        pairs: &mut Pairs<T>,
        surfaces: &Surfaces,
        level: SimdLevel,
        synchronise: impl Fn(),
    ) {
        // SAFETY: written before a barrier, and again after another.
        let balls = unsafe { self.balls.read() };
        let all = |which: usize| self.motion.iter().fold(NOWHERE, |all, one| join(all, bounds(&one, which)));
        pairs.search.add(all(0));
        for groups in &mut pairs.groups {
            let [a, b] = groups.groups.map(|group| balls[group as usize][0]);
            groups.travelled += approach(&a, &b);
        }
        let reach = reach_together(extent(all(1))) + self.allowance + pairs.extra;
        self.cover(worker, pairs, surfaces, (level, reach), synchronise);
    }

    /// Makes sure that all pairs of groups are listed that are nearer than `reach` [m] beyond contact, and keeps what is known of
    /// those that were. All workers call it.
    pub fn cover(
        &self,
        worker: usize,
        pairs: &mut Pairs<T>,
        surfaces: &Surfaces,
        (level, reach): (SimdLevel, f64),
        synchronise: impl Fn(),
    ) {
        if pairs.search.covers(reach) {
            return;
        }
        let widest = KEEPS * surfaces.thickest;
        pairs.search.choose(self.diagonals[1].max(widest), reach);
        let tree = &self.trees[worker];
        let own = self.leaves_of(tree.groups.clone());
        // SAFETY: its own; others read it after the next barrier, and it is written again after another.
        let boxes = unsafe { self.boxes.write(tree.boxes.clone()) };
        level.run(Fill { tree, packed: &self.packed()[own], boxes });
        synchronise();
        let mut old = std::mem::take(&mut pairs.groups).into_iter().peekable();
        let Pairs { groups, around, stack, search, .. } = pairs;
        // SAFETY: written before the barrier, and again after another.
        let boxes = unsafe { self.boxes.read() };
        let wide = T::from_f64(search.margin() + widest);
        for group in tree.groups.clone() {
            let bound = &tree.bound(boxes, group);
            around.clear();
            for tree in &self.trees[worker..] {
                level.run(Query { tree, boxes, bound, squared: wide * wide, stack, found: around });
            }
            around.retain(|&other| other as usize >= group);
            // Their order is that of the sums, whoever has found them.
            around.sort_unstable();
            for &other in around.iter() {
                let both = [group as u32, other];
                while old.next_if(|pair| pair.groups < both).is_some() {}
                let known = old.next_if(|pair| pair.groups == both);
                groups.push(known.unwrap_or_else(|| GroupPair::new(both, Vec::new())));
            }
        }
        // Nobody writes boxes again before all have read them.
        synchronise();
    }

    /// Calls `look` with each pair of leaves that may come into contact in the sub-step to come, ascending.
    pub fn each_due(
        &self,
        pairs: &mut Pairs<T>,
        surfaces: &Surfaces,
        level: SimdLevel,
        mut look: impl FnMut(&mut LeafPair<T>, Wanted) -> Looked,
    ) {
        // SAFETY: written before a barrier, and again after another.
        let balls = unsafe { self.balls.read() };
        let (steps, poses) = (self.steps(), self.poses());
        let mut all = std::mem::take(&mut pairs.groups);
        for groups in &mut all {
            let [a, b] = groups.groups.map(|group| balls[group as usize][1]);
            let needs = self.needs(&a, &b) + pairs.extra;
            if !is_over(groups.travelled + needs, groups.due) {
                continue;
            }
            if is_over(groups.travelled + needs, groups.fresh) {
                self.list(groups, pairs, surfaces, (level, needs));
            }
            let travelled = groups.travelled;
            groups.due = groups.fresh;
            for pair in &mut groups.pairs {
                if is_over(travelled + needs, pair.due) {
                    let [a, b] = pair.leaves.map(|leaf| &poses[leaf as usize]);
                    let changed = pair.then.changed(a, b);
                    let left = pair.nearest - changed;
                    let [of_a, of_b] = pair.leaves.map(|leaf| &steps[leaf as usize]);
                    let needs = self.needs(of_a, of_b) + pairs.extra;
                    if left > needs {
                        pair.due = travelled + left;
                    } else {
                        let looked = look(pair, Wanted { needs, others: pair.others - changed });
                        (pair.nearest, pair.others) = (looked.nearest, looked.others);
                        pair.then = Then::new(a, b);
                        pair.due = travelled + pair.nearest;
                    }
                }
                groups.due = if pair.due < groups.due { pair.due } else { groups.due };
            }
        }
        pairs.groups = all;
    }

    /// How far beyond contact pairs of triangles matter, in the sub-step to come, whose nodes move as two balls say [m].
    fn needs(&self, a: &[f64; 4], b: &[f64; 4]) -> f64 {
        reach_together(approach(a, b)) + self.allowance
    }

    /// Calls `look` with each pair of leaves, one of which has a mark, that may be nearer than `reach` [m].
    pub fn each_marked(
        &self,
        pairs: &mut Pairs<T>,
        surfaces: &Surfaces,
        (level, reach): (SimdLevel, f64),
        is_marked: impl Fn(usize) -> bool,
        mut look: impl FnMut(&LeafPair<T>),
    ) {
        let poses = self.poses();
        let mut all = std::mem::take(&mut pairs.groups);
        for groups in &mut all {
            let [a, b] = groups.groups.map(|group| {
                let group = group as usize;
                self.leaves_of(group..group + 1).any(&is_marked)
            });
            if !a && !b {
                continue;
            }
            if is_over(groups.travelled + reach, groups.fresh) {
                self.list(groups, pairs, surfaces, (level, reach));
            }
            for pair in &groups.pairs {
                let [a, b] = pair.leaves;
                let left = pair.nearest - pair.then.changed(&poses[a as usize], &poses[b as usize]);
                if (is_marked(a as usize) || is_marked(b as usize)) && is_over(reach, left) {
                    look(pair);
                }
            }
        }
        pairs.groups = all;
    }

    /// Lists the leaves of two groups that are near each other.
    fn list(
        &self,
        groups: &mut GroupPair<LeafPair<T>>,
        pairs: &mut Pairs<T>,
        surfaces: &Surfaces,
        (level, reach): (SimdLevel, f64),
    ) {
        let [first, second] = groups.groups.map(|group| self.leaves_of(group as usize..group as usize + 1));
        let packed = self.packed();
        let squared = &mut pairs.squared;
        level.run(Distances { packed: [&packed[first.clone()], &packed[second.clone()]], squared });
        let poses = self.poses();
        let widest = KEEPS * surfaces.thickest;
        let wide = T::from_f64(widest + LISTED * self.diagonals[0] + reach);
        let (near, mut beyond) = (wide * wide, T::FAR);
        let mut known = std::mem::take(&mut groups.pairs).into_iter().peekable();
        for (a, squared) in first.zip(&pairs.squared) {
            for (b, &squared) in second.clone().zip(squared).filter(|(b, _)| *b >= a) {
                if squared >= near {
                    beyond = if squared < beyond { squared } else { beyond };
                    continue;
                }
                let both = [a as u32, b as u32];
                while known.next_if(|pair| pair.leaves < both).is_some() {}
                if let Some(pair) = known.next_if(|pair| pair.leaves == both) {
                    groups.pairs.push(pair);
                    continue;
                }
                let materials = [a, b].map(|leaf| surfaces.leaves[leaf].material);
                let Some([thickness, _]) = surfaces.material(materials) else { continue };
                let gap = (squared.sqrt().to_f64() * (1.0 - 1e-5) - KEEPS * thickness).max(0.0);
                groups.pairs.push(LeafPair {
                    leaves: both,
                    ring: surfaces.rings.find(a, b as u32),
                    nearest: gap,
                    others: gap,
                    then: Then::new(&poses[a], &poses[b]),
                    due: groups.travelled + gap,
                    list: Vec::new(),
                });
            }
        }
        groups.fresh = groups.travelled + beyond.sqrt().to_f64() * (1.0 - 1e-5) - widest;
    }
}

/// Bounds as a row of numbers.
fn flat([first, second]: [Bounds; 2]) -> [f64; 12] {
    let numbers = [first, second];
    std::array::from_fn(|at| numbers[at / 6][at / 3 % 2][at % 3])
}

/// One of the two bounds in such a row.
fn bounds(row: &[f64; 12], which: usize) -> Bounds {
    std::array::from_fn(|end| std::array::from_fn(|axis| row[6 * which + 3 * end + axis]))
}

/// Mean diagonal of the boxes around so many leaves of bodies at the start [m].
fn mean_diagonal(surfaces: &Surfaces, count: usize) -> f64 {
    let soft: Vec<&Leaf> =
        surfaces.leaves.iter().filter(|leaf| (leaf.nodes[0] as usize) < surfaces.places).collect();
    let diagonals = soft.chunks(count).map(|leaves| {
        let of_one = leaves.iter().filter(|leaf| leaf.material == leaves[0].material);
        extent(around(of_one.flat_map(|leaf| leaf.own()).map(|&node| surfaces.start[node as usize])))
    });
    let (sum, number) = diagonals.fold((0.0, 0_u32), |(sum, number), one| (sum + one, number + 1));
    sum / f64::from(number.max(1))
}

/// Kernel: where the nodes of leaves are, and how they move.
struct Follow<'a, T> {
    leaves: &'a [Leaf],
    weights: &'a [[[T; LANES]; 3]],
    before: [&'a [T]; 3],
    after: [&'a [T]; 3],
    packed: &'a mut [Packed<T>],
    local: &'a mut [Packed<T>],
    poses: &'a mut [Pose<T>],
    steps: &'a mut [[f64; 4]],
    balls: &'a mut [[[f64; 4]; 2]],
}

impl<T: Real> Kernel for Follow<'_, T> {
    /// Bounds of the motion of all nodes since the last look, and in the sub-step to come.
    type Output = [Bounds; 2];

    #[inline(always)]
    fn run(self) -> [Bounds; 2] {
        let mut all = [NOWHERE; 2];
        for (group, ball) in self.balls.iter_mut().enumerate() {
            let first = group * GROUP;
            let end = self.leaves.len().min(first + GROUP);
            let (mut motions, mut bounds) = ([[[0.0; 4]; GROUP]; 2], [NOWHERE; 2]);
            for leaf in first..end {
                let now = gather(&self.leaves[leaf].nodes, self.before);
                let then = gather(&self.leaves[leaf].nodes, self.after);
                let by = motion(&now, &self.packed[leaf].0, LANES);
                self.packed[leaf].0 = now;
                self.poses[leaf].follow(&now, &by, &self.weights[leaf], &mut self.local[leaf].0);
                let step = motion(&then, &now, LANES);
                self.steps[leaf] = step;
                motions[0][leaf - first] = by;
                motions[1][leaf - first] = step;
                widen(&mut bounds[0], &by);
                widen(&mut bounds[1], &step);
            }
            for which in 0..2 {
                let [least, most] = bounds[which];
                ball[which] = about(&motions[which][..end - first], least, most);
                for axis in 0..3 {
                    let low = &mut all[which][0][axis];
                    *low = if least[axis] < *low { least[axis] } else { *low };
                    let high = &mut all[which][1][axis];
                    *high = if most[axis] > *high { most[axis] } else { *high };
                }
            }
        }
        all
    }
}

/// The bounds around a ball too.
#[inline(always)]
fn widen(bounds: &mut Bounds, ball: &[f64; 4]) {
    for axis in 0..3 {
        let (low, high) = (ball[axis] - ball[3], ball[axis] + ball[3]);
        bounds[0][axis] = if low < bounds[0][axis] { low } else { bounds[0][axis] };
        bounds[1][axis] = if high > bounds[1][axis] { high } else { bounds[1][axis] };
    }
}

/// Three columns at nodes.
#[inline(always)]
fn gather<T: Real>(nodes: &[u32; LANES], columns: [&[T]; 3]) -> [[T; LANES]; 3] {
    let mut all = [[T::ZERO; LANES]; 3];
    for axis in 0..3 {
        for lane in 0..LANES {
            let place = nodes[lane] as usize;
            debug_assert!(place < columns[axis].len());
            // SAFETY: nodes of leaves are places of the scene, of which every column has one.
            all[axis][lane] = unsafe { *columns[axis].get_unchecked(place) };
        }
    }
    all
}
