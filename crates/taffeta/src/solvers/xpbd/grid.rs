//! Levels of grids: every second row and column of the finer one, and the last.

use crate::assembly::body::GridDirections;
use crate::solvers::implicit::coarsening::Weighted;
#[cfg(test)]
use crate::solvers::xpbd::levels::Coloured;

/// Rows or columns that are not halved any more.
const FEW: usize = 4;

/// A level of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct GridLevel {
    /// Places of rows and of columns at rest [m].
    pub down: Vec<f64>,
    pub across: Vec<f64>,
    /// Whether rows and columns are half as many as on the finer level.
    pub halved: [bool; 2],
}

/// The levels of a grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GridLevels {
    /// The grid itself, and coarser ones.
    pub levels: Vec<GridLevel>,
    /// Whether there are limits along diagonals.
    pub diagonals: bool,
    /// Squared length of limits, relative to the distance of their ends at rest.
    pub slack: f64,
}

/// A direction in which constraints of a grid act, in two colours each.
#[cfg(test)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Between neighbours in a row, and between nodes two apart.
    Across(usize),
    /// Between neighbours in a column, and between nodes two apart.
    Down(usize),
    /// To the next row, one column on, or back.
    Diagonal { back: bool },
}

/// What acts on a grid, in its order. What is in one group acts on rows that no other rows of the group share, so that rows may take their
/// turn with all that is in the group.
#[cfg(test)]
pub const GROUPS: [&[(Direction, usize)]; 5] = [
    &[
        (Direction::Across(1), 0),
        (Direction::Across(1), 1),
        (Direction::Across(2), 0),
        (Direction::Across(2), 1),
    ],
    &[
        (Direction::Down(1), 0),
        (Direction::Diagonal { back: false }, 0),
        (Direction::Diagonal { back: true }, 0),
    ],
    &[
        (Direction::Down(1), 1),
        (Direction::Diagonal { back: false }, 1),
        (Direction::Diagonal { back: true }, 1),
    ],
    &[(Direction::Down(2), 0)],
    &[(Direction::Down(2), 1)],
];

#[cfg(test)]
impl Direction {
    /// Its place among the directions of a grid's springs.
    pub fn index(self) -> usize {
        match self {
            Self::Across(step) => step - 1,
            Self::Down(step) => step + 1,
            Self::Diagonal { back } => 4 + usize::from(back),
        }
    }

    /// The pairs of a colour, by row and column, row by row.
    fn pairs(self, colour: usize, [rows, cols]: [usize; 2]) -> Vec<[[usize; 2]; 2]> {
        let is_of = |at: usize, step: usize| at / step % 2 == colour;
        let each = (0..rows).flat_map(|row| (0..cols).map(move |col| [row, col]));
        let pair = |[row, col]: [usize; 2]| match self {
            Self::Across(step) => is_of(col, step).then_some([[row, col], [row, col + step]]),
            Self::Down(step) => is_of(row, step).then_some([[row, col], [row + step, col]]),
            Self::Diagonal { back: false } => is_of(row, 1).then_some([[row, col], [row + 1, col + 1]]),
            Self::Diagonal { back: true } => is_of(row, 1).then_some([[row, col + 1], [row + 1, col]]),
        };
        let inside = |pair: &[[usize; 2]; 2]| pair.iter().all(|&[row, col]| row < rows && col < cols);
        each.filter_map(pair).filter(inside).collect()
    }
}

impl GridLevels {
    /// Of a grid with some springs: at most `most` coarser ones, whose limits are `slack` times as long as the cloth.
    pub fn new([rows, cols]: [usize; 2], along: &GridDirections, (most, slack): (usize, f64)) -> Self {
        let length =
            |direction: usize| along[direction].filter(|[k, ..]| *k > 0.0).map(|[_, _, length]| length);
        let (across, down) = (length(0), length(2));
        let evenly = |count: usize, length: Option<f64>| -> Vec<f64> {
            (0..count).map(|at| at as f64 * length.unwrap_or(0.0)).collect()
        };
        let mut levels =
            vec![GridLevel { down: evenly(rows, down), across: evenly(cols, across), halved: [false; 2] }];
        // Where springs are missing along rows or columns, nothing limits how far cloth stretches.
        let resists = |count: usize, length: Option<f64>| count == 1 || length.is_some();
        let limited = resists(rows, down) && resists(cols, across);
        while let Some(finer) = levels.last().filter(|_| limited && levels.len() <= most) {
            let halved = finer.layout().map(|count| count > FEW);
            if halved == [false; 2] {
                break;
            }
            let half = |places: &[f64], halved| -> Vec<f64> {
                let count = if halved { places.len() / 2 + 1 } else { places.len() };
                (0..count).map(|at| places[self::finer(at, places.len(), halved)]).collect()
            };
            let level = GridLevel {
                down: half(&finer.down, halved[0]),
                across: half(&finer.across, halved[1]),
                halved,
            };
            levels.push(level);
        }
        Self { levels, diagonals: length(4).is_some() && length(5).is_some(), slack: slack * slack }
    }
}

