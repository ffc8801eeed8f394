//! Several numbers a node, one column each.

use crate::cpu::column::Column;
use crate::cpu::shared::Shared;
use crate::real::Real;
use crate::topology::LANES;
use std::ops::Range;

/// Lines between the starts of columns, beyond what they need: columns that are walked through together must not fall on
/// the same sets of the cache.
const STAGGER: usize = 5;

/// Columns of numbers by place.
pub struct Columns<T> {
    data: Shared<T>,
    /// From one column to the next.
    stride: usize,
}

/// The same, to read.
#[derive(Clone, Copy)]
pub struct View<'a, T> {
    data: &'a [T],
    /// From one column to the next.
    stride: usize,
}

impl<T: Real> Columns<T> {
    /// Zeros by `places`.
    pub fn new(axes: usize, places: usize) -> Self {
        let stride = places.next_multiple_of(LANES) + STAGGER * LANES;
        Self { data: Column::zeros(axes * stride).into(), stride }
    }

    /// Sets one number.
    pub fn set(&mut self, axis: usize, place: usize, number: T) {
        self.data.get_mut()[axis * self.stride + place] = number;
    }

    /// Multiplies all numbers.
    pub fn scale(&mut self, by: T) {
        self.data.get_mut().iter_mut().for_each(|number| *number = by * *number);
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
        View { data: unsafe { self.data.read() }, stride: self.stride }
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
        let from = |axis: usize| axis * self.stride;
        // SAFETY: promised by the caller; columns do not overlap.
        std::array::from_fn(|axis| unsafe { self.data.write(from(axis) + part.start..from(axis) + part.end) })
    }
}

impl<'a, T: Real> View<'a, T> {
    /// Numbers of sixteen places from one on.
    #[inline(always)]
    pub fn lanes<const N: usize>(&self, start: usize) -> [[T; LANES]; N] {
        let mut lanes = [[T::ZERO; LANES]; N];
        for (axis, lanes) in lanes.iter_mut().enumerate() {
            let from = axis * self.stride + start;
            lanes.copy_from_slice(&self.data[from..from + LANES]);
        }
        lanes
    }

    /// Numbers of the nodes of a grid that are `shift` further on than sixteen of its places from `first` on, where all of those are
    /// among the places of its body, padding included; else those of `places`, which lists the same nodes, and a node itself where it has
    /// no such neighbour. What lies beyond is another body's, and 0 times what has blown up is no number.
    #[inline(always)]
    pub fn beside<const N: usize>(
        &self,
        first: usize,
        body: &Range<usize>,
        shift: i32,
        places: &[u32; LANES],
    ) -> [[T; LANES]; N] {
        let from = first as isize + shift as isize;
        if from >= body.start as isize && from + LANES as isize <= body.end as isize {
            self.lanes(from as usize)
        } else {
            self.gather(places)
        }
    }

    /// Numbers of sixteen places.
    #[inline(always)]
    pub fn gather<const N: usize>(&self, places: &[u32; LANES]) -> [[T; LANES]; N] {
        let mut lanes = [[T::ZERO; LANES]; N];
        for (axis, lanes) in lanes.iter_mut().enumerate() {
            let column = &self.data[axis * self.stride..];
            for (lane, &place) in lanes.iter_mut().zip(places) {
                *lane = column[place as usize];
            }
        }
        lanes
    }

    /// One column.
    pub fn column(&self, axis: usize) -> &'a [T] {
        &self.data[axis * self.stride..(axis + 1) * self.stride]
    }

    /// Numbers of one place.
    #[inline(always)]
    pub fn at<const N: usize>(&self, place: usize) -> [T; N] {
        std::array::from_fn(|axis| self.data[axis * self.stride + place])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three bodies of 48 places, of which the middle one alone has numbers.
    #[test]
    fn neighbours_of_a_grid_are_of_its_body_alone() {
        let mut columns = Columns::new(1, 144);
        for place in 0..144 {
            columns.set(0, place, if (48..96).contains(&place) { place as f64 } else { f64::NAN });
        }
        // SAFETY: nobody writes.
        let view = unsafe { columns.read() };
        for first in [48, 64, 80] {
            for shift in -40..=40 {
                let other = |lane: usize| (first + lane).checked_add_signed(shift as isize).unwrap();
                let is_there = |lane: &usize| (48..96).contains(&other(*lane));
                let listed = |lane| if is_there(&lane) { other(lane) as u32 } else { (first + lane) as u32 };
                let places: [u32; LANES] = std::array::from_fn(listed);
                let [found] = view.beside::<1>(first, &(48..96), shift, &places);
                assert_eq!(found, places.map(f64::from), "from {first}, {shift} further on");
            }
        }
    }
}
