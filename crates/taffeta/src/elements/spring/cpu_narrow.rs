//! Springs of a narrow grid, by blocks of whole rows: as by [`super::cpu_grid`], but a vector goes on from one row to the next.
//!
//! In a row of 20 nodes a vector of 16 would be half empty, and what a row costs beside its springs would be most of all. So the rows of a
//! block count as one line of nodes. A spring of a direction ends a fixed number of nodes further on; those that would leave their row
//! are left out by a mask. Each spring and each node's sum are computed as there, to the bit.

use crate::cpu::column::Column;
use crate::cpu::simd::{Kernel, SimdLevel};
use crate::cpu::tiles::TILE_NODES;
use crate::elements::spring::cpu_grid::{GridSprings, any_beyond, springs_in_line};
use crate::elements::spring::stencil::GRID_STEPS as STEPS;
use crate::real::Real;
use crate::topology::LANES;
use std::ops::Range;

/// Most columns of a narrow grid: wider ones lose little in rows.
pub const NARROW: usize = 112;

/// Springs that stay in their rows: 1 for those, by number of the node, for as many nodes as a block has.
pub struct Masks<T> {
    /// By [`mask_of`].
    masks: [Column<T>; 3],
}

/// Which mask a step across columns has: none where it stays in its column.
const fn mask_of(across: isize) -> Option<usize> {
    match across {
        1 => Some(0),
        2 => Some(1),
        -1 => Some(2),
        _ => None,
    }
}

impl<T: Real> Masks<T> {
    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        self.masks.iter().map(|mask| size_of_val(&mask[..])).sum()
    }

    /// For a grid of so many columns, and blocks of up to so many nodes.
    pub fn new(cols: usize, nodes: usize) -> Self {
        let mask = |across: isize| {
            let mut mask = Column::zeros(nodes.next_multiple_of(LANES));
            for (node, stays) in mask.iter_mut().enumerate() {
                let end = (node % cols).checked_add_signed(across);
                *stays = if end.is_some_and(|end| end < cols) { T::ONE } else { T::ZERO };
            }
            mask
        };
        Self { masks: [1, 2, -1].map(mask) }
    }
}

/// A worker's sweep over the blocks of narrow grids.
///
/// A line for each direction and axis: the forces of the springs of up to two rows before a block, then those of its own.
pub struct NarrowSweep<T> {
    forces: Column<T>,
    line: usize,
    /// Squared limit of the stretch, if any, and squared lengths of springs [m²].
    limit: Option<T>,
    squares: Column<T>,
    /// What may come next without starting again: (body, row); whether a spring of the two rows before is beyond the limit, and
    /// whether there are forces of rows before.
    next: Option<(usize, usize)>,
    beyond_before: bool,
    has_before: bool,
}

// Two rows before a block are in the block before it.
const _: () = assert!(TILE_NODES >= 2 * NARROW);

/// Room for two rows, in whole vectors.
const BEFORE: usize = (2 * NARROW + LANES).next_multiple_of(LANES);

impl<T: Real> NarrowSweep<T> {
    /// For blocks of up to so many nodes; watches for springs longer than a multiple of their rest length.
    pub fn new(nodes: usize, limit: Option<T>) -> Self {
        let line = BEFORE + nodes.next_multiple_of(LANES) + LANES;
        let limit = limit.map(|stretch| stretch * stretch);
        let squares = Column::zeros(if limit.is_some() { line } else { 0 });
        Self {
            forces: Column::zeros(line * 3 * STEPS.len()),
            line,
            limit,
            squares,
            next: None,
            beyond_before: false,
            has_before: false,
        }
    }

    /// Forgets the rows before: the state has changed.
    pub fn restart(&mut self) {
        self.next = None;
    }

    /// Adds to `force` [N] the springs of the nodes in `rows`; `old` is the state (position and velocity by axis) from the body's
    /// first node on. Returns whether one of these springs, or one of the two rows before, is longer than watched for.
    pub fn springs(
        &mut self,
        level: SimdLevel,
        (body, grid, masks): (usize, &GridSprings<T>, &Masks<T>),
        rows: Range<usize>,
        old: [&[T]; 6],
        force: &mut [Column<T>; 3],
    ) -> bool {
        if self.next != Some((body, rows.start)) {
            self.forget_before();
            let before = rows.start.saturating_sub(2)..rows.start;
            if !before.is_empty() {
                let at = BEFORE - before.len() * grid.cols;
                let job = Block { sweep: self, grid, masks, rows: before.clone(), at, old, force: None };
                let [all, _] = job.run_at(level);
                self.beyond_before = all;
                self.has_before = true;
            }
        }
        let nodes = rows.len() * grid.cols;
        let [x, y, z] = force.each_mut().map(|column| &mut column[..nodes]);
        let job =
            Block { sweep: self, grid, masks, rows: rows.clone(), at: BEFORE, old, force: Some([x, y, z]) };
        let [all, last] = job.run_at(level);
        let beyond = all || self.beyond_before;
        self.keep_last((body, grid), &rows, last);
        beyond
    }

