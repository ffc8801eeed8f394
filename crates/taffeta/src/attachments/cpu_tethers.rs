//! Tethers on the CPU: those of nodes without joints sixteen nodes at a time, others one by one, to the same bits.

use crate::attachments::attach::{self, Ball, HeldBack, PointState, ROUNDS};
use crate::attachments::tethers::MAX_TETHERS;
use crate::cpu::simd::Kernel;
use crate::real::Real;
use crate::topology::LANES;
use std::ops::Range;

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

/// The anchors of the first tethers of the nodes of a slice, or of the second ones and so on, by their numbers among all anchors.
#[derive(Clone, Copy, PartialEq)]
enum Anchors {
    /// One for all.
    Same(u32),
    /// Neighbours, from one on.
    Run(u32),
    /// Those of a list.
    Each(u32),
}

/// Slices of sixteen neighbours in a run of nodes, whose tethers have the same anchors.
pub struct Group {
    slices: Range<usize>,
    /// Most tethers of any node, and their anchors.
    most: usize,
    anchors: [Anchors; MAX_TETHERS],
    /// Where their lengths begin.
    lengths: usize,
    /// Solver index of the first node.
    pub first: usize,
}

/// Most slices of a group.
const GROUP: usize = 64;

/// The tethers of nodes without joints.
pub struct Tethers<T> {
    /// Groups of all tiles, and where those of each tile begin.
    groups: Vec<Group>,
    of_tile: Vec<usize>,
    /// Solver index of the first node of each slice.
    slices: Vec<u32>,
    /// By slice and tether: how far each node may be from its anchor [m]; infinite where it has none, or joints.
    lengths: Vec<Lengths<T>>,
    lists: Vec<[u32; LANES]>,
    /// Solver indices of all anchors, ascending.
    pub nodes: Vec<u32>,
}

/// On cache lines of their own.
#[repr(align(64))]
struct Lengths<T>([T; LANES]);

/// A node, and its tethers: anchors and lengths [m].
pub type Tethered<'a, T> = (u32, &'a [(u32, T)]);

