//! Pairs sixteen at a time: where they are, and what the filter lets them do.

use crate::contact::triangles::closest::{EdgeEdge, Pair, VertexTriangle};
use crate::contact::triangles::filter::limits;
use crate::contact::triangles::surfaces::Kind;
use crate::cpu::simd::Kernel;
use crate::real::{Real, add, dot, scale, sub};
use crate::topology::LANES;

/// One number for each of sixteen pairs.
pub type Lanes<T> = [T; LANES];

/// Nodes of sixteen pairs by place.
pub type Places = [Lanes<u32>; 4];

/// The nodes of up to sixteen pairs; the last pair fills the lanes that are left.
pub fn gather<'a>(pairs: impl Iterator<Item = &'a [u32; 4]>) -> Places {
    let mut all = [[0; LANES]; 4];
    let mut count = 0;
    for nodes in pairs.take(LANES) {
        for node in 0..4 {
            all[node][count] = nodes[node];
        }
        count += 1;
    }
    for lanes in &mut all {
        let last = lanes[count.max(1) - 1];
        lanes[count..].fill(last);
    }
    all
}

/// Where sixteen pairs are.
#[derive(Clone, Copy, Debug)]
pub struct Seen<T> {
    /// As [`Closest`](crate::contact::triangles::closest::Closest) has them.
    pub weights: [Lanes<T>; 4],
    pub apart: [Lanes<T>; 3],
    /// Distance where the sub-step begins [m].
    pub distance: Lanes<T>,
    /// Distance along the same normal where it would end [m].
    pub then: Lanes<T>,
}

/// A vector for each node of the pairs.
type Vectors<T> = [[Lanes<T>; 3]; 4];

/// Three columns at nodes.
#[inline(always)]
fn fetch<T: Real>(columns: [&[T]; 3], nodes: &Places, all: &mut Vectors<T>) {
    for node in 0..4 {
        for axis in 0..3 {
            for lane in 0..LANES {
                let place = nodes[node][lane] as usize;
                debug_assert!(place < columns[axis].len());
                // SAFETY: nodes of pairs are places of the scene, of which every column has one.
                all[node][axis][lane] = unsafe { *columns[axis].get_unchecked(place) };
            }
        }
    }
}

/// The vectors of one lane.
#[inline(always)]
fn lane<T: Real>(all: &Vectors<T>, lane: usize) -> [[T; 3]; 4] {
    let one = |node: usize| [all[node][0][lane], all[node][1][lane], all[node][2][lane]];
    [one(0), one(1), one(2), one(3)]
}

/// The same, relative to the last.
#[inline(always)]
fn relative<T: Real>([a, b, c, d]: [[T; 3]; 4]) -> [[T; 3]; 4] {
    [sub(a, d), sub(b, d), sub(c, d), [T::ZERO; 3]]
}

/// Kernel: where pairs are.
pub struct See<'a, T> {
    /// The kind of the pairs.
    pub kind: Kind,
    /// Their nodes.
    pub nodes: &'a Places,
    /// Positions where the sub-step begins, and where it would end [m].
    pub before: [&'a [T]; 3],
    pub after: [&'a [T]; 3],
}

impl<T: Real> Kernel for See<'_, T> {
    type Output = Seen<T>;

    #[inline(always)]
    fn run(self) -> Seen<T> {
        match self.kind {
            Kind::VertexTriangle => self.see::<VertexTriangle>(),
            Kind::EdgeEdge => self.see::<EdgeEdge>(),
        }
    }
}