    /// There are no springs of rows before.
    fn forget_before(&mut self) {
        if self.has_before {
            for line in self.forces.chunks_exact_mut(self.line) {
                line[..BEFORE].fill(T::ZERO);
            }
        }
        (self.has_before, self.beyond_before) = (false, false);
    }

    /// Has the last rows of a block be those before the next.
    fn keep_last(&mut self, (body, grid): (usize, &GridSprings<T>), rows: &Range<usize>, beyond: bool) {
        self.next = (rows.end < grid.rows).then_some((body, rows.end));
        if self.next.is_none() {
            return;
        }
        let nodes = rows.len() * grid.cols;
        for (direction, (down, _)) in STEPS.into_iter().enumerate() {
            let kept = (down * grid.cols + LANES).min(BEFORE);
            for axis in 0..3 {
                let line = (3 * direction + axis) * self.line;
                let end = line + BEFORE + nodes;
                self.forces.copy_within(end - kept..end, line + BEFORE - kept);
            }
        }
        (self.has_before, self.beyond_before) = (true, beyond);
    }
}

/// Kernel: the springs that some rows own, then, if asked, the forces on their nodes.
struct Block<'a, T> {
    sweep: &'a mut NarrowSweep<T>,
    grid: &'a GridSprings<T>,
    masks: &'a Masks<T>,
    rows: Range<usize>,
    /// Where the forces of the first one begin in a line.
    at: usize,
    old: [&'a [T]; 6],
    force: Option<[&'a mut [T]; 3]>,
}

impl<T: Real> Block<'_, T> {
    /// Whether any of the springs is beyond the limit, and whether any of the last two rows is.
    fn run_at(self, level: SimdLevel) -> [bool; 2] {
        if self.sweep.limit.is_some() {
            level.run(Limited::<T, true>(self))
        } else {
            level.run(Limited::<T, false>(self))
        }
    }
}

struct Limited<'a, T, const LIMITED: bool>(Block<'a, T>);

impl<T: Real, const LIMITED: bool> Kernel for Limited<'_, T, LIMITED> {
    type Output = [bool; 2];
    #[inline(always)]
    fn run(self) -> [bool; 2] {
        let Block { sweep, grid, masks, rows, at, old, force } = self.0;
        let mut beyond = [false; 2];
        for direction in 0..6 {
            let [all, last] = own_springs::<T, LIMITED>(sweep, (grid, masks), direction, &rows, at, &old);
            beyond = [beyond[0] | all, beyond[1] | last];
        }
        if let Some(force) = force {
            for (axis, force) in force.into_iter().enumerate() {
                add_up(sweep, grid.cols, at, axis, force);
            }
        }
        beyond
    }
}

/// Forces on the first ends of the springs of some rows in one direction.
#[inline(always)]
fn own_springs<T: Real, const LIMITED: bool>(
    sweep: &mut NarrowSweep<T>,
    (grid, masks): (&GridSprings<T>, &Masks<T>),
    direction: usize,
    rows: &Range<usize>,
    at: usize,
    old: &[&[T]; 6],
) -> [bool; 2] {
    let (down, across) = STEPS[direction];
    let whole = rows.end.min(grid.rows.saturating_sub(down)).saturating_sub(rows.start) * grid.cols;
    // The last nodes have none that step to the right.
    let there = if grid.along[direction].is_some() { whole } else { 0 };
    let count = there.saturating_sub(across.max(0) as usize);
    // Whole vectors: what lies past the last is computed too, then cleared. The state is padded for that.
    let padded = count.next_multiple_of(LANES);
    let nodes = rows.len() * grid.cols;
    let line = sweep.line;
    let start = 3 * direction * line;
    let (x, rest) = sweep.forces[start..start + 3 * line].split_at_mut(line);
    let (y, z) = rest.split_at_mut(line);
    let (x, y, z) = (&mut x[at..], &mut y[at..], &mut z[at..]);
    let mut beyond = [false; 2];
    if let Some(along) = grid.along[direction].filter(|_| count > 0) {
        let a = rows.start * grid.cols;
        let ends = [a, (a + down * grid.cols).wrapping_add_signed(across)];
        let (x, y, z) = (&mut x[..padded], &mut y[..padded], &mut z[..padded]);
        let squares = &mut sweep.squares[..if LIMITED { padded } else { 0 }];
        match mask_of(across).map(|mask| &masks.masks[mask][..padded]) {
            Some(mask) => springs_in_line::<T, LIMITED, true>(old, ends, x, y, z, (squares, mask), along),
            None => springs_in_line::<T, LIMITED, false>(old, ends, x, y, z, (squares, &[]), along),
        }
        if LIMITED {
            let reach = sweep.limit.map_or(T::FAR, |limit| limit * (along.rest_length * along.rest_length));
            let last = nodes.saturating_sub(2 * grid.cols).min(count);
            let late = any_beyond(&squares[last..count], reach);
            beyond = [late || any_beyond(&squares[..last], reach), late];
        }
    }
    let end = nodes.next_multiple_of(LANES).min(x.len());
    for axis in [x, y, z] {
        axis[count..end].fill(T::ZERO);
    }
    beyond
}