impl<T: Real> Tethers<T> {
    /// Of tiles, each with the runs of its nodes and those of them that have tethers and no joints, ascending.
    pub fn new<'a>(tiles: impl Iterator<Item = (Vec<Range<usize>>, Vec<Tethered<'a, T>>)> + Clone) -> Self {
        let of_all = tiles.clone().flat_map(|(_, tethered)| tethered).flat_map(|(_, tethers)| tethers);
        let mut nodes: Vec<u32> = of_all.map(|(anchor, _)| *anchor).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let (groups, slices, lengths, lists) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut all = Self { groups, of_tile: vec![0], slices, lengths, lists, nodes };
        for (runs, tethered) in tiles {
            for run in runs {
                let known = all.groups.len();
                // Where cache lines begin, as far as the run reaches: slices may overlap, but each node has its tethers in one.
                for start in (run.start / LANES * LANES..run.end).step_by(LANES) {
                    let [from, to] = [start, start + LANES].map(|end| {
                        tethered.partition_point(|(node, _)| (*node as usize) < end.clamp(run.start, run.end))
                    });
                    let first = start.min(run.end.saturating_sub(LANES)).max(run.start);
                    all.add(first, &tethered[from..to], known);
                }
            }
            all.of_tile.push(all.groups.len());
        }
        all
    }

    /// Adds a slice, unless it has no tethers, to one of the groups from `known` on.
    fn add(&mut self, first: usize, tethered: &[Tethered<'_, T>], known: usize) {
        let most = tethered.iter().map(|(_, tethers)| tethers.len()).max().unwrap_or_default();
        if most == 0 {
            return;
        }
        let (slice, start) = (self.slices.len(), self.lengths.len());
        self.slices.push(first as u32);
        let mut all_anchors = [Anchors::Same(0); MAX_TETHERS];
        for (number, found) in all_anchors.iter_mut().enumerate().take(most) {
            let (mut anchors, mut lengths) = ([None; LANES], [T::from_f64(f64::INFINITY); LANES]);
            for (node, tethers) in tethered {
                if let Some((anchor, length)) = tethers.get(number) {
                    let lane = *node as usize - first;
                    anchors[lane] = self.nodes.binary_search(anchor).ok().map(|anchor| anchor as u32);
                    lengths[lane] = *length;
                }
            }
            *found = self.anchors(anchors);
            self.lengths.push(Lengths(lengths));
        }
        match self.groups[known..].last_mut() {
            Some(group)
                if (group.most, group.anchors) == (most, all_anchors) && group.slices.len() < GROUP =>
            {
                group.slices.end += 1;
            }
            _ => {
                let slices = slice..slice + 1;
                self.groups.push(Group { slices, most, anchors: all_anchors, lengths: start, first });
            }
        }
    }

    /// Nodes that have none get any, so that all may have the same, or neighbours.
    fn anchors(&mut self, anchors: [Option<u32>; LANES]) -> Anchors {
        let known = || (0..).zip(&anchors).filter_map(|(lane, anchor)| anchor.map(|anchor| (lane, anchor)));
        let Some((lane, any)) = known().next() else { return Anchors::Same(0) };
        if known().all(|(_, anchor)| anchor == any) {
            return Anchors::Same(any);
        }
        let end = self.nodes.len() as u32;
        match any.checked_sub(lane).filter(|&first| first + LANES as u32 <= end) {
            Some(first) if known().all(|(lane, anchor)| anchor == first + lane) => Anchors::Run(first),
            _ => {
                self.lists.push(anchors.map(|anchor| anchor.unwrap_or(any)));
                Anchors::Each(self.lists.len() as u32 - 1)
            }
        }
    }

    /// The groups of a tile.
    pub fn of_tile(&self, tile: usize) -> &[Group] {
        &self.groups[self.of_tile[tile]..self.of_tile[tile + 1]]
    }

    pub fn bytes(&self) -> usize {
        let groups = size_of_val(&self.groups[..]) + size_of_val(&self.of_tile[..]);
        let slices = size_of_val(&self.slices[..]) + size_of_val(&self.lengths[..]);
        groups + slices + size_of_val(&self.lists[..]) + size_of_val(&self.nodes[..])
    }

    /// Three columns of some anchors.
    #[inline(always)]
    fn three(&self, anchors: Anchors, columns: [&[T]; 3]) -> Three<T> {
        let mut three = [[T::ZERO; LANES]; 3];
        for (lanes, column) in three.iter_mut().zip(columns) {
            match anchors {
                Anchors::Same(anchor) => lanes.fill(column[anchor as usize]),
                Anchors::Run(first) => *lanes = lanes_at(column, first as usize),
                Anchors::Each(list) => {
                    for (lane, &anchor) in lanes.iter_mut().zip(&self.lists[list as usize]) {
                        *lane = column[anchor as usize];
                    }
                }
            }
        }
        three
    }
}

/// Moves the nodes of a run that their tethers hold back.
pub struct HoldBack<'a, T> {
    pub tethers: &'a Tethers<T>,
    /// Groups within the run.
    pub groups: &'a [Group],
    /// Solver index of the run's first node; at least [`LANES`] follow each other.
    pub start: usize,
    /// Their state after the sub-step, and inverse mass [1/kg].
    pub state: [&'a mut [T]; 6],
    pub inverse_mass: &'a [T],
    /// The state of all anchors.
    pub anchors: [&'a [T]; 6],
    pub h: T,
    /// Gets the nodes that are moved, and where they were [m]; if anybody wants to know.
    pub moved: Option<&'a mut Vec<(usize, [T; 3])>>,
}

impl<T: Real> Kernel for HoldBack<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        for group in self.groups {
            match group.most {
                0 | 1 => self.group::<1>(group),
                2 => self.group::<2>(group),
                3 => self.group::<3>(group),
                _ => self.group::<MAX_TETHERS>(group),
            }
        }
    }
}

