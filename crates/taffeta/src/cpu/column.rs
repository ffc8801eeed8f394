//! One number per node, in memory that starts on a cache line, so that a vector load never straddles two.

use crate::real::Real;
use crate::topology::LANES;
use std::ops::{Deref, DerefMut};

/// Sixteen numbers on a cache-line boundary.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Line<T>([T; LANES]);

/// A cache-aligned array; its length is a multiple of [`LANES`].
#[derive(Clone)]
pub struct Column<T> {
    lines: Vec<Line<T>>,
}

impl<T: Real> Column<T> {
    /// At least `len` zeros.
    pub fn zeros(len: usize) -> Self {
        Self { lines: vec![Line([T::ZERO; LANES]); len.div_ceil(LANES)] }
    }
}

impl<T> Deref for Column<T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        // SAFETY: `Line` is `repr(C)` around `[T; LANES]`; its size is a multiple of 64 for the 4- and 8-byte
        // numbers used here, so lines lie one after the other without padding.
        unsafe { std::slice::from_raw_parts(self.lines.as_ptr().cast::<T>(), self.lines.len() * LANES) }
    }
}

impl<T> DerefMut for Column<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        // SAFETY: as in `deref`, and `self` is borrowed mutably.
        unsafe { std::slice::from_raw_parts_mut(self.lines.as_mut_ptr().cast::<T>(), self.lines.len() * LANES) }
    }
}
