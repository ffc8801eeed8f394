//! Arrays that all workers of a team read and write, each its own part, with barriers between writing and reading.

use crate::cpu::column::Column;
use crate::real::Real;
use std::marker::PhantomData;
use std::ops::Range;

/// An array that workers share.
///
/// Rust cannot see that workers write disjoint parts and read others' parts only after a barrier; this type is
/// where that is promised. Outside frames nobody works on it, and it is an array like any other.
pub struct Shared<T> {
    start: *mut T,
    len: usize,
    /// Keeps the memory; never looked at, so that `start` stays the only way to it.
    _owner: Box<dyn Send + Sync>,
    items: PhantomData<T>,
}

// SAFETY: the array is owned, and only reached through the methods below, whose callers promise that no part is written
// while another worker touches it.
unsafe impl<T: Send> Send for Shared<T> {}
// SAFETY: as above.
unsafe impl<T: Send + Sync> Sync for Shared<T> {}

impl<T: Send + Sync + 'static> From<Vec<T>> for Shared<T> {
    fn from(items: Vec<T>) -> Self {
        let mut owner = Box::new(items);
        Self { start: owner.as_mut_ptr(), len: owner.len(), _owner: owner, items: PhantomData }
    }
}

impl<T: Real> From<Column<T>> for Shared<T> {
    fn from(column: Column<T>) -> Self {
        let mut owner = Box::new(column);
        Self { start: owner.as_mut_ptr(), len: owner.len(), _owner: owner, items: PhantomData }
    }
}

impl<T: Send + Sync + 'static> Default for Shared<T> {
    fn default() -> Self {
        Vec::new().into()
    }
}

impl<T> Shared<T> {
    /// Number of items.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Bytes that the items take.
    pub fn bytes(&self) -> usize {
        self.len * size_of::<T>()
    }

    /// The whole array, where nobody else has it.
    pub fn get_mut(&mut self) -> &mut [T] {
        // SAFETY: `start` and `len` are those of an array that is owned, and `self` is borrowed mutably.
        unsafe { std::slice::from_raw_parts_mut(self.start, self.len) }
    }

    /// The whole array, to read.
    ///
    /// # Safety
    /// Until the next barrier, or the end of the borrow, no worker writes any of what is read through it.
    #[inline]
    pub unsafe fn read(&self) -> &[T] {
        // SAFETY: as in `get_mut`; no writer by the caller's promise.
        unsafe { std::slice::from_raw_parts(self.start, self.len) }
    }

    /// A part of the array, to read.
    ///
    /// # Safety
    /// Until the next barrier, or the end of the borrow, no worker writes any of this part.
    #[inline]
    pub unsafe fn read_part(&self, range: Range<usize>) -> &[T] {
        assert!(range.start <= range.end && range.end <= self.len, "part of a shared array out of range");
        // SAFETY: in bounds by the assertion; no writer by the caller's promise.
        unsafe { std::slice::from_raw_parts(self.start.add(range.start), range.len()) }
    }

    /// A part of the array, to write.
    ///
    /// # Safety
    /// Until the next barrier no other worker touches this part, and this worker holds no other reference to it.
    #[inline]
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
    #[inline]
    #[expect(clippy::mut_from_ref, reason = "as of `write`")]
    pub unsafe fn item(&self, index: usize) -> &mut T {
        // SAFETY: promised by the caller.
        let one = unsafe { self.write(index..index + 1) };
        &mut one[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu::team::Team;

    /// Breaks the promise of [`Shared::item`], so that it is seen that `cargo xtask sanitize` sees it.
    #[test]
    #[ignore = "a data race, planted for `cargo xtask sanitize` to find"]
    fn two_workers_write_one_item_at_once() {
        let shared: Shared<u64> = vec![0].into();
        Team::new(2).run(|worker, barrier| {
            for _ in 0..100 {
                // SAFETY: there is none, and that is what it is for.
                unsafe { *shared.item(0) += worker as u64 };
                barrier.wait();
            }
        });
    }
}
