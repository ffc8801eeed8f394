//! Tethers on the CPU: those of nodes without joints sixteen nodes at a time, others one by one, to the same bits.

use crate::attachments::attach::{self, Ball, HeldBack, PointState, ROUNDS};
use crate::attachments::tethers::MAX_TETHERS;
use crate::cpu::simd::Kernel;
use crate::cpu::tile::Tile;
use crate::real::Real;
use crate::topology::LANES;

/// A node's anchor, with its state, and how far the node may be from it [m].
pub type Anchor<T> = (PointState<T>, T);

/// A free node after its tethers. Their anchors are pinned, and stay where they are.
///
/// With one tether or two it moves to the nearest point that they allow. More of them move it one after the other, in rounds.
pub fn hold_back<T: Real>((x, v): PointState<T>, anchors: &[Anchor<T>], h: T) -> PointState<T> {
    let (mut balls, mut with) = ([endless(); MAX_TETHERS], [[T::ZERO; 3]; MAX_TETHERS]);
    for ((ball, with), &((at, velocity), length)) in balls.iter_mut().zip(&mut with).zip(anchors) {
        (*ball, *with) = ((at, length), velocity);
    }
    let mut held = (x, [T::ZERO; 3], [T::ZERO; MAX_TETHERS]);
    if anchors.len() > 2 {
        for _ in 0..ROUNDS {
            if attach::project_in_turn(&mut held, &balls) <= T::ZERO {
                break;
            }
        }
    } else {
        let (position, shift, [first, second]) = attach::project_to_two(x, balls[0], balls[1]);
        (held.0, held.1) = (position, shift);
        [held.2[0], held.2[1]] = [first, second];
    }
    (held.0, attach::held_velocity(v, &held, &balls, &with, h))
}

/// A ball that holds nothing.
fn endless<T: Real>() -> Ball<T> {
    ([T::ZERO; 3], T::from_f64(f64::INFINITY))
}

/// The nodes of a slice, or their anchors.
enum Indices {
    /// Neighbours, from one on.
    Run(usize),
    /// One for all.
    Same(usize),
    Each([u32; LANES]),
}

impl Indices {
    fn new(indices: [u32; LANES]) -> Self {
        let [first, ..] = indices;
        if indices.iter().zip(first..).all(|(&index, next)| index == next) {
            return Self::Run(first as usize);
        }
        if indices == [first; LANES] { Self::Same(first as usize) } else { Self::Each(indices) }
    }

    /// Three columns at these indices.
    #[inline(always)]
    fn three<T: Real>(&self, columns: [&[T]; 3]) -> [[T; LANES]; 3] {
        let mut lanes = [[T::ZERO; LANES]; 3];
        for (lanes, column) in lanes.iter_mut().zip(columns) {
            match self {
                Self::Run(first) => lanes.copy_from_slice(&column[*first..*first + LANES]),
                Self::Same(index) => lanes.fill(column[*index]),
                Self::Each(indices) => {
                    for (lane, &index) in lanes.iter_mut().zip(indices) {
                        *lane = column[index as usize];
                    }
                }
            }
        }
        lanes
    }
}

/// Up to sixteen nodes that have tethers and no joints.
pub struct TetherSlice<T> {
    nodes: Indices,
    /// 1 for nodes that have more than two tethers, else 0.
    many: [T; LANES],
    /// The first tethers of all nodes, then the second ones: anchors, and how far nodes may be from them [m]; where a node has none,
    /// infinite.
    tethers: Vec<(Indices, [T; LANES])>,
}

impl<T: Real> TetherSlice<T> {
    /// Of nodes, each with its tethers, which are anchors and lengths; at least one, and at most [`LANES`].
    pub fn new(nodes: &[(u32, &[(u32, T)])]) -> Self {
        let endless = T::from_f64(f64::INFINITY);
        let last = nodes.len() - 1;
        let slot = |slot: usize| {
            // A node that has none has the anchor of one that has, so that all may have the same.
            let any =
                nodes.iter().find_map(|(_, tethers)| tethers.get(slot)).map_or(0, |(anchor, _)| *anchor);
            let of = |lane: usize| nodes.get(lane).and_then(|(_, tethers)| tethers.get(slot));
            let anchors = std::array::from_fn(|lane| of(lane).map_or(any, |(anchor, _)| *anchor));
            (
                Indices::new(anchors),
                std::array::from_fn(|lane| of(lane).map_or(endless, |(_, length)| *length)),
            )
        };
        let most = nodes.iter().map(|(_, tethers)| tethers.len()).max().unwrap_or_default();
        let many = |lane: usize| nodes.get(lane).is_some_and(|(_, tethers)| tethers.len() > 2);
        Self {
            nodes: Indices::new(std::array::from_fn(|lane| nodes[lane.min(last)].0)),
            many: std::array::from_fn(|lane| if many(lane) { T::ONE } else { T::ZERO }),
            tethers: (0..most).map(slot).collect(),
        }
    }