impl GridLevel {
    /// Rows and columns.
    pub fn layout(&self) -> [usize; 2] {
        [self.down.len(), self.across.len()]
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.down.len() * self.across.len()
    }

    /// Places of its nodes at rest [m].
    pub fn places(&self) -> impl Iterator<Item = [f64; 3]> {
        self.down.iter().flat_map(|&down| self.across.iter().map(move |&across| [across, down, 0.0]))
    }
}

/// The row or column of the coarser level at which that of `at` of `count` is, or the two between which it lies.
pub fn between(at: usize, count: usize, halved: bool) -> [usize; 2] {
    match (halved, at % 2) {
        (false, _) => [at; 2],
        (true, 1) if at + 1 == count => [at / 2 + 1; 2],
        (true, 0) => [at / 2; 2],
        (true, _) => [at / 2, at / 2 + 1],
    }
}

/// The row or column of the finer level of `count` that the coarser one's `at` is.
pub fn finer(at: usize, count: usize, halved: bool) -> usize {
    if halved { (2 * at).min(count - 1) } else { at }
}

/// Which nodes of a coarser level those of the finer one follow.
pub fn parents(level: &GridLevel, [rows, cols]: [usize; 2]) -> Weighted {
    let mut all = Weighted::default();
    let coarse_cols = level.across.len();
    for (row, col) in (0..rows).flat_map(|row| (0..cols).map(move |col| (row, col))) {
        let [down, across] = [between(row, rows, level.halved[0]), between(col, cols, level.halved[1])].map(
            |ends| match ends {
                [a, b] if a == b => vec![(a, 1.0)],
                [a, b] => vec![(a, 0.5), (b, 0.5)],
            },
        );
        let pairs = down.iter().flat_map(|&(r, wr)| across.iter().map(move |&(c, wc)| (r, c, wr * wc)));
        all.push(pairs.map(|(r, c, weight): (usize, usize, f32)| ((r * coarse_cols + c) as u32, weight)));
    }
    all
}

/// Constraints of a level: of the grid itself springs, else limits between nodes at these positions.
#[cfg(test)]
fn constraints(
    all: &GridLevels,
    layout: [usize; 2],
    springs: Option<&GridDirections>,
    position: &[[f64; 3]],
) -> Coloured {
    use crate::real::{norm, sub};
    let mut coloured = Coloured::default();
    for &(direction, colour) in GROUPS.iter().copied().flatten() {
        // What acts in the direction, and its length.
        let rest = match (springs, direction) {
            (Some(along), _) => along[direction.index()]
                .filter(|[k, d, _]| *k > 0.0 || *d > 0.0)
                .map(|[_, _, length]| Some(length)),
            (None, Direction::Diagonal { .. }) => all.diagonals.then_some(None),
            (None, Direction::Across(step) | Direction::Down(step)) => (step == 1).then_some(None),
        };
        let number = |[row, col]: [usize; 2]| (row * layout[1] + col) as u32;
        if let Some(rest) = rest {
            let between =
                |[a, b]: [u32; 2]| all.slack.sqrt() * norm(sub(position[b as usize], position[a as usize]));
            let one = |pair: [[usize; 2]; 2]| {
                let ends = pair.map(number);
                let length = rest.unwrap_or_else(|| between(ends));
                (ends, length * length, direction.index() as u32)
            };
            coloured.add(direction.pairs(colour, layout).into_iter().map(one));
        }
    }
    coloured
}

