//! Sweeps over the rows of a grid, and steps from one of its levels to the next.

use crate::assembly::body::GridDirections;
use crate::cpu::simd::Kernel;
use crate::real::Real;
use crate::solvers::xpbd::cpu::kernels::{Limit, Nodes, Undamped, between, within};
use crate::solvers::xpbd::cpu::level::{FREE, LevelNodes};
use crate::solvers::xpbd::grid::{self, GridLevel, GridLevels};
use crate::solvers::xpbd::levels::{lightest, masses as masses_of};
use crate::solvers::xpbd::project::Stiffness;
use std::ops::Range;

/// A grid.
pub struct GridBody<T> {
    /// By direction: stiffness and damping, and squared length at rest [m²], of those that act.
    pub springs: [Option<([f64; 2], T)>; 6],
    /// Mass of its lightest node [kg].
    pub lightest: f64,
    /// The grid and its coarser levels.
    pub shapes: Vec<Shape>,
    pub limits: Limits<T>,
    /// Places of its nodes at rest [m], where it has coarser levels.
    pub rest: [Vec<T>; 3],
    /// Nodes of the coarser levels.
    pub nodes: Vec<LevelNodes<T>>,
}

/// Rows and columns of a level, and which of the two are half as many as on the finer level.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    pub layout: [usize; 2],
    pub halved: [bool; 2],
}

/// The limits of a grid.
#[derive(Clone, Copy, Debug)]
pub struct Limits<T> {
    pub diagonals: bool,
    /// Squared length, relative to the distance of the ends at rest.
    pub slack: T,
}

/// The springs of a sub-step by direction, with their squared length at rest [m²].
pub type Springs<T> = [Option<(Stiffness<T>, T)>; 6];

impl<T: Real> GridBody<T> {
    pub fn new(springs: &GridDirections, all: &GridLevels, masses: &[f64]) -> Self {
        let acts = |&[k, d, _]: &[f64; 3]| k > 0.0 || d > 0.0;
        let spring = |[k, d, length]: [f64; 3]| ([k, d], T::from_f64(length * length));
        let mut finer = masses.to_vec();
        let coarser = all.levels.array_windows().map(|[above, level]| {
            let parents = grid::parents(level, above.layout());
            finer = masses_of(&parents, level.nodes(), &finer);
            LevelNodes::new(&finer)
        });
        let nodes: Vec<_> = coarser.collect();
        let asked = if nodes.is_empty() { 0 } else { 1 };
        let places = || all.levels[..asked].iter().flat_map(GridLevel::places);
        Self {
            rest: [0, 1, 2].map(|axis| places().map(|place| T::from_f64(place[axis])).collect()),
            nodes,
            lightest: lightest(masses),
            springs: springs.map(|along| along.filter(acts).map(spring)),
            shapes: all.levels.iter().map(|one| Shape { layout: one.layout(), halved: one.halved }).collect(),
            limits: Limits { diagonals: all.diagonals, slack: T::from_f64(all.slack) },
        }
    }

    /// Springs in a sub-step of length h [s], of which so many sweeps share what is to act.
    pub fn springs(&self, h: f64, sweeps: usize) -> Springs<T> {
        self.springs
            .map(|one| one.map(|(material, rest)| (Stiffness::new(material, h, sweeps, self.lightest), rest)))
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        let nodes: usize = self.nodes.iter().map(LevelNodes::bytes).sum();
        nodes + self.rest.iter().map(|column| size_of_val(&column[..])).sum::<usize>()
    }
}

/// What acts on a level: springs, or limits.
#[derive(Clone, Copy)]
pub enum Acting<'a, T> {
    Springs(&'a Springs<T>),
    Limits(Limits<T>),
}

/// What acts on rows in one pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// All that acts within rows; then what acts between rows 0 and 1, 2 and 3, and so on.
    Pairs,
    /// What acts between rows 1 and 2, 3 and 4, and so on.
    OtherPairs,
    /// Springs between rows two apart, from rows 0, 1, 4, 5 and so on.
    Far,
    /// The same from rows 2, 3, 6, 7 and so on.
    OtherFar,
}

impl Pass {
    /// Those of limits, and all.
    pub const LIMITS: &[Self] = &[Self::Pairs, Self::OtherPairs];
    pub const ALL: &[Self] = &[Self::Pairs, Self::OtherPairs, Self::Far, Self::OtherFar];