    pub fn bytes(&self) -> usize {
        size_of::<Self>() + size_of_val(&self.tethers[..])
    }
}

/// What tethers make of the nodes of a slice.
pub struct MovedSlice<T> {
    slice: usize,
    /// 1 for nodes that are moved, else 0.
    moved: [T; LANES],
    state: [[T; LANES]; 6],
}

impl<T: Real> MovedSlice<T> {
    /// Moves them.
    pub fn apply(&self, slices: &[TetherSlice<T>], tile: &mut Tile<'_, T>) {
        let nodes = &slices[self.slice].nodes;
        if let (Indices::Run(first), false) = (nodes, tile.has_contact()) {
            for (column, state) in tile.after(&(*first..*first + LANES)).into_iter().zip(&self.state) {
                for lane in 0..LANES {
                    column[lane] = if self.moved[lane] > T::ZERO { state[lane] } else { column[lane] };
                }
            }
            return;
        }
        let node = |lane: usize| match nodes {
            Indices::Run(first) => *first + lane,
            Indices::Same(node) => *node,
            Indices::Each(nodes) => nodes[lane] as usize,
        };
        let moved = (0..LANES).filter(|&lane| self.moved[lane] > T::ZERO);
        tile.move_nodes(moved.map(|lane| (node(lane), self.state.map(|column| column[lane]))));
    }
}

/// Finds which nodes of some slices their tethers hold back, from the state after the sub-step.
pub struct HoldBack<'a, T> {
    pub slices: &'a [TetherSlice<T>],
    /// Number of the first of them.
    pub first: usize,
    pub state: [&'a [T]; 6],
    pub inverse_mass: &'a [T],
    pub h: T,
    pub found: &'a mut Vec<MovedSlice<T>>,
}

/// Three numbers of each node.
type Three<T> = [[T; LANES]; 3];

/// Nodes of a slice with up to `N` tethers each.
struct Nodes<T, const N: usize> {
    /// Centers and radii of their balls [m].
    centers: [Three<T>; N],
    radii: [[T; LANES]; N],
    /// Where they are, by how much they have been moved [m], and 1 for each tether that is taut.
    x: Three<T>,
    shift: Three<T>,
    taut: [[T; LANES]; N],
}

impl<T: Real> Kernel for HoldBack<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        for (number, slice) in (self.first..).zip(self.slices) {
            let held = match slice.tethers.len() {
                0 | 1 => self.slice::<1>(slice),
                2 => self.slice::<2>(slice),
                3 => self.slice::<3>(slice),
                _ => self.slice::<MAX_TETHERS>(slice),
            };
            self.found.extend(held.map(|(moved, state)| MovedSlice { slice: number, moved, state }));
        }
    }
}

impl<T: Real> HoldBack<'_, T> {
    /// Which nodes of a slice are moved, and their states afterwards; if any is out of reach of an anchor.
    #[inline(always)]
    fn slice<const N: usize>(&mut self, slice: &TetherSlice<T>) -> Option<([T; LANES], [[T; LANES]; 6])> {
        let [x, y, z, u, v, w] = self.state;
        let from = slice.nodes.three([x, y, z]);
        let [free, ..] = slice.nodes.three([self.inverse_mass; 3]);
        let none = [[T::ZERO; LANES]; 3];
        let mut nodes = Nodes {
            centers: [none; N],
            radii: [[T::ZERO; LANES]; N],
            x: from,
            shift: none,
            taut: [[T::ZERO; LANES]; N],
        };
        let all = nodes.centers.iter_mut().zip(&mut nodes.radii).zip(&slice.tethers);
        for ((center, radius), (anchors, lengths)) in all {
            (*center, *radius) = (anchors.three([x, y, z]), *lengths);
        }
        if !nodes.is_any_out(&free) {
            return None;
        }
        nodes.project_to_two(&free, &slice.many);
        let mut rounds = if N > 2 { 0 } else { ROUNDS };
        while rounds < ROUNDS && nodes.project_in_turn(&free, &slice.many) {
            rounds += 1;
        }
        let mut with = [none; N];
        for (with, (anchors, _)) in with.iter_mut().zip(&slice.tethers) {
            *with = anchors.three([u, v, w]);
        }
        let before = slice.nodes.three([u, v, w]);
        let (moved, [u, v, w]) = nodes.velocities(&from, &before, &with, self.h);
        let [x, y, z] = nodes.x;
        Some((moved, [x, y, z, u, v, w]))
    }
}