/// A grid's constraints as lists; materials are by direction.
#[cfg(test)]
pub fn lists(
    springs: &GridDirections,
    all: &GridLevels,
    mut nodes: crate::solvers::xpbd::levels::Nodes,
) -> crate::solvers::xpbd::levels::Lists {
    use crate::solvers::xpbd::levels::{Level, Lists};
    let Some(grid) = all.levels.first() else { return Lists::default() };
    nodes.position = grid.places().collect();
    let mut levels = Vec::new();
    for [finer_level, level] in all.levels.array_windows() {
        let ([rows, cols], [finer_rows, finer_cols]) = (level.layout(), finer_level.layout());
        let own = |(row, col): (usize, usize)| {
            let row = finer(row, finer_rows, level.halved[0]);
            (row * finer_cols + finer(col, finer_cols, level.halved[1])) as u32
        };
        let own: Vec<u32> = (0..rows).flat_map(|row| (0..cols).map(move |col| (row, col))).map(own).collect();
        let parents = parents(level, finer_level.layout());
        nodes = nodes.coarser(&own, &parents);
        levels.push(Level { own, parents, limits: constraints(all, level.layout(), None, &nodes.position) });
    }
    Lists {
        springs: constraints(all, grid.layout(), Some(springs), &[]),
        materials: springs.iter().map(|along| along.map_or([0.0; 2], |[k, d, _]| [k, d])).collect(),
        levels,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Nodes of 0.1 kg.
    fn nodes(count: usize) -> crate::solvers::xpbd::levels::Nodes {
        let position = vec![[0.0; 3]; count];
        crate::solvers::xpbd::levels::Nodes { mass: vec![0.1; count], position, held: vec![false; count] }
    }

    const ALONG: GridDirections = [
        Some([9.0, 0.1, 0.1]),
        Some([2.0, 0.0, 0.2]),
        Some([9.0, 0.1, 0.1]),
        Some([2.0, 0.0, 0.2]),
        Some([4.0, 0.0, 0.141]),
        Some([4.0, 0.0, 0.141]),
    ];

    #[test]
    fn every_spring_is_there_once_and_no_two_of_a_colour_meet() {
        for layout in [[5, 7], [8, 6], [2, 3], [4, 1]] {
            let lists =
                lists(&ALONG, &GridLevels::new(layout, &ALONG, (16, 1.0)), nodes(layout[0] * layout[1]));
            for all in std::iter::once(&lists.springs).chain(lists.levels.iter().map(|level| &level.limits)) {
                let once: BTreeSet<_> = all.ends.iter().collect();
                assert_eq!(once.len(), all.ends.len());
                for colour in &all.colours {
                    let nodes: BTreeSet<u32> = all.ends[colour.clone()].iter().flatten().copied().collect();
                    assert_eq!(nodes.len(), 2 * colour.len());
                }
            }
            let counts = crate::assembly::springs::grid_counts(layout[0] as u32, layout[1] as u32);
            let whole = counts.structural + counts.shear + counts.bend;
            assert_eq!(lists.springs.ends.len(), whole as usize, "{layout:?}");
        }
    }

    #[test]
    fn levels_keep_the_corners_and_the_size() {
        let all = GridLevels::new([40, 9], &ALONG, (16, 1.0));
        let levels = &all.levels;
        let layouts: Vec<_> = levels.iter().map(GridLevel::layout).collect();
        assert_eq!(layouts, [[40, 9], [21, 5], [11, 3], [6, 3], [4, 3]]);
        for level in levels {
            let [down, across] =
                [&level.down, &level.across].map(|places| (places[0], places[places.len() - 1]));
            assert!(
                down.0 == 0.0
                    && (down.1 - 3.9).abs() < 1e-12
                    && across.0 == 0.0
                    && (across.1 - 0.8).abs() < 1e-12
            );
        }
        let lists = lists(&ALONG, &all, nodes(40 * 9));
        let mut last = 39 * 9 + 8;
        for (level, layout) in lists.levels.iter().zip(&layouts[1..]) {
            assert_eq!(level.own[layout[0] * layout[1] - 1], last);
            last = (layout[0] * layout[1] - 1) as u32;
        }
    }

    #[test]
    fn what_a_node_follows_is_where_it_is() {
        // A linear field of rows and columns is that of the coarser level where rows are evenly spaced.
        let all = lists(&ALONG, &GridLevels::new([9, 17], &ALONG, (1, 1.0)), nodes(9 * 17));
        let field = |row: usize, col: usize| 3.0 * row as f32 - 2.0 * col as f32;
        for row in 0..9 {
            for col in 0..17 {
                let parents = all.levels[0].parents.row(row * 17 + col).iter();
                let value: f32 =
                    parents.map(|&(c, w)| w * field(2 * (c as usize / 9), 2 * (c as usize % 9))).sum();
                assert_eq!(value, field(row, col));
            }
        }
    }
}
