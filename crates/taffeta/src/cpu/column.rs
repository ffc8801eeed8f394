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
    /// Lines before the first number.
    lead: usize,
}

impl<T: Real> Column<T> {
    /// At least `len` zeros.
    pub fn zeros(len: usize) -> Self {
        Self::staggered(len, 0)
    }

    /// As [`Self::zeros`], with `lead` lines before the first number: large arrays start on page boundaries, and
    /// those that a kernel walks through together must not fall on the same sets of the cache.
    pub fn staggered(len: usize, lead: usize) -> Self {
        let count = len.div_ceil(LANES) + lead;
        let mut lines = Vec::with_capacity(count);
        prefer_huge_pages(lines.spare_capacity_mut());
        lines.resize(count, Line([T::ZERO; LANES]));
        Self { lines, lead }
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
    unsafe {
        libc::madvise(start.wrapping_byte_add(lead), (bytes - lead) / HUGE * HUGE, libc::MADV_HUGEPAGE)
    };
}

#[cfg(not(target_os = "linux"))]
fn prefer_huge_pages<L>(_memory: &mut [std::mem::MaybeUninit<L>]) {}

impl<T> Deref for Column<T> {
    type Target = [T];
    #[inline(always)]
    fn deref(&self) -> &[T] {
        let lines = &self.lines[self.lead..];
        // SAFETY: `Line` is `repr(C)` around `[T; LANES]`; its size is a multiple of 64 for the 4- and 8-byte
        // numbers used here, so lines lie one after the other without padding.
        unsafe { std::slice::from_raw_parts(lines.as_ptr().cast::<T>(), lines.len() * LANES) }
    }
}

impl<T> DerefMut for Column<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        let lines = &mut self.lines[self.lead..];
        // SAFETY: as in `deref`, and `self` is borrowed mutably.
        unsafe { std::slice::from_raw_parts_mut(lines.as_mut_ptr().cast::<T>(), lines.len() * LANES) }
    }
}