    /// The row at which it begins, and the number of rows that act on each other and on no others.
    const fn blocks(self) -> (usize, usize) {
        match self {
            Self::Pairs => (0, 2),
            Self::OtherPairs => (1, 2),
            Self::Far => (0, 4),
            Self::OtherFar => (2, 4),
        }
    }

    /// Number of blocks of a grid of so many rows.
    pub const fn count(self, rows: usize) -> usize {
        let (from, rows_each) = self.blocks();
        rows.saturating_sub(from).div_ceil(rows_each)
    }

    /// The rows of some blocks.
    pub fn rows(self, blocks: Range<usize>, rows: usize) -> Range<usize> {
        let (from, each) = self.blocks();
        (from + blocks.start * each).min(rows)..(from + blocks.end * each).min(rows)
    }
}

/// Kernel: a pass over some blocks of rows.
pub struct Sweep<'a, T> {
    pub pass: Pass,
    /// The nodes of the rows.
    pub nodes: Nodes<'a, T>,
    pub cols: usize,
    pub acting: Acting<'a, T>,
}

impl<T: Real> Kernel for Sweep<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(mut self) {
        let (cols, (_, each)) = (self.cols, self.pass.blocks());
        let rows = self.nodes.inverse_mass.len() / cols;
        let mut row = 0;
        while row < rows {
            let count = each.min(rows - row);
            let mut block = self.nodes.part(row * cols, count * cols);
            match self.pass {
                Pass::Pairs => {
                    for within in 0..count {
                        along_row(self.acting, block.part(within * cols, cols));
                    }
                    if count == 2 {
                        between_rows(self.acting, block.split(cols));
                    }
                }
                Pass::OtherPairs if count == 2 => between_rows(self.acting, block.split(cols)),
                Pass::Far | Pass::OtherFar if count > 2 => {
                    let [mut upper, lower] = block.split(2 * cols);
                    let upper = upper.part(0, (count - 2) * cols);
                    if let Acting::Springs([_, _, _, Some((spring, rest)), ..]) = self.acting {
                        springs_between(*spring, *rest, upper, lower);
                    }
                }
                _ => {}
            }
            row += each;
        }
    }
}

/// All that acts within a row.
#[inline(always)]
fn along_row<T: Real>(acting: Acting<'_, T>, mut row: Nodes<'_, T>) {
    let cols = row.inverse_mass.len();
    for colour in 0..2 {
        if colour + 1 < cols {
            let run = row.part(colour, cols - colour);
            match acting {
                Acting::Springs(all) => springs_within::<T, 1>(all[0], run),
                Acting::Limits(limits) => within::<T, _, 1>(Limit, limits.slack, run),
            }
        }
    }
    let Acting::Springs([_, far @ Some(_), ..]) = acting else { return };
    for colour in 0..2 {
        if 2 * colour + 2 < cols {
            springs_within::<T, 2>(*far, row.part(2 * colour, cols - 2 * colour));
        }
    }
}

#[inline(always)]
fn springs_within<T: Real, const STEP: usize>(spring: Option<(Stiffness<T>, T)>, run: Nodes<'_, T>) {
    match spring {
        Some((spring, rest)) if spring.damping > T::ZERO => within::<T, _, STEP>(spring, rest, run),
        Some((spring, rest)) => within::<T, _, STEP>(Undamped(spring), rest, run),
        None => {}
    }
}

#[inline(always)]
fn springs_between<T: Real>(spring: Stiffness<T>, rest: T, a: Nodes<'_, T>, b: Nodes<'_, T>) {
    if spring.damping > T::ZERO {
        between(spring, rest, a, b);
    } else {
        between(Undamped(spring), rest, a, b);
    }
}

/// What acts between two rows.
#[inline(always)]
fn between_rows<T: Real>(acting: Acting<'_, T>, [mut upper, mut lower]: [Nodes<'_, T>; 2]) {
    let cols = upper.inverse_mass.len();
    for (direction, [a, b]) in [(2, [0, 0]), (4, [0, 1]), (5, [1, 0])] {
        let count = cols - a.max(b);
        let (upper, lower) = (upper.part(a, count), lower.part(b, count));
        match acting {
            Acting::Springs(all) => {
                if let Some((spring, rest)) = all[direction] {
                    springs_between(spring, rest, upper, lower);
                }
            }
            Acting::Limits(limits) => {
                if direction == 2 || limits.diagonals {
                    between(Limit, limits.slack, upper, lower);
                }
            }
        }
    }
}