#[inline(always)]
fn lane_of<T: Real>(three: &Three<T>, lane: usize) -> [T; 3] {
    [three[0][lane], three[1][lane], three[2][lane]]
}

#[inline(always)]
fn put<T: Real>(three: &mut Three<T>, lane: usize, [x, y, z]: [T; 3]) {
    (three[0][lane], three[1][lane], three[2][lane]) = (x, y, z);
}

// Loops over nodes without branches, so that each becomes vector instructions.
impl<T: Real, const N: usize> Nodes<T, N> {
    #[inline(always)]
    fn balls(&self, lane: usize) -> [Ball<T>; N] {
        std::array::from_fn(|tether| (lane_of(&self.centers[tether], lane), self.radii[tether][lane]))
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, (x, shift, taut): HeldBack<T, N>) {
        put(&mut self.x, lane, x);
        put(&mut self.shift, lane, shift);
        for (all, taut) in self.taut.iter_mut().zip(&taut) {
            all[lane] = *taut;
        }
    }

    /// Whether any free node is out of reach of one of its anchors: most of the time none is.
    #[inline(always)]
    fn is_any_out(&self, free: &[T; LANES]) -> bool {
        let mut out = [T::ZERO; LANES];
        for lane in 0..LANES {
            let x = lane_of(&self.x, lane);
            for tether in 0..N {
                let ball = (lane_of(&self.centers[tether], lane), self.radii[tether][lane]);
                let excess = attach::excess(x, ball);
                out[lane] = if excess > out[lane] { excess } else { out[lane] };
            }
            out[lane] = if free[lane] > T::ZERO { out[lane] } else { T::ZERO };
        }
        out.iter().fold(false, |any, &out| any | (out > T::ZERO))
    }

    /// For free nodes that have not many tethers: those with one have an infinite second ball.
    #[inline(always)]
    fn project_to_two(&mut self, free: &[T; LANES], many: &[T; LANES]) {
        let endless = T::from_f64(f64::INFINITY);
        for lane in 0..LANES {
            let (x, other) = (lane_of(&self.x, lane), N.min(2) - 1);
            let first = (lane_of(&self.centers[0], lane), self.radii[0][lane]);
            let radius = if N > 1 { self.radii[other][lane] } else { endless };
            let (position, shift, taut) =
                attach::project_to_two(x, first, (lane_of(&self.centers[other], lane), radius));
            let acts = (free[lane] > T::ZERO) & (many[lane] <= T::ZERO);
            for axis in 0..3 {
                self.x[axis][lane] = if acts { position[axis] } else { x[axis] };
                self.shift[axis][lane] = if acts { shift[axis] } else { T::ZERO };
            }
            for (all, taut) in self.taut.iter_mut().zip(&taut) {
                all[lane] = if acts { *taut } else { T::ZERO };
            }
        }
    }

    /// One round for free nodes that have many tethers. Returns whether any is moved.
    #[inline(always)]
    fn project_in_turn(&mut self, free: &[T; LANES], many: &[T; LANES]) -> bool {
        let mut any = [T::ZERO; LANES];
        for lane in 0..LANES {
            let balls = self.balls(lane);
            let taut = std::array::from_fn(|tether| self.taut[tether][lane]);
            let before = (lane_of(&self.x, lane), lane_of(&self.shift, lane), taut);
            let mut held = before;
            let moved = attach::project_in_turn(&mut held, &balls);
            let acts = (free[lane] > T::ZERO) & (many[lane] > T::ZERO);
            for axis in 0..3 {
                held.0[axis] = if acts { held.0[axis] } else { before.0[axis] };
                held.1[axis] = if acts { held.1[axis] } else { before.1[axis] };
            }
            for tether in 0..N {
                held.2[tether] = if acts { held.2[tether] } else { before.2[tether] };
            }
            any[lane] = if acts { moved } else { T::ZERO };
            self.put(lane, held);
        }
        any.iter().fold(false, |any, &moved| any | (moved > T::ZERO))
    }

