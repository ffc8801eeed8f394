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
        let mut lines = Vec::with_capacity(len.div_ceil(LANES));
        prefer_huge_pages(lines.spare_capacity_mut());
        lines.resize(len.div_ceil(LANES), Line([T::ZERO; LANES]));
        Self { lines }
    }
}

/// Asks for large pages: a sweep over millions of nodes touches more small ones at a time than the processor can look
/// up quickly. A refusal costs nothing but time, so it is not looked at.
#[cfg(target_os = "linux")]
fn prefer_huge_pages<L>(memory: &mut [std::mem::MaybeUninit<L>]) {
    const HUGE: usize = 2 << 20;
    let bytes = size_of_val(memory);
    if bytes < 2 * HUGE {
        return;
    }
    let start = memory.as_mut_ptr().cast::<libc::c_void>();
    let lead = start.align_offset(HUGE).min(bytes);
    // SAFETY: the whole large pages within an allocation of our own; the advice changes no content.
    unsafe { libc::madvise(start.wrapping_byte_add(lead), (bytes - lead) / HUGE * HUGE, libc::MADV_HUGEPAGE) };
}

#[cfg(not(target_os = "linux"))]
fn prefer_huge_pages<L>(_memory: &mut [std::mem::MaybeUninit<L>]) {}

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