/// Kernel: the means of nodes of a finer level, at some rows of the coarser one.
pub struct Restrict<'a, T> {
    pub shape: Shape,
    /// Rows and columns of the finer level, its nodes and their masses.
    pub finer: [usize; 2],
    pub position: [&'a [T]; 3],
    pub mass: &'a [T],
    /// Which rows; their nodes, what holds these, and inverse masses of all.
    pub rows: Range<usize>,
    pub means: [&'a mut [T]; 3],
    pub held_by: &'a [u32],
    pub when_free: &'a [T],
    /// Room for a row of the finer level.
    pub row: &'a mut Vec<T>,
}

impl<T: Real> Kernel for Restrict<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { shape, finer: [rows, cols], .. } = self;
        let coarse_cols = shape.layout[1];
        // Sums of columns with even and with odd numbers.
        self.row.clear();
        self.row.resize(cols, T::ZERO);
        let (even, odd) = self.row.split_at_mut(cols.div_ceil(2));
        for (means, position) in self.means.into_iter().zip(self.position) {
            for (row, mean) in self.rows.clone().zip(means.chunks_exact_mut(coarse_cols)) {
                even.fill(T::ZERO);
                odd.fill(T::ZERO);
                let own = grid::finer(row, rows, shape.halved[0]);
                for from in own.saturating_sub(1)..(own + 2).min(rows) {
                    if let Some(weight) = weight(grid::between(from, rows, shape.halved[0]), row) {
                        let run = from * cols..(from + 1) * cols;
                        let (mass, position) = (&self.mass[run.clone()], &position[run]);
                        add_row([&mut *even, &mut *odd], T::from_f64(weight), mass, position);
                    }
                }
                let from = (row - self.rows.start) * coarse_cols..(row + 1 - self.rows.start) * coarse_cols;
                let inverse = &self.when_free[row * coarse_cols..(row + 1) * coarse_cols];
                if shape.halved[1] {
                    fold(mean, [even, odd], inverse);
                } else {
                    for (col, (mean, &by)) in mean.iter_mut().zip(inverse).enumerate() {
                        *mean = by * if col % 2 == 0 { even[col / 2] } else { odd[col / 2] };
                    }
                }
                for (mean, &by) in mean.iter_mut().zip(&self.held_by[from]) {
                    if by != FREE {
                        *mean = position[by as usize];
                    }
                }
            }
        }
    }
}

/// How much a row or column of the finer level gives to one of the coarser level, from those between which it lies.
fn weight([a, b]: [usize; 2], to: usize) -> Option<f64> {
    (a == to || b == to).then_some(if a == b { 1.0 } else { 0.5 })
}

#[inline(always)]
fn add_row<T: Real>([even, odd]: [&mut [T]; 2], weight: T, mass: &[T], position: &[T]) {
    let ((pairs, last), (masses, last_mass)) = (position.as_chunks::<2>(), mass.as_chunks::<2>());
    for (((even, odd), x), m) in even.iter_mut().zip(odd).zip(pairs).zip(masses) {
        *even += weight * m[0] * x[0];
        *odd += weight * m[1] * x[1];
    }
    if let (Some(even), [x], [m]) = (even.last_mut(), last, last_mass) {
        *even += weight * *m * *x;
    }
}

/// The means of a row of the coarser level, which has half as many columns, from the sums of its columns.
#[inline(always)]
fn fold<T: Real>(means: &mut [T], [even, odd]: [&[T]; 2], inverse: &[T]) {
    let (half, last) = (T::from_f64(0.5), means.len() - 1);
    means[0] = (even[0] + half * odd[0]) * inverse[0];
    // Of an even number of columns, the last is one of the coarser level, and gives nothing to its neighbour.
    let is_even = even.len() == odd.len();
    let whole = if is_even { last - 1 } else { last };
    let (left, right) = (&odd[..whole - 1], &odd[1..whole]);
    let (own, by) = (&even[1..whole], &inverse[1..whole]);
    for (at, mean) in means[1..whole].iter_mut().enumerate() {
        *mean = (half * left[at] + own[at] + half * right[at]) * by[at];
    }
    means[whole] = (half * odd[whole - 1] + even[whole]) * inverse[whole];
    if is_even {
        means[last] = odd[last - 1] * inverse[last];
    }
}