impl<T: Real> HoldBack<'_, T> {
    /// First it finds which slices have nodes out of reach, without a branch that depends on it, which nobody could predict. Then it
    /// moves those.
    #[inline(always)]
    fn group<const N: usize>(&mut self, group: &Group) {
        let tethers = self.tethers;
        let firsts = &tethers.slices[group.slices.clone()];
        let (lengths, _) = tethers.lengths[group.lengths..].as_chunks::<N>();
        let [x, y, z, ..] = self.anchors;
        let centers: [Three<T>; N] =
            std::array::from_fn(|tether| tethers.three(group.anchors[tether], [x, y, z]));
        let (mut out, mut count) = ([0_u8; GROUP], 0);
        for (number, (&first, radii)) in (0..).zip(firsts.iter().zip(lengths)) {
            out[count] = number;
            count += usize::from(self.is_any_out(first as usize - self.start, &centers, radii));
        }
        if count == 0 {
            return;
        }
        let [.., u, v, w] = self.anchors;
        let with: [Three<T>; N] =
            std::array::from_fn(|tether| tethers.three(group.anchors[tether], [u, v, w]));
        for &number in &out[..count] {
            let number = usize::from(number);
            self.slice(firsts[number] as usize - self.start, &centers, &lengths[number], &with);
        }
    }

    /// Whether any free node is out of reach of one of its anchors: most of the time none is.
    #[inline(always)]
    fn is_any_out<const N: usize>(
        &self,
        at: usize,
        centers: &[Three<T>; N],
        radii: &[Lengths<T>; N],
    ) -> bool {
        let [x, y, z, ..] = &self.state;
        let (x, free) =
            ([lanes_at(x, at), lanes_at(y, at), lanes_at(z, at)], lanes_at(self.inverse_mass, at));
        let mut out = [T::ZERO; LANES];
        for lane in 0..LANES {
            for tether in 0..N {
                let ball = (lane_of(&centers[tether], lane), radii[tether].0[lane]);
                let excess = attach::excess(lane_of(&x, lane), ball);
                out[lane] = if excess > out[lane] { excess } else { out[lane] };
            }
            out[lane] = if free[lane] > T::ZERO { out[lane] } else { T::ZERO };
        }
        out.iter().fold(false, |any, &out| any | (out > T::ZERO))
    }

    /// Moves the nodes of a slice that are out of reach of an anchor.
    #[inline(always)]
    fn slice<const N: usize>(
        &mut self,
        at: usize,
        centers: &[Three<T>; N],
        lengths: &[Lengths<T>; N],
        with: &[Three<T>; N],
    ) {
        let [x, y, z, u, v, w] = &self.state;
        let from = [lanes_at(x, at), lanes_at(y, at), lanes_at(z, at)];
        let before = [lanes_at(u, at), lanes_at(v, at), lanes_at(w, at)];
        let mut nodes = Nodes {
            free: lanes_at(self.inverse_mass, at),
            centers: *centers,
            radii: std::array::from_fn(|tether| lengths[tether].0),
            x: from,
            shift: [[T::ZERO; LANES]; 3],
            taut: [[T::ZERO; LANES]; N],
        };
        if N < 3 {
            let (is_enough, after) = nodes.project_to_one(&before, with, self.h);
            if is_enough {
                self.put(at, &from, &after);
                return;
            }
        }
        let after = nodes.project(&before, with, self.h);
        self.put(at, &from, &after);
    }

    /// Stores the state of nodes that are moved.
    #[inline(always)]
    fn put(&mut self, at: usize, from: &Three<T>, (moved, state): &Moved<T>) {
        if let Some(all) = &mut self.moved {
            for lane in (0..LANES).filter(|&lane| moved[lane] > T::ZERO) {
                all.push((self.start + at + lane, lane_of(from, lane)));
            }
        }
        for (column, state) in self.state.iter_mut().zip(state) {
            column[at..at + LANES].copy_from_slice(state);
        }
    }
}

/// Three numbers of each node.
type Three<T> = [[T; LANES]; 3];

/// Which nodes of a slice are moved (1, else 0), and their state afterwards.
type Moved<T> = ([T; LANES], [[T; LANES]; 6]);

