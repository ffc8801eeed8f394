//! The narrow phase: the vertices and triangles, and the edges, of two leaves that are near each other.

use crate::contact::clusters::packed::{Packed, range};
use crate::contact::triangles::cpu::broad_phase::{LeafPair, Looked, Wanted};
use crate::contact::triangles::cpu::lanes::{Distances, Lanes, Places, gather};
use crate::contact::triangles::impulse::KEEPS;
use crate::contact::triangles::leaves::{EDGES, Leaf, Mask, Ring};
use crate::contact::triangles::order::{Candidate, Way};
use crate::contact::triangles::surfaces::{Kind, NEIGHBOURS, Surfaces};
use crate::cpu::simd::{Kernel, SimdLevel};
use crate::real::Real;
use crate::topology::LANES;

impl Candidate {
    /// The lanes of its nodes in its two leaves.
    fn lanes<'a>(&self, [a, b]: [&'a Leaf; 2]) -> [&'a [u8]; 2] {
        let [one, other] = [usize::from(self.one), usize::from(self.other)];
        match self.way {
            Way::VertexTriangle => [&a.vertices[one..=one], &b.triangles[other]],
            Way::TriangleVertex => [&a.triangles[one], &b.vertices[other..=other]],
            Way::EdgeEdge => [&a.edges[one], &b.edges[other]],
        }
    }

    /// Its nodes by place.
    pub fn nodes(&self, leaves: [&Leaf; 2]) -> [u32; 4] {
        let [one, other] = self.lanes(leaves);
        let place = |leaf: usize, lane: u8| leaves[leaf].nodes[usize::from(lane)];
        match self.way {
            Way::VertexTriangle => {
                [place(0, one[0]), place(1, other[0]), place(1, other[1]), place(1, other[2])]
            }
            Way::TriangleVertex => [place(1, other[0]), place(0, one[0]), place(0, one[1]), place(0, one[2])],
            Way::EdgeEdge => [place(0, one[0]), place(0, one[1]), place(1, other[0]), place(1, other[1])],
        }
    }

    /// Whether a mask has any pair of their nodes.
    #[inline]
    fn is_in(&self, mask: &Mask, leaves: [&Leaf; 2]) -> bool {
        let [one, other] = self.lanes(leaves);
        let rows = one.iter().fold(0, |rows, &lane| rows | mask[usize::from(lane)]);
        rows & bits(other) != 0
    }

    /// Whether they can hang together, or are a collider and pinned nodes: neither gives way. Pins that lag do, to each other.
    #[inline]
    fn is_none(&self, ring: Option<&Ring>, leaves: [&Leaf; 2], places: usize) -> bool {
        let is_collider = |leaf: &Leaf| leaf.nodes[0] as usize >= places;
        !self.gives_way(leaves) && leaves.into_iter().any(is_collider)
            || ring.is_some_and(|ring| self.is_in(&ring.same, leaves))
    }

    /// Whether any node of theirs is free.
    #[inline]
    pub fn gives_way(&self, leaves: [&Leaf; 2]) -> bool {
        let [one, other] = self.lanes(leaves);
        bits(one) & !leaves[0].held | bits(other) & !leaves[1].held != 0
    }
}

fn bits(lanes: &[u8]) -> u16 {
    lanes.iter().fold(0, |bits, lane| bits | 1 << lane)
}