/// Kernel: has rows of a finer level go where those of the coarser one went.
pub struct Prolongate<'a, T> {
    /// Positions of some rows of the finer level, and their inverse masses.
    pub position: [&'a mut [T]; 3],
    pub inverse_mass: &'a [T],
    /// Which rows, and rows and columns of the finer level.
    pub rows: Range<usize>,
    pub layout: [usize; 2],
    /// How far the nodes of the coarser level have moved, and its shape.
    pub moved: [&'a [T]; 3],
    pub shape: Shape,
}

impl<T: Real> Kernel for Prolongate<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let [rows, cols] = self.layout;
        let (coarse_cols, half) = (self.shape.layout[1], T::from_f64(0.5));
        for (position, moved) in self.position.into_iter().zip(self.moved) {
            for row in self.rows.clone() {
                let [a, b] = grid::between(row, rows, self.shape.halved[0]);
                let at = (row - self.rows.start) * cols;
                let (finer, mass) = (&mut position[at..at + cols], &self.inverse_mass[at..at + cols]);
                let first = &moved[a * coarse_cols..(a + 1) * coarse_cols];
                let second = (a != b).then(|| &moved[b * coarse_cols..(b + 1) * coarse_cols]);
                match (self.shape.halved[1], second) {
                    (false, None) => prolongate_row(finer, mass, |col| first[col]),
                    (false, Some(second)) => {
                        prolongate_row(finer, mass, |col| half * (first[col] + second[col]));
                    }
                    (true, None) => prolongate_halved(finer, mass, first, first, true),
                    (true, Some(second)) => prolongate_halved(finer, mass, first, second, false),
                }
            }
        }
    }
}

#[inline(always)]
fn prolongate_row<T: Real>(finer: &mut [T], inverse_mass: &[T], moved: impl Fn(usize) -> T) {
    for (col, (x, &w)) in finer.iter_mut().zip(inverse_mass).enumerate() {
        let by = moved(col);
        *x += if w > T::ZERO { by } else { T::ZERO };
    }
}

/// A row with twice as many columns as the coarser ones, on the first of them or halfway to the second.
#[inline(always)]
fn prolongate_halved<T: Real>(finer: &mut [T], inverse_mass: &[T], first: &[T], second: &[T], is_on: bool) {
    let [half, quarter] = [0.5, 0.25].map(T::from_f64);
    let (pairs, last) = finer.as_chunks_mut::<2>();
    let (masses, last_mass) = inverse_mass.as_chunks::<2>();
    // Of an even number of columns, the last is the coarser level's last.
    let whole = if last.is_empty() { pairs.len() - 1 } else { pairs.len() };
    let (ahead, after) = (&first[..whole + 1], &second[..whole + 1]);
    for (col, (pair, mass)) in pairs[..whole].iter_mut().zip(&masses[..whole]).enumerate() {
        let (a, b, c, d) = (ahead[col], ahead[col + 1], after[col], after[col + 1]);
        let on = if is_on { a } else { half * (a + c) };
        let off = if is_on { half * (a + b) } else { quarter * (a + b + c + d) };
        pair[0] += if mass[0] > T::ZERO { on } else { T::ZERO };
        pair[1] += if mass[1] > T::ZERO { off } else { T::ZERO };
    }
    let at = |col: usize| if is_on { first[col] } else { half * (first[col] + second[col]) };
    let rest = pairs[whole..].iter_mut().flatten().chain(last);
    let rest_mass = masses[whole..].iter().flatten().chain(last_mass);
    for (col, (x, &w)) in (whole..).zip(rest.zip(rest_mass)) {
        *x += if w > T::ZERO { at(col) } else { T::ZERO };
    }
}

/// The node of the finer level that holds one of a coarser one: a pin where that is, or next to it; none where nothing does.
pub fn holder<T: Real>(
    shape: Shape,
    [rows, cols]: [usize; 2],
    inverse_mass: &[T],
    [row, col]: [usize; 2],
) -> u32 {
    let near = |at: usize, count: usize, halved: bool| {
        let own = grid::finer(at, count, halved);
        let follows = halved && own + 1 < count && grid::between(own + 1, count, true)[0] == at;
        own..own + if follows { 2 } else { 1 }
    };
    let all = near(row, rows, shape.halved[0])
        .flat_map(|row| near(col, cols, shape.halved[1]).map(move |col| row * cols + col));
    all.into_iter().find(|&node| inverse_mass[node] <= T::ZERO).map_or(FREE, |node| node as u32)
}
