//! Numbers that workers leave to others.
//!
//! They are atomic, so that nothing needs to be promised, and not ordered, so that they cost no more than others: whoever reads what
//! another worker has written does so after a barrier.

use crate::step::Marks;
use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};

/// A number.
#[derive(Debug, Default)]
pub struct Number(AtomicU64);

impl Number {
    /// As it is now.
    #[inline(always)]
    pub fn get(&self) -> f64 {
        f64::from_bits(self.0.load(Ordering::Relaxed))
    }

    /// Changes it.
    #[inline(always)]
    pub fn set(&self, number: f64) {
        self.0.store(number.to_bits(), Ordering::Relaxed);
    }
}

/// Rows of numbers, such as the sums of chunks or tiles, each of which one worker has.
pub struct Numbers<const N: usize>(Vec<[Number; N]>);

impl<const N: usize> Numbers<N> {
    /// So many rows of zeros.
    pub fn new(rows: usize) -> Self {
        Self::all(rows, [0.0; N])
    }

    /// So many rows of these.
    pub fn all(rows: usize, numbers: [f64; N]) -> Self {
        let row = || numbers.map(|number| Number(AtomicU64::new(number.to_bits())));
        Self(std::iter::repeat_with(row).take(rows).collect())
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// A row.
    #[inline(always)]
    pub fn get(&self, row: usize) -> [f64; N] {
        self.0[row].each_ref().map(Number::get)
    }

    /// Changes a row.
    #[inline(always)]
    pub fn set(&self, row: usize, numbers: [f64; N]) {
        self.0[row].iter().zip(numbers).for_each(|(old, new)| old.set(new));
    }

    /// Changes one number of a row.
    #[inline(always)]
    pub fn set_one(&self, row: usize, column: usize, number: f64) {
        self.0[row][column].set(number);
    }

    /// All rows.
    pub fn iter(&self) -> impl Iterator<Item = [f64; N]> {
        self.0.iter().map(|row| row.each_ref().map(Number::get))
    }
}

/// The marks of a tile, which the worker that has it changes.
#[derive(Debug)]
pub struct TileMarks(AtomicU8);

impl From<Marks> for TileMarks {
    fn from(marks: Marks) -> Self {
        Self(AtomicU8::new(marks.0))
    }
}

impl TileMarks {
    /// As they are now.
    #[inline(always)]
    pub fn get(&self) -> Marks {
        Marks(self.0.load(Ordering::Relaxed))
    }

    /// Changes them.
    #[inline(always)]
    pub fn set(&self, marks: Marks) {
        self.0.store(marks.0, Ordering::Relaxed);
    }

    /// Whether all of some are among them.
    #[inline(always)]
    pub fn has(&self, marks: Marks) -> bool {
        self.get().has(marks)
    }
}
