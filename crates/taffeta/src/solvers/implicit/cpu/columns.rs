//! Several numbers a node, one column each, with a margin on both sides.

use crate::cpu::column::Column;
use crate::cpu::shared::Shared;
use crate::real::Real;
use crate::topology::LANES;
use std::ops::Range;

/// Lines between the starts of columns, beyond what they need: columns that are walked through together must not fall on
/// the same sets of the cache.
const STAGGER: usize = 5;

/// Where columns are in their memory.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// From one column to the next.
    stride: usize,
    /// Numbers before the first place: neighbours in a grid are read by their distance, beyond its rim, too.
    lead: usize,
}

/// Columns of numbers by place.
pub struct Columns<T> {
    data: Shared<T>,
    shape: Shape,
}

/// The same, to read.
#[derive(Clone, Copy)]
pub struct View<'a, T> {
    data: &'a [T],
    shape: Shape,
}

impl<T: Real> Columns<T> {
    /// Zeros by `places`, `lead` more before and behind.
    pub fn new(axes: usize, places: usize, lead: usize) -> Self {
        let lead = lead.next_multiple_of(LANES);
        let stride = (places + 2 * lead).next_multiple_of(LANES) + STAGGER * LANES;
        Self { data: Column::zeros(axes * stride).into(), shape: Shape { stride, lead } }
    }

    /// Sets one number.
    pub fn set(&mut self, axis: usize, place: usize, number: T) {
        self.data.get_mut()[axis * self.shape.stride + self.shape.lead + place] = number;
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        self.data.bytes()
    }
}

impl<T> Columns<T> {
    /// All of them, to read.
    ///
    /// # Safety
    /// As of [`Shared::read`].
    pub unsafe fn read(&self) -> View<'_, T> {
        // SAFETY: promised by the caller.
        View { data: unsafe { self.data.read() }, shape: self.shape }
    }

    /// The numbers of one place.
    ///
    /// # Safety
    /// As of [`Shared::read`], of this place.
    pub unsafe fn get<const N: usize>(&self, place: usize) -> [T; N]
    where
        T: Real,
    {
        // SAFETY: promised by the caller.
        unsafe { self.read() }.at(place)
    }

    /// Sets the numbers of one place.
    ///
    /// # Safety
    /// As of [`Shared::write`].
    pub unsafe fn put<const N: usize>(&self, place: usize, numbers: [T; N])
    where
        T: Real,
    {
        // SAFETY: promised by the caller.
        let columns = unsafe { self.write::<N>(&(place..place + 1)) };
        columns.into_iter().zip(numbers).for_each(|(column, number)| column[0] = number);
    }

    /// Some places of each column, to write.
    ///
    /// # Safety
    /// As of [`Shared::write`].
    #[expect(clippy::mut_from_ref, reason = "the caller promises that the reference is unique")]
    pub unsafe fn write<const N: usize>(&self, part: &Range<usize>) -> [&mut [T]; N] {
        let from = |axis: usize| axis * self.shape.stride + self.shape.lead;
        // SAFETY: promised by the caller; columns do not overlap.
        std::array::from_fn(|axis| unsafe { self.data.write(from(axis) + part.start..from(axis) + part.end) })
    }
}

impl<'a, T: Real> View<'a, T> {
    /// Numbers of a slice of places.
    #[inline(always)]
    pub fn lanes<const N: usize>(&self, start: usize) -> [[T; LANES]; N] {
        self.lanes_from::<N>(start as isize)
    }

    /// Numbers of sixteen places from one on, which may lie in the margin.
    #[inline(always)]
    pub fn lanes_from<const N: usize>(&self, start: isize) -> [[T; LANES]; N] {
        let mut lanes = [[T::ZERO; LANES]; N];
        for (axis, lanes) in lanes.iter_mut().enumerate() {
            let from = ((axis * self.shape.stride + self.shape.lead) as isize + start) as usize;
            lanes.copy_from_slice(&self.data[from..from + LANES]);
        }
        lanes
    }

    /// Numbers of sixteen places.
    #[inline(always)]
    pub fn gather<const N: usize>(&self, places: &[u32; LANES]) -> [[T; LANES]; N] {
        let mut lanes = [[T::ZERO; LANES]; N];
        for (axis, lanes) in lanes.iter_mut().enumerate() {
            let column = &self.data[axis * self.shape.stride + self.shape.lead..];
            for (lane, &place) in lanes.iter_mut().zip(places) {
                *lane = column[place as usize];
            }
        }
        lanes
    }

    /// One column.
    pub fn column(&self, axis: usize) -> &'a [T] {
        &self.data[axis * self.shape.stride + self.shape.lead..(axis + 1) * self.shape.stride]
    }

    /// Numbers of one place.
    #[inline(always)]
    pub fn at<const N: usize>(&self, place: usize) -> [T; N] {
        std::array::from_fn(|axis| self.data[axis * self.shape.stride + self.shape.lead + place])
    }
}
