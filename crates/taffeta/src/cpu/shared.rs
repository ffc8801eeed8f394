//! Arrays that all workers of a team read and write, each its own part, with barriers between writing and reading.

use std::marker::PhantomData;
use std::ops::Range;

/// A mutable array lent to all workers of a team.
///
/// Rust cannot see that workers write disjoint parts and read others' parts only after a barrier; this type is
/// where that is promised.
pub struct Shared<'a, T> {
    start: *mut T,
    len: usize,
    lent: PhantomData<&'a mut [T]>,
}

// SAFETY: the array is borrowed mutably for 'a and only reached through the methods below, whose callers promise
// that no part is written while another worker touches it.
unsafe impl<T: Send + Sync> Sync for Shared<'_, T> {}

impl<'a, T> Shared<'a, T> {
    /// Lends `array`.
    pub fn new(array: &'a mut [T]) -> Self {
        Self { start: array.as_mut_ptr(), len: array.len(), lent: PhantomData }
    }

    /// The whole array, to read.
    ///
    /// # Safety
    /// Until the next barrier no worker writes any of what is read through it.
    pub unsafe fn read(&self) -> &[T] {
        // SAFETY: start and len come from a live slice; no writer by the caller's promise.
        unsafe { std::slice::from_raw_parts(self.start, self.len) }
    }

    /// A part of the array, to write.
    ///
    /// # Safety
    /// Until the next barrier no other worker touches this part, and this worker holds no other reference to it.
    #[expect(clippy::mut_from_ref, reason = "the promise above is what makes the reference unique")]
    pub unsafe fn write(&self, range: Range<usize>) -> &mut [T] {
        assert!(range.start <= range.end && range.end <= self.len, "part of a shared array out of range");
        // SAFETY: in bounds by the assertion; unique by the caller's promise.
        unsafe { std::slice::from_raw_parts_mut(self.start.add(range.start), range.len()) }
    }

    /// One item, to write.
    ///
    /// # Safety
    /// As of [`Self::write`].
    #[expect(clippy::mut_from_ref, reason = "as of `write`")]
    pub unsafe fn item(&self, index: usize) -> &mut T {
        // SAFETY: promised by the caller.
        let one = unsafe { self.write(index..index + 1) };
        &mut one[0]
    }
}