/// Kernel: pairs of primitives of two leaves whose boxes are nearer than a distance.
pub struct Near<'a, T> {
    pub leaves: [&'a Leaf; 2],
    /// Whether they are one leaf.
    pub is_one: bool,
    pub packed: [&'a Packed<T>; 2],
    /// The distance [m].
    pub reach: T,
    /// Those that were found.
    pub found: &'a mut Vec<Candidate>,
}

/// The boxes of up to some primitives by axis, and their numbers. Lanes that are left are near nothing.
struct BoxList<T, const N: usize> {
    least: [[T; N]; 3],
    most: [[T; N]; 3],
    numbers: [u8; N],
    count: usize,
}

type Box3<T> = [[T; 3]; 2];

impl<T: Real, const N: usize> BoxList<T, N> {
    /// Those of some primitives, given by the lanes of their nodes, that are nearer to a box than `reach` [m].
    #[inline(always)]
    fn near<const K: usize>(
        primitives: &[[u8; K]],
        packed: &Packed<T>,
        around: &Box3<T>,
        (reach, beyond): (T, &mut T),
    ) -> Self {
        let mut all = Self { least: [[T::FAR; N]; 3], most: [[-T::FAR; N]; 3], numbers: [0; N], count: 0 };
        for (number, lanes) in primitives.iter().enumerate() {
            let mut of_one = [[T::ZERO; 3]; 2];
            let mut squared = T::ZERO;
            for axis in 0..3 {
                let x = packed.0[axis][usize::from(lanes[0])];
                let (mut low, mut high) = (x, x);
                for lane in lanes {
                    let x = packed.0[axis][usize::from(*lane)];
                    low = if x < low { x } else { low };
                    high = if x > high { x } else { high };
                }
                (of_one[0][axis], of_one[1][axis]) = (low, high);
                squared += square_of_gap(low, high, around[0][axis], around[1][axis]);
            }
            if squared < reach * reach {
                for (axis, (low, high)) in of_one[0].into_iter().zip(of_one[1]).enumerate() {
                    (all.least[axis][all.count], all.most[axis][all.count]) = (low, high);
                }
                all.numbers[all.count] = number as u8;
                all.count += 1;
            } else {
                *beyond = if squared < *beyond { squared } else { *beyond };
            }
        }
        all
    }

    /// Which of sixteen, from `first` on, are nearer to one of others than `reach` [m].
    #[inline(always)]
    fn around_one<const M: usize>(
        &self,
        first: usize,
        (others, one): (&BoxList<T, M>, usize),
        (reach, beyond): (T, &mut T),
    ) -> u32 {
        let mut squared = [T::ZERO; LANES];
        for axis in 0..3 {
            let (low, high) = (others.least[axis][one], others.most[axis][one]);
            for (lane, squared) in squared.iter_mut().enumerate() {
                let (least, most) = (self.least[axis][first + lane], self.most[axis][first + lane]);
                *squared += square_of_gap(least, most, low, high);
            }
        }
        let mut near = 0;
        let mut left = [T::FAR; LANES];
        for lane in 0..LANES {
            let is_near = squared[lane] < reach * reach;
            near |= u32::from(is_near) << lane;
            left[lane] = if is_near { T::FAR } else { squared[lane] };
        }
        let mut half = LANES / 2;
        while half > 0 {
            for lane in 0..half {
                left[lane] = if left[lane + half] < left[lane] { left[lane + half] } else { left[lane] };
            }
            half /= 2;
        }
        *beyond = if left[0] < *beyond { left[0] } else { *beyond };
        near
    }
}

/// The squared gap of two ranges [m²]; 0 if they overlap.
#[inline(always)]
fn square_of_gap<T: Real>(low: T, high: T, from: T, to: T) -> T {
    let (above, below) = (from - high, low - to);
    let gap = if above > below { above } else { below };
    let gap = if gap > T::ZERO { gap } else { T::ZERO };
    gap * gap
}

impl<T: Real> Kernel for Near<'_, T> {
    /// Least squared distance of the boxes of all others [m²].
    type Output = T;

    #[inline(always)]
    fn run(self) -> T {
        let Self { leaves: [a, b], is_one, packed: [of_a, of_b], reach, found } = self;
        let (box_a, box_b) = (box_of(of_a), box_of(of_b));
        let mut beyond = T::FAR;
        let edges_a: BoxList<T, 32> =
            BoxList::near(&a.edges[..a.counts[1].min(EDGES)], of_a, &box_b, (reach, &mut beyond));
        let edges_b: BoxList<T, 32> =
            BoxList::near(&b.edges[..b.counts[1].min(EDGES)], of_b, &box_a, (reach, &mut beyond));
        let triangles_a: BoxList<T, LANES> =
            BoxList::near(&a.triangles[..a.counts[0]], of_a, &box_b, (reach, &mut beyond));
        let triangles_b: BoxList<T, LANES> =
            BoxList::near(&b.triangles[..b.counts[0]], of_b, &box_a, (reach, &mut beyond));
        let (mut lanes_a, mut lanes_b) = ([[0]; LANES], [[0]; LANES]);
        for lane in 0..LANES {
            (lanes_a[lane], lanes_b[lane]) = ([a.vertices[lane]], [b.vertices[lane]]);
        }
        let vertices_a: BoxList<T, LANES> =
            BoxList::near(&lanes_a[..a.counts[2]], of_a, &box_b, (reach, &mut beyond));
        for one in 0..vertices_a.count {
            let near = triangles_b.around_one(0, (&vertices_a, one), (reach, &mut beyond));
            list(Way::VertexTriangle, near, (vertices_a.numbers[one], &triangles_b.numbers), found);
        }
        if !is_one {
            let vertices_b: BoxList<T, LANES> =
                BoxList::near(&lanes_b[..b.counts[2]], of_b, &box_a, (reach, &mut beyond));
            for one in 0..triangles_a.count {
                let near = vertices_b.around_one(0, (&triangles_a, one), (reach, &mut beyond));
                list(Way::TriangleVertex, near, (triangles_a.numbers[one], &vertices_b.numbers), found);
            }
        }
        for one in 0..edges_a.count {
            let number = edges_a.numbers[one];
            let mut first = 0;
            while first < edges_b.count {
                let mut near = edges_b.around_one(first, (&edges_a, one), (reach, &mut beyond));
                if is_one {
                    // Of two edges of one leaf only the later one: all are near, so their places are their numbers.
                    let from = (usize::from(number) + 1).saturating_sub(first).min(LANES);
                    near &= !((1 << from) - 1);
                }
                list(Way::EdgeEdge, near, (number, &edges_b.numbers[first..first + LANES]), found);
                first += LANES;
            }
        }
        beyond
    }
}