/// Sixteen numbers of a column.
#[inline(always)]
fn lanes_at<T: Real>(column: &[T], first: usize) -> [T; LANES] {
    let mut lanes = [T::ZERO; LANES];
    lanes.copy_from_slice(&column[first..first + LANES]);
    lanes
}

#[inline(always)]
fn lane_of<T: Real>(three: &Three<T>, lane: usize) -> [T; 3] {
    [three[0][lane], three[1][lane], three[2][lane]]
}

#[inline(always)]
fn put<T: Real>(three: &mut Three<T>, lane: usize, [x, y, z]: [T; 3]) {
    (three[0][lane], three[1][lane], three[2][lane]) = (x, y, z);
}

/// Nodes of a slice with up to `N` tethers each.
struct Nodes<T, const N: usize> {
    /// Greater than 0 for those that are free.
    free: [T; LANES],
    /// Centers and radii of their balls [m].
    centers: [Three<T>; N],
    radii: [[T; LANES]; N],
    /// Where they are, by how much they have been moved [m], and 1 for each tether that is taut.
    x: Three<T>,
    shift: Three<T>,
    taut: [[T; LANES]; N],
}

// Loops over nodes without branches, so that each becomes vector instructions.
impl<T: Real, const N: usize> Nodes<T, N> {
    #[inline(always)]
    fn ball(&self, tether: usize, lane: usize) -> Ball<T> {
        (lane_of(&self.centers[tether], lane), self.radii[tether][lane])
    }

    #[inline(always)]
    fn balls(&self, lane: usize) -> [Ball<T>; N] {
        std::array::from_fn(|tether| self.ball(tether, lane))
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, (x, shift, taut): HeldBack<T, N>) {
        put(&mut self.x, lane, x);
        put(&mut self.shift, lane, shift);
        for (all, taut) in self.taut.iter_mut().zip(&taut) {
            all[lane] = *taut;
        }
    }

    /// Moves nodes with one tether or two, if each of them is where it may be once it is within reach of one anchor: nearly all are.
    #[inline(always)]
    fn project_to_one(&self, before: &Three<T>, with: &[Three<T>; N], h: T) -> (bool, Moved<T>) {
        let (mut moved, mut after, mut needs_both) =
            ([T::ZERO; LANES], [[T::ZERO; LANES]; 6], [T::ZERO; LANES]);
        let other = N.min(2) - 1;
        for lane in 0..LANES {
            let (x, v) = (lane_of(&self.x, lane), lane_of(before, lane));
            let two = attach::by_excess(x, self.ball(0, lane), self.ball(other, lane));
            let (at, shift) = attach::project_to_sphere(x, two.first);
            let acts = (self.free[lane] > T::ZERO) & (two.excess[0] > T::ZERO);
            // Rounding only widens what `project_to_two` takes for inside.
            let is_inside = N == 1 || attach::excess(at, two.second) <= T::ZERO;
            needs_both[lane] = if acts & !is_inside { T::ONE } else { T::ZERO };
            let (mut own, own_other) = (lane_of(&with[0], lane), lane_of(&with[other], lane));
            for axis in 0..3 {
                own[axis] = if two.is_second { own_other[axis] } else { own[axis] };
            }
            let kept = attach::held_velocity(v, &(at, shift, [T::ONE]), &[two.first], &[own], h);
            let is_moved = acts & (differs(&at, &x) | differs(&kept, &v));
            moved[lane] = if is_moved { T::ONE } else { T::ZERO };
            for axis in 0..3 {
                after[axis][lane] = if is_moved { at[axis] } else { x[axis] };
                after[3 + axis][lane] = if is_moved { kept[axis] } else { v[axis] };
            }
        }
        let needs_both = needs_both.iter().fold(false, |any, &needs| any | (needs > T::ZERO));
        (!needs_both, (moved, after))
    }

    /// Moves nodes with any number of tethers.
    #[inline(always)]
    fn project(&mut self, before: &Three<T>, with: &[Three<T>; N], h: T) -> Moved<T> {
        let from = self.x;
        self.project_to_two();
        let mut rounds = if N > 2 { 0 } else { ROUNDS };
        while rounds < ROUNDS && self.project_in_turn() {
            rounds += 1;
        }
        self.velocities(&from, before, with, h)
    }

