//! Springs of a grid, by a sweep over its rows: each spring is computed once and its force used at both ends.
//!
//! A row owns six springs per node: to the next and second next in its row, straight down to the next and second
//! next row, and both diagonals down. Their forces are kept for as many rows as they reach, and a node's force is
//! the sum of its twelve springs in a fixed order. So a row's result depends on the old state alone, not on where a
//! worker began.

use crate::cpu::column::Column;
use crate::cpu::simd::{Kernel, SimdLevel};
use crate::elements::spring::spring;
use crate::elements::spring::stencil::GRID_STEPS as STEPS;
use crate::real::{Real, dot};
use crate::topology::LANES;
use std::ops::Range;

/// Stiffness [N/m], damping [kg/s] and rest length [m] of the springs in one direction.
#[derive(Clone, Copy, Debug, Default)]
pub struct Direction<T> {
    pub k: T,
    pub damping: T,
    pub rest_length: T,
}

impl<T: Real> Direction<T> {
    /// From stiffness, damping and rest length.
    pub fn new([k, damping, rest_length]: [f64; 3]) -> Self {
        Self { k: T::from_f64(k), damping: T::from_f64(damping), rest_length: T::from_f64(rest_length) }
    }
}

/// The springs of a grid of `rows` × `cols` nodes, by direction; `None` where there are none.
#[derive(Clone, Copy, Debug)]
pub struct GridSprings<T> {
    pub rows: usize,
    pub cols: usize,
    pub along: [Option<Direction<T>>; 6],
}

/// The first column that owns a spring of a direction. Forces are kept by number of the spring in its row, from 0.
const fn first_column(direction: usize) -> usize {
    if STEPS[direction].1 < 0 { 1 } else { 0 }
}

impl<T: Real> GridSprings<T> {
    /// How many springs of `direction` a row has, going down from `row`.
    pub fn count(&self, direction: usize, row: usize) -> usize {
        let (down, across) = STEPS[direction];
        let there = self.along[direction].is_some() && row + down < self.rows;
        if there { self.cols.saturating_sub(across.unsigned_abs()) } else { 0 }
    }

    /// The two ends, as offsets from the body's first node, of the first spring of `direction` in `row`.
    pub fn ends(&self, direction: usize, row: usize) -> (usize, usize) {
        let (down, across) = STEPS[direction];
        let a = row * self.cols + first_column(direction);
        (a, ((row + down) * self.cols + first_column(direction)).wrapping_add_signed(across))
    }
}

/// A worker's sweep over rows, and the forces it remembers from the rows before.
///
/// All lie in one block of lines: [`LANES`] zeros, the columns (from [`LANES`] before the strip on), zeros. A direction that goes
/// `down` rows needs `down` + 1 rows of three axes; row r is kept in the (r mod (down + 1))-th.
pub struct Sweep<T> {
    forces: Column<T>,
    line: usize,
    /// Squared limit of the stretch, if any; squared lengths of some springs [m²]; which of the last rows own a spring
    /// beyond it.
    limit: Option<T>,
    squares: Column<T>,
    beyond: [bool; 3],
    /// What may come next without starting again: (body, first column, row).
    next: Option<(usize, usize, usize)>,
}

/// Columns that pass through all six directions together.
const BLOCK: usize = 512;

/// The first line of each direction's rows in a sweep's block.
const FIRST_LINE: [usize; 6] = [0, 3, 6, 12, 21, 27];
const LINES: usize = 33;

/// The line where `axis` of `direction` is kept for `row`, which may be before the first.
#[inline(always)]
fn line_of(direction: usize, row: isize, axis: usize) -> usize {
    let kept = STEPS[direction].0 as isize + 1;
    FIRST_LINE[direction] + 3 * row.rem_euclid(kept) as usize + axis
}

impl<T: Real> Sweep<T> {
    /// For strips of up to `cols` columns; watches for springs longer than a multiple of their rest length.
    pub fn new(cols: usize, limit: Option<T>) -> Self {
        let line = cols.next_multiple_of(LANES) + 3 * LANES;
        let limit = limit.map(|stretch| stretch * stretch);
        let squares = Column::zeros(if limit.is_some() { BLOCK + LANES } else { 0 });
        Self { forces: Column::zeros(line * LINES), line, limit, squares, beyond: [false; 3], next: None }
    }

    /// Forgets the rows before: the state has changed.
    pub fn restart(&mut self) {
        self.next = None;
    }