/// The box around a leaf.
#[inline(always)]
fn box_of<T: Real>(packed: &Packed<T>) -> Box3<T> {
    let mut all = [[T::ZERO; 3]; 2];
    for (axis, x) in packed.0.iter().enumerate() {
        [all[0][axis], all[1][axis]] = range(x);
    }
    all
}

#[inline(always)]
fn list(way: Way, mut near: u32, (one, others): (u8, &[u8]), found: &mut Vec<Candidate>) {
    while near != 0 {
        let other = others[near.trailing_zeros() as usize];
        near &= near - 1;
        found.push(Candidate { way, one, other });
    }
}

/// A pair of primitives that are near each other.
#[derive(Clone, Copy, Debug)]
pub struct Close<T> {
    /// Its nodes by place.
    pub nodes: [u32; 4],
    /// Its thickness [m].
    pub thickness: T,
    pub candidate: Candidate,
}

impl<T> Close<T> {
    /// Its kind.
    pub fn kind(&self) -> Kind {
        self.candidate.way.kind()
    }
}

/// Up to sixteen pairs of one kind.
#[derive(Clone, Copy, Debug)]
pub struct Sixteen<T> {
    pub kind: Kind,
    pub count: usize,
    /// Nodes of each; the last pair fills the lanes that are left.
    pub nodes: Places,
    pub thickness: Lanes<T>,
    /// Whether some came near when they were last looked at.
    pub any_close: bool,
    candidates: [Candidate; LANES],
}

impl<T: Real> Sixteen<T> {
    /// Of up to sixteen pairs of one kind, at least one.
    fn new(pairs: &[Close<T>]) -> Self {
        let Close { thickness, candidate, .. } = pairs[0];
        let mut all = Self {
            kind: candidate.way.kind(),
            count: pairs.len(),
            nodes: gather(pairs.iter().map(|close| &close.nodes)),
            thickness: [thickness; LANES],
            any_close: false,
            candidates: [candidate; LANES],
        };
        for (lane, close) in pairs.iter().enumerate() {
            (all.thickness[lane], all.candidates[lane]) = (close.thickness, close.candidate);
        }
        all
    }

    /// How far beyond contact pairs are that are so far apart [m].
    #[inline]
    pub fn left(&self, distances: Lanes<T>) -> [f64; LANES] {
        let mut left = [0.0; LANES];
        for (lane, left) in left.iter_mut().enumerate() {
            *left = distances[lane].to_f64() * (1.0 - 1e-5) - KEEPS * self.thickness[lane].to_f64();
        }
        left
    }

    /// One of the pairs.
    pub fn pair(&self, lane: usize) -> Close<T> {
        let nodes = self.nodes.map(|lanes| lanes[lane]);
        Close { nodes, thickness: self.thickness[lane], candidate: self.candidates[lane] }
    }
}

/// Pairs that are sorted by their kind, up to sixteen of one kind at a time.
pub fn by_sixteen<T: Real>(pairs: &[Close<T>]) -> impl Iterator<Item = Sixteen<T>> {
    let of_kinds = pairs.chunk_by(|a, b| a.kind() == b.kind());
    of_kinds.flat_map(|of_kind| of_kind.chunks(LANES)).map(Sixteen::new)
}

/// How many of these there are.
fn sixteens<T: Real>(pairs: &[Close<T>]) -> usize {
    pairs.chunk_by(|a, b| a.kind() == b.kind()).map(|of_kind| of_kind.len().div_ceil(LANES)).sum()
}

/// Memory for the pairs of two leaves.
pub struct Memory<T> {
    found: Vec<Candidate>,
    /// Those that may be near, and those that are.
    pub close: Vec<Close<T>>,
    pub kept: Vec<Close<T>>,
}

impl<T> Memory<T> {
    pub fn new() -> Self {
        Self { found: Vec::new(), close: Vec::new(), kept: Vec::new() }
    }
}