    /// Velocities afterwards, and which nodes have changed.
    #[inline(always)]
    fn velocities(
        &self,
        from: &Three<T>,
        before: &Three<T>,
        with: &[Three<T>; N],
        h: T,
    ) -> ([T; LANES], Three<T>) {
        let (mut moved, mut after) = ([T::ZERO; LANES], *before);
        for lane in 0..LANES {
            let taut = std::array::from_fn(|tether| self.taut[tether][lane]);
            let held = (lane_of(&self.x, lane), lane_of(&self.shift, lane), taut);
            let with = std::array::from_fn(|tether| lane_of(&with[tether], lane));
            let v = lane_of(before, lane);
            let all = attach::held_velocity(v, &held, &self.balls(lane), &with, h);
            let mut differs = false;
            for axis in 0..3 {
                differs = differs | (all[axis] != v[axis]) | (held.0[axis] != from[axis][lane]);
            }
            put(&mut after, lane, all);
            moved[lane] = if differs { T::ONE } else { T::ZERO };
        }
        (moved, after)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu::simd::SimdLevel;

    /// A number from −1 to 1.
    fn some(n: usize) -> f32 {
        ((n as u32).wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 23) as f32 - 1.0
    }

    /// Sixty nodes, of which the last ten are anchors, and tethers of the others, up to four each.
    type Case<T> = ([Vec<T>; 6], Vec<T>, Vec<(u32, Vec<(u32, T)>)>);

    fn case<T: Real>(number: usize) -> Case<T> {
        let number_of = |n: usize| T::from_f64(f64::from(some(n)));
        let state: [Vec<T>; 6] =
            std::array::from_fn(|axis| (0..60).map(|n| number_of(1000 * number + 60 * axis + n)).collect());
        let inverse_mass =
            (0..60).map(|n| if n % 13 == 5 || n >= 50 { T::ZERO } else { T::from_f64(1.5) }).collect();
        // One, two, three for all, then any number.
        let count = |n: usize| if number < 3 { number + 1 } else { (n * 7 + number) % (MAX_TETHERS + 1) };
        let tether = |n: usize, k: usize| match number {
            0 | 1 => (50 + k as u32, T::from_f64(0.9)),
            2 | 3 => ((50 + (n + 3 * k) % 10) as u32, T::from_f64(f64::from(0.2 + some(n + k).abs()))),
            // The same anchor twice: both are exceeded alike.
            4 => (50 + (k / 2) as u32, T::from_f64(0.7)),
            _ => ((50 + k) as u32, T::from_f64(f64::from(3.0 * some(n + 90 * k).abs()))),
        };
        let tethers = (0..50).map(|n| (n as u32, (0..count(n)).map(|k| tether(n, k)).collect())).collect();
        (state, inverse_mass, tethers)
    }

    fn compare<T: Real>(number: usize, level: SimdLevel) {
        let (state, inverse_mass, tethers) = case::<T>(number);
        let all: Vec<(u32, &[(u32, T)])> = tethers.iter().map(|(node, of)| (*node, &of[..])).collect();
        let slices: Vec<_> = all.chunks(LANES).map(TetherSlice::new).collect();
        let columns = state.each_ref().map(|column| &column[..]);
        let (mut found, h) = (Vec::new(), T::from_f64(0.01));
        let first = 0;
        level.run(HoldBack {
            slices: &slices,
            first,
            state: columns,
            inverse_mass: &inverse_mass,
            h,
            found: &mut found,
        });
        let at = |n: usize| -> PointState<T> {
            let all: [T; 6] = std::array::from_fn(|axis| columns[axis][n]);
            ([all[0], all[1], all[2]], [all[3], all[4], all[5]])
        };
        let bits = |(x, v): PointState<T>| {
            let mut bytes = Vec::new();
            x.into_iter().chain(v).for_each(|number| number.bytes(&mut bytes));
            bytes
        };
        let mut moved = 0;
        for (node, tethers) in &all {
            let node = *node as usize;
            let anchors: Vec<_> =
                tethers.iter().map(|&(anchor, length)| (at(anchor as usize), length)).collect();
            let free = inverse_mass[node] > T::ZERO;
            let expected = if free { hold_back(at(node), &anchors, h) } else { at(node) };
            let lane = node % LANES;
            let of_slice = found.iter().find(|held: &&MovedSlice<T>| held.slice == node / LANES);
            let held = of_slice.filter(|held| held.moved[lane] > T::ZERO);
            let after = held.map_or(at(node), |held| {
                let all = held.state.map(|column| column[lane]);
                ([all[0], all[1], all[2]], [all[3], all[4], all[5]])
            });
            assert_eq!(bits(after), bits(expected), "node {node} of case {number} with {level}");
            moved += usize::from(held.is_some());
        }
        assert!((10..48).contains(&moved), "{moved} are moved in case {number}");
    }

    #[test]
    fn sixteen_at_a_time_have_the_bits_of_one_at_a_time() {
        for (number, level) in
            (0..6).flat_map(|number| [(number, SimdLevel::Base), (number, SimdLevel::detect())])
        {
            compare::<f32>(number, level);
            compare::<f64>(number, level);
        }
    }
}