    /// Adds to `force` [N] the springs of the nodes in `rows` and `cols`; `old` is the state (position and velocity by
    /// axis) from the body's first node on. Returns whether one of these springs, or a neighbour, is longer than watched for.
    pub fn springs(
        &mut self,
        level: SimdLevel,
        (body, grid): (usize, &GridSprings<T>),
        (rows, cols): (Range<usize>, Range<usize>),
        old: [&[T]; 6],
        force: &mut [Column<T>; 3],
    ) -> bool {
        if self.next != Some((body, cols.start, rows.start)) {
            self.forces.fill(T::ZERO);
            self.beyond = [false; 3];
            for row in rows.start.saturating_sub(2)..rows.start {
                self.row(level, grid, row, cols.clone(), old, None);
            }
        }
        // Springs of the two rows before end in this one.
        let mut beyond =
            rows.start > 0 && (self.beyond[(rows.start + 1) % 3] || self.beyond[(rows.start + 2) % 3]);
        let width = cols.len();
        for row in rows.clone() {
            let at = (row - rows.start) * width..(row - rows.start + 1) * width;
            let [x, y, z] = &mut *force;
            let force = Some([&mut x[at.clone()], &mut y[at.clone()], &mut z[at]]);
            self.row(level, grid, row, cols.clone(), old, force);
            beyond |= self.beyond[row % 3];
        }
        self.next = Some((body, cols.start, rows.end));
        beyond
    }

    fn row(
        &mut self,
        level: SimdLevel,
        grid: &GridSprings<T>,
        row: usize,
        cols: Range<usize>,
        old: [&[T]; 6],
        force: Option<[&mut [T]; 3]>,
    ) {
        if self.limit.is_some() {
            self.beyond[row % 3] = false;
            level.run(SweepRow::<T, true> { sweep: self, grid, row, cols, old, force });
        } else {
            level.run(SweepRow::<T, false> { sweep: self, grid, row, cols, old, force });
        }
    }
}

/// Kernel: the springs that a row owns, then, if asked, the forces on its nodes.
struct SweepRow<'a, T, const LIMITED: bool> {
    sweep: &'a mut Sweep<T>,
    grid: &'a GridSprings<T>,
    row: usize,
    cols: Range<usize>,
    old: [&'a [T]; 6],
    force: Option<[&'a mut [T]; 3]>,
}

impl<T: Real, const LIMITED: bool> Kernel for SweepRow<'_, T, LIMITED> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { sweep, grid, row, cols, old, force } = self;
        // Springs that begin before the strip may end in it.
        let before = if cols.start == 0 { 0 } else { LANES };
        let first = cols.start - before;
        let [x, y, z] = force.map_or([None, None, None], |force| force.map(Some));
        let mut force = [x, y, z];
        // A node's springs begin at its column or before: block after block, the next one is fetched meanwhile.
        for start in (first..cols.end).step_by(BLOCK) {
            let owned = start..cols.end.min(start + BLOCK);
            for direction in 0..6 {
                own_springs::<T, LIMITED>(sweep, grid, direction, (row, start - first, &owned), &old);
            }
            for (axis, force) in force.iter_mut().enumerate() {
                if let Some(force) = force {
                    let inside = owned.start.max(cols.start)..owned.end;
                    let out = &mut force[inside.start - cols.start..inside.end - cols.start];
                    add_up(sweep, (row, inside.start - first), axis, out);
                }
            }
        }
    }
}

/// Forces on the first ends of those springs of a row in one direction whose numbers are `owned`.
#[inline(always)]
fn own_springs<T: Real, const LIMITED: bool>(
    sweep: &mut Sweep<T>,
    grid: &GridSprings<T>,
    direction: usize,
    (row, at, owned): (usize, usize, &Range<usize>),
    old: &[&[T]; 6],
) {
    let Some(along) = grid.along[direction] else { return };
    let count = grid.count(direction, row).clamp(owned.start, owned.end) - owned.start;
    // Whole vectors: what lies past the row is computed too, then cleared. The state is padded for that.
    let padded = count.next_multiple_of(LANES);
    let line = sweep.line;
    let reach = sweep.limit.map_or(T::FAR, |limit| limit * (along.rest_length * along.rest_length));
    let start = line_of(direction, row as isize, 0) * line;
    let squares = &mut sweep.squares;
    let (x, rest) = sweep.forces[start..start + 3 * line].split_at_mut(line);
    let (y, z) = rest.split_at_mut(line);
    let (x, y, z) = (&mut x[LANES + at..], &mut y[LANES + at..], &mut z[LANES + at..]);
    if count > 0 {
        let (a, b) = grid.ends(direction, row);
        let ends = [a + owned.start, b + owned.start];
        let (x, y, z) = (&mut x[..padded], &mut y[..padded], &mut z[..padded]);
        springs_in_line::<T, LIMITED, false>(old, ends, x, y, z, (squares, &[]), along);
        if LIMITED && any_beyond(&squares[..count], reach) {
            sweep.beyond[row % 3] = true;
        }
    }
    for axis in [x, y, z] {
        axis[count..owned.len().next_multiple_of(LANES)].fill(T::ZERO);
    }
}