impl<T: Real> See<'_, T> {
    #[inline(always)]
    fn see<P: Pair>(self) -> Seen<T> {
        let mut before = [[[T::ZERO; LANES]; 3]; 4];
        let mut after = [[[T::ZERO; LANES]; 3]; 4];
        fetch(self.before, self.nodes, &mut before);
        fetch(self.after, self.nodes, &mut after);
        let mut seen = Seen {
            weights: [[T::ZERO; LANES]; 4],
            apart: [[T::ZERO; LANES]; 3],
            distance: [T::ZERO; LANES],
            then: [T::ZERO; LANES],
        };
        for at in 0..LANES {
            let found = P::closest(relative(lane(&before, at)));
            let distance = dot(found.apart, found.apart).sqrt();
            let by = T::ONE / if distance > T::TINY { distance } else { T::ONE };
            let ends = relative(lane(&after, at));
            let [w, u, v, _] = found.weights;
            let then = add(add(scale(ends[0], w), scale(ends[1], u)), scale(ends[2], v));
            for node in 0..4 {
                seen.weights[node][at] = found.weights[node];
            }
            for axis in 0..3 {
                seen.apart[axis][at] = found.apart[axis];
            }
            seen.distance[at] = distance;
            seen.then[at] = dot(then, scale(found.apart, by));
        }
        seen
    }
}

/// Kernel: distances of pairs [m].
pub struct Distances<'a, T> {
    /// As of [`See`].
    pub kind: Kind,
    pub nodes: &'a Places,
    /// Positions [m].
    pub x: [&'a [T]; 3],
}

impl<T: Real> Kernel for Distances<'_, T> {
    type Output = Lanes<T>;

    #[inline(always)]
    fn run(self) -> Lanes<T> {
        match self.kind {
            Kind::VertexTriangle => self.of::<VertexTriangle>(),
            Kind::EdgeEdge => self.of::<EdgeEdge>(),
        }
    }
}

impl<T: Real> Distances<'_, T> {
    #[inline(always)]
    fn of<P: Pair>(self) -> Lanes<T> {
        let mut x = [[[T::ZERO; LANES]; 3]; 4];
        fetch(self.x, self.nodes, &mut x);
        let mut all = [T::ZERO; LANES];
        for (at, distance) in all.iter_mut().enumerate() {
            let apart = P::closest(relative(lane(&x, at))).apart;
            *distance = dot(apart, apart).sqrt();
        }
        all
    }
}

/// Kernel: what the filter lets the nodes of pairs do.
pub struct Limit<'a, T> {
    /// As of [`See`].
    pub kind: Kind,
    pub nodes: &'a Places,
    pub before: [&'a [T]; 3],
    pub after: [&'a [T]; 3],
    /// Thickness of each pair [m].
    pub thickness: Lanes<T>,
    /// The largest coordinate [m].
    pub far: T,
    /// Whether all their nodes go all their way.
    pub together: bool,
    /// For each node the part of its motion, and between closest points the vector from the second side to the first [m].
    pub parts: &'a mut [Lanes<T>; 4],
    pub apart: &'a mut [Lanes<T>; 3],
}

impl<T: Real> Kernel for Limit<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        match self.kind {
            Kind::VertexTriangle => self.limit::<VertexTriangle>(),
            Kind::EdgeEdge => self.limit::<EdgeEdge>(),
        }
    }
}

impl<T: Real> Limit<'_, T> {
    #[inline(always)]
    fn limit<P: Pair>(self) {
        let mut before = [[[T::ZERO; LANES]; 3]; 4];
        let mut after = [[[T::ZERO; LANES]; 3]; 4];
        fetch(self.before, self.nodes, &mut before);
        fetch(self.after, self.nodes, &mut after);
        let Self { thickness, far, together, parts, apart: vectors, .. } = self;
        for at in 0..LANES {
            let (from, to) = (lane(&before, at), lane(&after, at));
            let moves = [sub(to[0], from[0]), sub(to[1], from[1]), sub(to[2], from[2]), sub(to[3], from[3])];
            let x = relative(from);
            let apart = P::closest(x).apart;
            let found = limits::<T, P>(x, moves, apart, (thickness[at], far), together);
            for (lanes, part) in parts.iter_mut().zip(found.parts) {
                lanes[at] = part;
            }
            for axis in 0..3 {
                vectors[axis][at] = apart[axis];
            }
        }
    }
}

/// Difference of two columns at a place.
#[inline(always)]
pub fn motion<T: Real>(before: [&[T]; 3], after: [&[T]; 3], place: usize) -> [T; 3] {
    let along = |axis: usize| after[axis][place] - before[axis][place];
    [along(0), along(1), along(2)]
}
