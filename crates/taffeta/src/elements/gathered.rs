//! Forces of elements added up by node, sixteen nodes at a time.

use crate::cpu::places::{Groups, Places};
use crate::cpu::simd::Kernel;
use crate::elements::lanes::{Forces, Lanes};
use crate::real::Real;
use crate::topology::{Csr, LANES};
use std::ops::Range;

/// Which forces nodes gather, in groups of [`LANES`]: one for each node of a slice.
pub struct Gathered {
    /// Groups before each slice; one more than there are slices.
    starts: Vec<u32>,
    places: Groups,
    /// By slice: blocks of elements, from the first to the last.
    around: Vec<Range<u32>>,
}

/// By slice of places: the blocks of the elements around it, from the first to the last; by place there are `each`·element + node.
pub fn around(by_node: &Csr, each: usize) -> Vec<Range<u32>> {
    let of_slice = |slice: usize| {
        let places = slice..by_node.rows().min(slice + LANES);
        let corners = places.flat_map(|place| by_node.row(place));
        let blocks = corners.map(|&corner| corner / (each * LANES) as u32);
        blocks.fold(0..0, |all: Range<u32>, one| {
            if all.is_empty() { one..one + 1 } else { all.start.min(one)..all.end.max(one + 1) }
        })
    };
    (0..by_node.rows()).step_by(LANES).map(of_slice).collect()
}

impl Gathered {
    /// Of `by_node`: for each place N·element + node.
    pub fn new<T: Real, const N: usize>(by_node: &Csr, forces: &Forces<T, N>, blocks: usize) -> Self {
        let around = around(by_node, N);
        let mut all = Self { starts: vec![0], places: Groups::default(), around };
        for slice in (0..by_node.rows()).step_by(LANES) {
            let row =
                |lane: usize| if slice + lane < by_node.rows() { by_node.row(slice + lane) } else { &[] };
            let longest = (0..LANES).map(|lane| row(lane).len()).max().unwrap_or(0);
            for k in 0..longest {
                let place = |lane: usize| match row(lane).get(k) {
                    Some(&corner) => forces.place(corner as usize / N, corner as usize % N) as u32,
                    None => forces.nowhere(blocks),
                };
                all.places.push(std::array::from_fn(place));
            }
            all.starts.push(all.places.len() as u32);
        }
        all
    }

    /// Blocks of the elements around a slice of nodes.
    pub fn around(&self, slice: usize) -> Range<usize> {
        let Range { start, end } = self.around[slice];
        start as usize..end as usize
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        12 * self.starts.len() + self.places.bytes()
    }
}

/// Kernel: adds to the sums of a slice of nodes the forces of the elements around them, in order.
pub struct Gather<'a, T> {
    /// Which forces.
    pub gathered: &'a Gathered,
    /// Which slice.
    pub slice: usize,
    /// Forces, and from one axis to the next.
    pub forces: &'a [T],
    pub stride: usize,
    /// The sums.
    pub sum: &'a mut [Lanes<T>; 3],
}

impl<T: Real> Kernel for Gather<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { gathered, slice, forces, stride, sum: out } = self;
        let mut sum = *out;
        let groups = gathered.starts[slice] as usize..gathered.starts[slice + 1] as usize;
        for group in groups {
            let places = gathered.places.places(group);
            for (axis, sum) in sum.iter_mut().enumerate() {
                let column = &forces[axis * stride..];
                match places {
                    Places::Run(first) => {
                        for (sum, &force) in sum.iter_mut().zip(&column[first..first + LANES]) {
                            *sum += force;
                        }
                    }
                    Places::List(places) => {
                        for (sum, &place) in sum.iter_mut().zip(places) {
                            *sum += column[place as usize];
                        }
                    }
                }
            }
        }
        *out = sum;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_gather_what_is_theirs_in_the_order_of_elements() {
        // Two edges in the first block, one in the second; node 2 has all three.
        let mut edges = vec![[0, 1]; LANES + 1];
        (edges[0], edges[3], edges[LANES]) = ([0, 2], [2, 1], [2, 17]);
        let by_node = Csr::corners(20, &edges);
        let forces = Forces::<f64, 2>::new(2);
        let gathered = Gathered::new(&by_node, &forces, 2);
        // SAFETY: nobody else has them.
        let columns = unsafe { forces.write(&(0..2)) };
        for (node, axes) in columns.into_iter().enumerate() {
            for (axis, column) in axes.into_iter().enumerate() {
                for (element, force) in column.iter_mut().enumerate() {
                    *force = (100 * element + 10 * node + axis) as f64;
                }
            }
        }
        let sum = |slice, axis: usize| {
            // SAFETY: as above.
            let all = unsafe { forces.read() };
            let mut sum = [[0.0; LANES]; 3];
            Gather { gathered: &gathered, slice, forces: all, stride: forces.stride(), sum: &mut sum }.run();
            sum[axis]
        };
        assert_eq!(sum(0, 1)[2], 11.0 + 301.0 + 1601.0);
        assert_eq!((sum(1, 2)[1], sum(1, 2)[2], sum(0, 0)[7]), (1612.0, 0.0, 0.0));
    }
}