    /// Whether a node has more than two tethers.
    #[inline(always)]
    fn has_many(&self, lane: usize) -> bool {
        // `N > 2` in the index lets the compiler see that it is within.
        N > 2 && self.radii[N.min(3) - 1][lane] < T::from_f64(f64::INFINITY)
    }

    /// For free nodes that have not many tethers: those with one have an infinite second ball.
    #[inline(always)]
    fn project_to_two(&mut self) {
        for lane in 0..LANES {
            let (x, other) = (lane_of(&self.x, lane), N.min(2) - 1);
            let (position, shift, taut) =
                attach::project_to_two(x, self.ball(0, lane), self.ball(other, lane));
            let acts = (self.free[lane] > T::ZERO) & !self.has_many(lane);
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
    fn project_in_turn(&mut self) -> bool {
        let mut any = [T::ZERO; LANES];
        for (lane, any) in any.iter_mut().enumerate() {
            let balls = self.balls(lane);
            let taut = std::array::from_fn(|tether| self.taut[tether][lane]);
            let before = (lane_of(&self.x, lane), lane_of(&self.shift, lane), taut);
            let mut held = before;
            let moved = attach::project_in_turn(&mut held, &balls);
            let acts = (self.free[lane] > T::ZERO) & self.has_many(lane);
            for axis in 0..3 {
                held.0[axis] = if acts { held.0[axis] } else { before.0[axis] };
                held.1[axis] = if acts { held.1[axis] } else { before.1[axis] };
            }
            for tether in 0..N {
                held.2[tether] = if acts { held.2[tether] } else { before.2[tether] };
            }
            *any = if acts { moved } else { T::ZERO };
            self.put(lane, held);
        }
        any.iter().fold(false, |any, &moved| any | (moved > T::ZERO))
    }

    /// Which nodes have changed, and their state.
    #[inline(always)]
    fn velocities(&self, from: &Three<T>, before: &Three<T>, with: &[Three<T>; N], h: T) -> Moved<T> {
        let (mut moved, mut after) = ([T::ZERO; LANES], [[T::ZERO; LANES]; 6]);
        for lane in 0..LANES {
            let taut = std::array::from_fn(|tether| self.taut[tether][lane]);
            let held = (lane_of(&self.x, lane), lane_of(&self.shift, lane), taut);
            let with = std::array::from_fn(|tether| lane_of(&with[tether], lane));
            let (x, v) = (lane_of(from, lane), lane_of(before, lane));
            let kept = attach::held_velocity(v, &held, &self.balls(lane), &with, h);
            let is_moved = differs(&held.0, &x) | differs(&kept, &v);
            moved[lane] = if is_moved { T::ONE } else { T::ZERO };
            for axis in 0..3 {
                after[axis][lane] = if is_moved { held.0[axis] } else { x[axis] };
                after[3 + axis][lane] = if is_moved { kept[axis] } else { v[axis] };
            }
        }
        (moved, after)
    }
}

/// Whether any number does. Zero has no sign here.
#[inline(always)]
fn differs<T: Real>(a: &[T; 3], b: &[T; 3]) -> bool {
    (a[0] != b[0]) | (a[1] != b[1]) | (a[2] != b[2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu::simd::SimdLevel;

    /// A number from −1 to 1.
    fn some(n: usize) -> f32 {
        ((n as u32).wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 23) as f32 - 1.0
    }

    /// Seventy nodes, of which the last twenty are anchors, and tethers of the others, up to four each.
    type Case<T> = ([Vec<T>; 6], Vec<T>, Vec<(u32, Vec<(u32, T)>)>);

    fn case<T: Real>(number: usize) -> Case<T> {
        let number_of = |n: usize| T::from_f64(f64::from(some(n)));
        let state: [Vec<T>; 6] =
            std::array::from_fn(|axis| (0..70).map(|n| number_of(1000 * number + 70 * axis + n)).collect());
        let inverse_mass =
            (0..70).map(|n| if n % 13 == 5 || n >= 50 { T::ZERO } else { T::from_f64(1.5) }).collect();
        // One, two, three for all, then any number, then one or two.
        let count = |n: usize| match number {
            0..3 => number + 1,
            3..6 => (n * 7 + number) % (MAX_TETHERS + 1),
            _ => 1 + n % 7 % 2,
        };
        let tether = |n: usize, k: usize| match number {
            0 | 1 => (50 + k as u32, T::from_f64(0.9)),
            2 | 3 => ((50 + (n + 3 * k) % 10) as u32, T::from_f64(f64::from(0.2 + some(n + k).abs()))),
            // The same anchor twice: both are exceeded alike.
            4 => (50 + (k / 2) as u32, T::from_f64(0.7)),
            5 => ((50 + k) as u32, T::from_f64(f64::from(3.0 * some(n + 90 * k).abs()))),
            // Neighbouring anchors, of which the second is never out of reach.
            _ => ((50 + n % LANES + k) as u32, T::from_f64([0.9, 9.0][k])),
        };
        let tethers = (0..50).map(|n| (n as u32, (0..count(n)).map(|k| tether(n, k)).collect())).collect();
        (state, inverse_mass, tethers)
    }

    fn compare<T: Real>(number: usize, level: SimdLevel) {
        let (state, inverse_mass, tethers) = case::<T>(number);
        let all: Vec<Tethered<'_, T>> = tethers.iter().map(|(node, of)| (*node, &of[..])).collect();
        // Runs that neither begin nor end on a cache line.
        let runs = vec![0..21, 21..70];
        let tethers = Tethers::new(std::iter::once((runs.clone(), all.clone())));
        let anchors = state.each_ref().map(|column| -> Vec<T> {
            tethers.nodes.iter().map(|&anchor| column[anchor as usize]).collect()
        });
        let (mut after, mut moved, h) = (state.clone(), Vec::new(), T::from_f64(0.01));
        for run in runs {
            let [from, to] =
                [run.start, run.end].map(|end| tethers.of_tile(0).partition_point(|group| group.first < end));
            level.run(HoldBack {
                tethers: &tethers,
                groups: &tethers.of_tile(0)[from..to],
                start: run.start,
                state: after.each_mut().map(|column| &mut column[run.clone()]),
                inverse_mass: &inverse_mass[run.clone()],
                anchors: anchors.each_ref().map(|column| &column[..]),
                h,
                moved: Some(&mut moved),
            });
        }
        let at = |columns: &[Vec<T>; 6], n: usize| -> PointState<T> {
            let all: [T; 6] = std::array::from_fn(|axis| columns[axis][n]);
            ([all[0], all[1], all[2]], [all[3], all[4], all[5]])
        };
        let bits = |(x, v): PointState<T>| {
            let mut bytes = Vec::new();
            x.into_iter().chain(v).for_each(|number| number.bytes(&mut bytes));
            bytes
        };
        let mut expected_moved = Vec::new();
        for (node, &mass) in inverse_mass.iter().enumerate() {
            let own = all.get(node).map_or(&[][..], |(_, own)| own);
            let anchors: Vec<_> =
                own.iter().map(|&(anchor, length)| (at(&state, anchor as usize), length)).collect();
            let (before, free) = (at(&state, node), mass > T::ZERO);
            let expected = if free { hold_back(before, &anchors, h) } else { before };
            assert_eq!(bits(at(&after, node)), bits(expected), "node {node} of case {number} with {level}");
            expected_moved.extend((expected != before).then_some((node, before.0)));
        }
        assert_eq!(moved, expected_moved, "case {number} with {level}");
        assert!((10..48).contains(&moved.len()), "{} are moved in case {number}", moved.len());
    }

    #[test]
    fn sixteen_at_a_time_have_the_bits_of_one_at_a_time() {
        for (number, level) in
            (0..7).flat_map(|number| [(number, SimdLevel::Base), (number, SimdLevel::detect())])
        {
            compare::<f32>(number, level);
            compare::<f64>(number, level);
        }
    }
}