/// Adds the forces of a block along one axis: own springs less those that end here, in the order of the steps.
/// The sum is written out as in `cpu_grid`: in a function of both, compilers took an eighth to a half longer for all.
#[inline(always)]
fn add_up<T: Real>(sweep: &NarrowSweep<T>, cols: usize, at: usize, axis: usize, force: &mut [T]) {
    let n = force.len();
    let kept = |direction: usize| {
        let (down, across) = STEPS[direction];
        let start = (3 * direction + axis) * sweep.line + at;
        let before = start - (down * cols).wrapping_add_signed(across);
        (&sweep.forces[start..start + n], &sweep.forces[before..before + n])
    };
    let (p0, m0) = kept(0);
    let (p1, m1) = kept(1);
    let (p2, m2) = kept(2);
    let (p3, m3) = kept(3);
    let (p4, m4) = kept(4);
    let (p5, m5) = kept(5);
    for i in 0..n {
        force[i] += (p0[i] - m0[i])
            + (p1[i] - m1[i])
            + (p2[i] - m2[i])
            + (p3[i] - m3[i])
            + (p4[i] - m4[i])
            + (p5[i] - m5[i]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::spring::cpu_grid::{Direction, Sweep};
    use crate::topology::random::SplitMix64;

    /// A grid with springs of some directions, and a state without order, padded for whole vectors. One node is far away.
    fn grid<T: Real>([rows, cols]: [usize; 2], seed: u64) -> (GridSprings<T>, [Vec<T>; 6]) {
        let mut random = SplitMix64::new(seed);
        let mut number = || T::from_f64(random.unit());
        let along = [0, 1, 2, 3, 4, 5].map(|direction| {
            let spring = Direction { k: number(), damping: number(), rest_length: T::from_f64(2.0) };
            (!seed.is_multiple_of(5) || direction != seed % 6).then_some(spring)
        });
        let places = rows * cols + 4 * LANES;
        let mut state = [(); 6].map(|()| (0..places).map(|_| number()).collect::<Vec<T>>());
        state[0][seed as usize * 7 % (rows * cols)] = T::from_f64(9.0);
        (GridSprings { rows, cols, along }, state)
    }

    /// Compares both sweeps of all blocks from each one on. Returns how many were within and beyond the limit.
    fn compare<T: Real>(limit: Option<f64>) -> [usize; 2] {
        let level = SimdLevel::Base;
        let sizes = [[1, 1], [5, 1], [1, 7], [2, 2], [3, 5], [30, 20], [60, 17], [9, NARROW], [25, 100]];
        let limit = limit.map(T::from_f64);
        // The same ones for all: what a grid has left must not be in the next.
        let (mut wide, mut narrow) = (Sweep::new(NARROW, limit), NarrowSweep::new(TILE_NODES, limit));
        let mut seen = [0; 2];
        for (seed, [rows, cols]) in (0..).zip(sizes.into_iter().cycle().take(4 * sizes.len())) {
            let (grid, state) = grid::<T>([rows, cols], seed);
            let old = state.each_ref().map(Vec::as_slice);
            let masks = Masks::new(cols, TILE_NODES);
            let blocks: Vec<_> = (0..rows).step_by(TILE_NODES / cols).collect();
            for first in 0..blocks.len() {
                wide.restart();
                narrow.restart();
                for &start in &blocks[first..] {
                    let block = start..rows.min(start + TILE_NODES / cols);
                    let mut forces = [(); 2].map(|()| [(); 3].map(|()| Column::zeros(TILE_NODES)));
                    let [by_rows, by_blocks] = &mut forces;
                    let beyond = [
                        wide.springs(level, (0, &grid), (block.clone(), 0..cols), old, by_rows),
                        narrow.springs(level, (0, &grid, &masks), block.clone(), old, by_blocks),
                    ];
                    let place = format!("{rows} × {cols}, {block:?} from block {first}");
                    assert_eq!(beyond[0], beyond[1], "{place}");
                    seen[usize::from(beyond[0])] += 1;
                    assert_eq!(bits(by_rows), bits(by_blocks), "{place}");
                }
            }
        }
        seen
    }

    fn bits<T: Real>(force: &[Column<T>; 3]) -> Vec<u64> {
        force.iter().flat_map(|axis| axis.iter().map(|one| one.to_f64().to_bits())).collect()
    }

    #[test]
    fn a_block_has_the_forces_of_its_rows_wherever_a_worker_begins() {
        compare::<f32>(None);
        compare::<f64>(None);
        let seen = [compare::<f32>(Some(2.0)), compare::<f64>(Some(2.0))];
        assert!(seen.iter().flatten().all(|&count| count > 20), "{seen:?} blocks within and beyond it");
    }
}
