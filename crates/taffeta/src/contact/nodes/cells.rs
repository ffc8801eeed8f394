//! A uniform grid of hashed cells, to find the points near a position. It has no bounds.
//!
//! Source: S2 ("CUDA Cloth Simulation"), the bins of its last two implementations; the table after Teschner et al.,
//! "Optimized Spatial Hashing for Collision Detection of Deformable Objects", 2003. Cells that are neighbours along x
//! are neighbours in the table, so the surroundings of a position are nine runs of points. A run may also hold points
//! of other cells; callers compare distances anyway.

use std::ops::Range;

/// The table of cells, which maps positions to buckets.
#[derive(Clone, Copy, Debug)]
pub struct Cells {
    /// Cells a metre.
    by_length: f64,
    /// Number of buckets less one; a power of two less one.
    mask: u32,
}

impl Cells {
    /// A table for so many points in cells of `edge` [m], or a little more, so that rounding loses no neighbour.
    pub fn new(points: usize, edge: f64) -> Self {
        let buckets = (2 * points).next_power_of_two().clamp(64, 1 << 30);
        Self { by_length: 1.0 / (edge * 1.000_01), mask: buckets as u32 - 1 }
    }

    /// Number of buckets.
    pub fn buckets(&self) -> usize {
        self.mask as usize + 1
    }

    /// The cell of a position [m]. A NaN, or a position too far away, has one too.
    pub fn cell(&self, x: [f64; 3]) -> [i32; 3] {
        x.map(|x| {
            // Rounded down: towards zero, and one less if negative. A call of `floor` would dominate the cost.
            let (scaled, towards_zero) = (x * self.by_length, (x * self.by_length) as i32);
            towards_zero.saturating_sub(i32::from(scaled < f64::from(towards_zero)))
        })
    }

    /// The bucket of a cell.
    pub fn bucket(&self, cell: [i32; 3]) -> usize {
        bucket(cell, self.mask)
    }

    /// Runs of buckets that hold the points of a cell and its 26 neighbours. A bucket may be in several runs.
    pub fn around(&self, [x, y, z]: [i32; 3]) -> impl Iterator<Item = Range<usize>> + use<> {
        let cells = *self;
        (-1..=1).flat_map(move |dz| (-1..=1).map(move |dy| (dy, dz))).flat_map(move |(dy, dz)| {
            let row = row(y.wrapping_add(dy), z.wrapping_add(dz));
            let first = (row.wrapping_add(x as u32).wrapping_sub(1) & cells.mask) as usize;
            // The table is a ring.
            let over = (first + 3).saturating_sub(cells.buckets());
            [first..first + 3 - over, 0..over]
        })
    }
}

/// The bucket of a cell in a table of so many buckets, less one.
pub fn bucket([x, y, z]: [i32; 3], mask: u32) -> usize {
    (row(y, z).wrapping_add(x as u32) & mask) as usize
}

/// The part of the hash that the cells of a row have in common.
fn row(y: i32, z: i32) -> u32 {
    let mixed = (y as u32).wrapping_mul(0x9E37_79B1) ^ (z as u32).wrapping_mul(0x85EB_CA77);
    (mixed ^ (mixed >> 15)).wrapping_mul(0x2C1B_3C6D)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_around_a_place_is_found_wherever_it_is() {
        for (points, edge) in [(10, 0.1), (1000, 0.01), (100_000, 3.0)] {
            let cells = Cells::new(points, edge);
            for place in [[0.0, 0.0, 0.0], [-0.05, 1e3, -1e4], [1e6, -1e6, 0.3]] {
                let found: Vec<usize> = cells.around(cells.cell(place)).flatten().collect();
                assert_eq!(found.len(), 27);
                for i in 0..27 {
                    let way = [i % 3, i / 3 % 3, i / 9].map(|k| (f64::from(k) - 1.0) * 0.999 * edge);
                    let near = [0, 1, 2].map(|axis| place[axis] + way[axis]);
                    assert!(found.contains(&cells.bucket(cells.cell(near))), "{place:?} {near:?}");
                }
            }
        }
    }

    #[test]
    fn what_is_no_number_has_a_bucket() {
        let cells = Cells::new(100, 0.01);
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
            let cell = cells.cell([x, 0.0, x]);
            assert!(cells.bucket(cell) < cells.buckets());
            assert!(cells.around(cell).all(|run| run.end <= cells.buckets()));
        }
    }

    #[test]
    fn a_sheet_spreads_over_the_table() {
        let cells = Cells::new(10_000, 0.01);
        let mut count = vec![0; cells.buckets()];
        for i in 0..10_000 {
            let x = [f64::from(i % 100) * 0.01 + 0.001, 0.5, f64::from(i / 100) * 0.01 + 0.001];
            count[cells.bucket(cells.cell(x))] += 1;
        }
        assert!(count.iter().max().is_some_and(|&most| most <= 12), "{:?}", count.iter().max());
    }
}