/// Forces on the first ends of springs whose ends follow each other, from `a` and `b` on; and their squared lengths, if they are limited.
/// With a mask, springs whose number in it is not above 0 have neither.
#[inline(always)]
pub fn springs_in_line<T: Real, const LIMITED: bool, const MASKED: bool>(
    old: &[&[T]; 6],
    [a, b]: [usize; 2],
    x: &mut [T],
    y: &mut [T],
    z: &mut [T],
    (squares, mask): (&mut [T], &[T]),
    along: Direction<T>,
) {
    let n = x.len();
    let (y, z) = (&mut y[..n], &mut z[..n]);
    let squares = &mut squares[..if LIMITED { n } else { 0 }];
    let mask = &mask[..if MASKED { n } else { 0 }];
    let (ax, ay, az) = (&old[0][a..a + n], &old[1][a..a + n], &old[2][a..a + n]);
    let (au, av, aw) = (&old[3][a..a + n], &old[4][a..a + n], &old[5][a..a + n]);
    let (bx, by, bz) = (&old[0][b..b + n], &old[1][b..b + n], &old[2][b..b + n]);
    let (bu, bv, bw) = (&old[3][b..b + n], &old[4][b..b + n], &old[5][b..b + n]);
    for i in 0..n {
        let d = [bx[i] - ax[i], by[i] - ay[i], bz[i] - az[i]];
        let dv = [bu[i] - au[i], bv[i] - av[i], bw[i] - aw[i]];
        let factor = spring::factor(d, dv, along.k, along.damping, along.rest_length);
        let stays = !MASKED || mask[i] > T::ZERO;
        if LIMITED {
            squares[i] = if stays { dot(d, d) } else { T::ZERO };
        }
        x[i] = if stays { factor * d[0] } else { T::ZERO };
        y[i] = if stays { factor * d[1] } else { T::ZERO };
        z[i] = if stays { factor * d[2] } else { T::ZERO };
    }
}

/// Whether one of some numbers is more than `reach`. Counting them takes no branch and no order.
#[inline(always)]
pub fn any_beyond<T: Real>(numbers: &[T], reach: T) -> bool {
    let mut count = 0;
    for &number in numbers {
        count += u32::from(number > reach);
    }
    count > 0
}

/// Forces of `n` springs of a direction along one axis, kept for `row`, from the `from`-th number of their line on.
#[inline(always)]
fn kept<T: Real>(sweep: &Sweep<T>, direction: usize, row: isize, axis: usize, from: usize, n: usize) -> &[T] {
    let from = line_of(direction, row, axis) * sweep.line + from;
    &sweep.forces[from..from + n]
}

/// Forces of the springs of a direction that nodes own, and of those that end at them.
#[inline(always)]
fn own_and_ending<T: Real>(
    sweep: &Sweep<T>,
    direction: usize,
    (row, at): (usize, usize),
    axis: usize,
    n: usize,
) -> (&[T], &[T]) {
    let (down, across) = STEPS[direction];
    let own = LANES + at - first_column(direction);
    let row = row as isize;
    (
        kept(sweep, direction, row, axis, own, n),
        kept(sweep, direction, row - down as isize, axis, own.wrapping_add_signed(-across), n),
    )
}

/// Adds a row's forces along one axis: own springs less those that end here, in the order of the steps.
#[inline(always)]
fn add_up<T: Real>(sweep: &Sweep<T>, place: (usize, usize), axis: usize, force: &mut [T]) {
    let n = force.len();
    let (p0, m0) = own_and_ending(sweep, 0, place, axis, n);
    let (p1, m1) = own_and_ending(sweep, 1, place, axis, n);
    let (p2, m2) = own_and_ending(sweep, 2, place, axis, n);
    let (p3, m3) = own_and_ending(sweep, 3, place, axis, n);
    let (p4, m4) = own_and_ending(sweep, 4, place, axis, n);
    let (p5, m5) = own_and_ending(sweep, 5, place, axis, n);
    for i in 0..n {
        force[i] += (p0[i] - m0[i])
            + (p1[i] - m1[i])
            + (p2[i] - m2[i])
            + (p3[i] - m3[i])
            + (p4[i] - m4[i])
            + (p5[i] - m5[i]);
    }
}