/// Two leaves that are looked at.
pub struct Look<'a, T> {
    pub leaves: [&'a Leaf; 2],
    pub is_one: bool,
    pub packed: [&'a Packed<T>; 2],
    /// What is known of their nodes, if anything.
    pub ring: Option<&'a Ring>,
    /// Thickness of their pairs that are no neighbours [m], and friction.
    pub thickness: T,
    pub friction: T,
    pub surfaces: &'a Surfaces,
    /// Positions at the start [m].
    pub start: [&'a [T]; 3],
    pub level: SimdLevel,
}

/// How far beyond contact pairs are listed, beside twice what the sub-step needs, relative to the mean edge. Lists that reach farther
/// serve more looks, but each of these takes longer, and so does the next list.
const LISTED: f64 = 0.15;

impl<'a, T: Real> Look<'a, T> {
    /// At two leaves, whose nodes are where `packed` has them and began at `start` [m].
    pub fn new(
        pair: &LeafPair<T>,
        surfaces: &'a Surfaces,
        (packed, start): (&'a [Packed<T>], [&'a [T]; 3]),
        level: SimdLevel,
    ) -> Self {
        let leaves = pair.leaves.map(|leaf| &surfaces.leaves[leaf as usize]);
        let [thickness, friction] =
            surfaces.material(leaves.map(|leaf| leaf.material)).unwrap_or_default().map(T::from_f64);
        Self {
            leaves,
            is_one: pair.leaves[0] == pair.leaves[1],
            packed: pair.leaves.map(|leaf| &packed[leaf as usize]),
            ring: (pair.ring > 0).then(|| surfaces.rings.ring(pair.ring)),
            thickness,
            friction,
            surfaces,
            start,
            level,
        }
    }

    /// Lists the pairs that are near contact again if others may have come near. `x` are all positions, and `edge` is the mean edge
    /// [m].
    pub fn renew(
        &self,
        pair: &mut LeafPair<T>,
        Wanted { needs, others }: Wanted,
        (x, edge): ([&[T]; 3], f64),
        memory: &mut Memory<T>,
    ) -> Looked {
        if others > needs {
            return Looked { nearest: others, others };
        }
        let (thickness, to) = (KEEPS * self.thickness.to_f64(), 2.0 * needs + LISTED * edge);
        let mut others = self.list(T::from_f64(thickness + to), memory) - thickness;
        let Memory { close, kept, .. } = memory;
        kept.clear();
        for sixteen in by_sixteen(close) {
            let (kind, nodes) = (sixteen.kind, &sixteen.nodes);
            let left = sixteen.left(self.level.run(Distances { kind, nodes, x }));
            for (lane, &left) in left[..sixteen.count].iter().enumerate() {
                if left < to {
                    kept.push(sixteen.pair(lane));
                } else {
                    others = others.min(left);
                }
            }
        }
        pair.list.clear();
        pair.list.reserve_exact(sixteens(kept));
        pair.list.extend(by_sixteen(kept));
        Looked { nearest: others, others }
    }

    /// Lists all pairs that are nearer than `reach` [m], and some that are not. Returns a bound of the distance of all others
    /// [m].
    pub fn list(&self, reach: T, Memory { found, close, .. }: &mut Memory<T>) -> f64 {
        let Self { leaves, is_one, packed, level, .. } = *self;
        found.clear();
        close.clear();
        let beyond = level.run(Near { leaves, is_one, packed, reach, found: &mut *found });
        found.retain(|one| !one.is_none(self.ring, leaves, self.surfaces.places));
        close.extend(found.iter().map(|&candidate| Close {
            nodes: candidate.nodes(leaves),
            thickness: self.thickness,
            candidate,
        }));
        if let Some(ring) = self.ring {
            self.measure_neighbours(ring, close);
        }
        beyond.sqrt().to_f64() * (1.0 - 1e-5)
    }

    /// Thickness of neighbours along the surface follows from their distance at the start.
    fn measure_neighbours(&self, ring: &Ring, close: &mut [Close<T>]) {
        let is_near = |close: &Close<T>| close.candidate.is_in(&ring.near, self.leaves);
        for of_kind in close.chunk_by_mut(|a, b| a.kind() == b.kind()) {
            for pairs in of_kind.chunks_mut(LANES).filter(|pairs| pairs.iter().any(is_near)) {
                let Sixteen { kind, nodes, .. } = Sixteen::new(pairs);
                let distances = self.level.run(Distances { kind, nodes: &nodes, x: self.start });
                for (close, distance) in pairs.iter_mut().zip(distances) {
                    let most = distance * T::from_f64(NEIGHBOURS);
                    if is_near(close) && most < close.thickness {
                        close.thickness = most;
                    }
                }
            }
        }
    }
}
