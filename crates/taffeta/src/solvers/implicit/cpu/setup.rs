//! The system of a Newton step: blocks, diagonals and right side on the finest level, blocks and diagonals on others.

use crate::contact::colliders::predicted_contact::PredictedContact;
use crate::cpu::simd::Kernel;
use crate::real::{Real, Symmetric};
use crate::solvers::implicit::cpu::columns::View;
use crate::solvers::implicit::cpu::elements::OfChunk;
use crate::solvers::implicit::cpu::kernels::{COARSE, FINE, Lanes, store};
use crate::solvers::implicit::cpu::tables::{Table, own_of_children};
use crate::solvers::implicit::implicit::{Stiff, add_weighted, block, diagonal, inverse};
use crate::solvers::implicit::slots::NO_EDGE;
use crate::topology::LANES;
use std::ops::Range;

/// Kernel: what springs give the nodes of a chunk.
pub struct SetUp<'a, T> {
    pub part: Range<usize>,
    pub table: &'a Table<T>,
    pub body: usize,
    /// By slot: rest length [m] and material; materials over the step.
    pub rest: &'a [T],
    pub material: &'a [u32],
    pub stiff: &'a [Stiff<T>],
    /// Places [m] and velocities [m/s] to start from.
    pub moved: View<'a, T>,
    pub mass: &'a [T],
    pub inverse_mass: &'a [T],
    pub predicted: &'a [PredictedContact<T>],
    /// Springs' impulse [N s]; inverse diagonal; mass and what holds a node, for coarser levels; blocks of the chunk's
    /// slots.
    pub right: [&'a mut [T]; 3],
    pub inverse: [&'a mut [T]; 6],
    pub own: [&'a mut [T]; 6],
    pub blocks: &'a mut [T],
    /// Other elements that are solved for.
    pub elements: Option<OfChunk<'a, T>>,
}

/// What is summed up for a slice.
struct Slice<T> {
    right: Lanes<T>,
    diagonal: [[T; LANES]; 6],
}

impl<T: Real> Kernel for SetUp<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(mut self) {
        let start = self.table.slots.starts[self.part.start / LANES] as usize;
        for first in self.part.clone().step_by(LANES) {
            let mut slice = self.add_up(first, start);
            self.add_elements(first, &mut slice);
            self.finish(first, &slice);
        }
    }
}

impl<T: Real> SetUp<'_, T> {
    /// Blocks of a slice, and their sums. `start`: groups of slots before the chunk's.
    #[inline(always)]
    fn add_up(&mut self, first: usize, start: usize) -> Slice<T> {
        let (slots, body) = (&self.table.slots, &self.table.bodies[self.body]);
        let groups = slots.starts[first / LANES] as usize..slots.starts[first / LANES + 1] as usize;
        let shifts = &slots.shifts[self.body];
        let [x, y, z, u, v, w]: [[T; LANES]; 6] = self.moved.lanes(first);
        let Stiff { h, hh, .. } = self.stiff[0];
        let mut sum = Slice { right: [[T::ZERO; LANES]; 3], diagonal: [[T::ZERO; LANES]; 6] };
        for group in groups.clone() {
            let from = group * LANES;
            let neighbours: &[u32; LANES] = slots.neighbour[from..].first_chunk().expect("whole groups");
            let other: [[T; LANES]; 6] = match shifts.get(group - groups.start) {
                // Where there is no spring, one of no stiffness leads to some other node of the body.
                Some(&shift) => self.moved.beside(first, body, shift, neighbours),
                None => self.moved.gather(neighbours),
            };
            let rest: &[T; LANES] = self.rest[from..].first_chunk().expect("whole groups");
            let stiff = self.stiff_of(self.material[from..].first_chunk().expect("whole groups"));
            let out = (group - start) * FINE * LANES;
            let blocks: &mut [[T; LANES]; FINE] =
                self.blocks[out..].as_chunks_mut::<LANES>().0.first_chunk_mut().expect("whole groups");
            for lane in 0..LANES {
                let d = [other[0][lane] - x[lane], other[1][lane] - y[lane], other[2][lane] - z[lane]];
                let dv = [other[3][lane] - u[lane], other[4][lane] - v[lane], other[5][lane] - w[lane]];
                let of_lane = Stiff { k: stiff[0][lane], e: stiff[1][lane], axial: stiff[2][lane], h, hh };
                let spring = of_lane.spring(d, rest[lane]);
                let numbers = [spring.q[0], spring.q[1], spring.q[2], spring.across];
                for (column, number) in blocks.iter_mut().zip(numbers) {
                    column[lane] = number;
                }
                let impulse = of_lane.impulse(&spring, dv);
                for axis in 0..3 {
                    sum.right[axis][lane] += impulse * spring.along[axis];
                }
                for (column, number) in sum.diagonal.iter_mut().zip(block(spring.q, spring.across)) {
                    column[lane] += number;
                }
            }
        }
        sum
    }

    /// k, e and h² k + h e of a group's springs, which are mostly of one material.
    #[inline(always)]
    fn stiff_of(&self, material: &[u32; LANES]) -> [[T; LANES]; 3] {
        let of = |one: u32| &self.stiff[one as usize];
        let first = of(material[0]);
        let mut all = [[first.k; LANES], [first.e; LANES], [first.axial; LANES]];
        if material.iter().any(|&one| one != material[0]) {
            for (lane, &one) in material.iter().enumerate() {
                let Stiff { k, e, axial, .. } = *of(one);
                (all[0][lane], all[1][lane], all[2][lane]) = (k, e, axial);
            }
        }
        all
    }

    /// Adds what other elements give the nodes of a slice.
    #[inline(always)]
    fn add_elements(&mut self, first: usize, slice: &mut Slice<T>) {
        let Some(elements) = &mut self.elements else { return };
        let (impulse, diagonal) = elements.set_up(first / LANES);
        for (sum, numbers) in
            slice.right.iter_mut().zip(&impulse).chain(slice.diagonal.iter_mut().zip(&diagonal))
        {
            for (sum, &number) in sum.iter_mut().zip(numbers) {
                *sum += number;
            }
        }
        elements.put_sum(first / LANES, &slice.diagonal);
    }

    /// Diagonal and right side of a slice's nodes, as they are free.
    #[inline(always)]
    fn finish(&mut self, first: usize, slice: &Slice<T>) {
        let at = first - self.part.start;
        store(&mut self.right, at, &slice.right);
        for lane in 0..LANES {
            let place = first + lane;
            let mut all: Symmetric<T> = std::array::from_fn(|one| slice.diagonal[one][lane]);
            let mass = self.mass[place];
            (0..3).for_each(|one| all[one] += mass);
            let is_free = self.inverse_mass[place] > T::ZERO;
            let predicted = self.predicted.get(place).copied().unwrap_or(PredictedContact::FREE);
            let (own, inverse) = diagonal(&all, mass, is_free, &predicted);
            for one in 0..6 {
                self.inverse[one][at + lane] = inverse[one];
                self.own[one][at + lane] = own[one];
            }
        }
    }
}

/// What a coarser level gathers its blocks from.
pub enum Finer<'a, T> {
    /// q and the stiffness across.
    Fine(&'a [T]),
    /// Symmetric matrices.
    Coarse(&'a [T]),
}

/// Kernel: blocks and diagonals of a chunk of a coarser level.
pub struct Coarsen<'a, T> {
    pub part: Range<usize>,
    pub table: &'a Table<T>,
    pub finer: Finer<'a, T>,
    /// What is on the diagonal of the finer level beside edges.
    pub finer_own: View<'a, T>,
    /// What contacts add to diagonals.
    pub contacts: Option<View<'a, T>>,
    pub inverse: [&'a mut [T]; 6],
    pub own: [&'a mut [T]; 6],
    pub blocks: &'a mut [T],
}

impl<T: Real> Kernel for Coarsen<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let slots = &self.table.slots;
        let start = slots.starts[self.part.start / LANES] as usize;
        for first in self.part.clone().step_by(LANES) {
            let groups = slots.starts[first / LANES] as usize..slots.starts[first / LANES + 1] as usize;
            for lane in 0..LANES {
                let own = own_of_children(&self.table.children, &self.finer_own, first + lane);
                let mut diagonal = own;
                for group in groups.clone() {
                    let block = self.block(group * LANES + lane, start);
                    for one in 0..6 {
                        diagonal[one] += block[one];
                        self.blocks[((group - start) * COARSE + one) * LANES + lane] = block[one];
                    }
                }
                if let Some(contacts) = &self.contacts {
                    diagonal = add_weighted(diagonal, T::ONE, contacts.at(first + lane));
                }
                let (at, inverse) = (first - self.part.start + lane, inverse(&diagonal));
                for one in 0..6 {
                    self.own[one][at] = own[one];
                    self.inverse[one][at] = inverse[one];
                }
            }
        }
    }
}

impl<T: Real> Coarsen<'_, T> {
    /// The block of a slot, where those of the chunk start at group `start`. An edge has the same at both of its ends, so it is found
    /// once where both are in the chunk: that with the lower number comes first.
    #[inline(always)]
    fn block(&self, slot: usize, start: usize) -> Symmetric<T> {
        let slots = &self.table.slots;
        let edge = slots.edge[slot];
        let first = if edge == NO_EDGE { slot } else { slots.of_edge[edge as usize] as usize };
        if first == slot || first < start * LANES {
            return self.gather_block(edge);
        }
        let (group, lane) = (first / LANES - start, first % LANES);
        std::array::from_fn(|one| self.blocks[(group * COARSE + one) * LANES + lane])
    }

    #[inline(always)]
    fn gather_block(&self, edge: u32) -> Symmetric<T> {
        let mut sum = [T::ZERO; 6];
        if edge == NO_EDGE {
            return sum;
        }
        for &(slot, weight) in self.table.sources.row(edge as usize) {
            let (group, lane) = (slot as usize / LANES, slot as usize % LANES);
            let source: Symmetric<T> = match self.finer {
                Finer::Fine(blocks) => {
                    let at = |one: usize| blocks[(group * FINE + one) * LANES + lane];
                    block([at(0), at(1), at(2)], at(3))
                }
                Finer::Coarse(blocks) => {
                    std::array::from_fn(|one| blocks[(group * COARSE + one) * LANES + lane])
                }
            };
            sum = add_weighted(sum, T::from_f64(f64::from(weight)), source);
        }
        sum
    }
}

/// Kernel: what followers leave of a right side, for a chunk of a coarser level.
pub struct Restrict<'a, T> {
    pub part: Range<usize>,
    pub table: &'a Table<T>,
    pub finer: View<'a, T>,
    pub out: [&'a mut [T]; 3],
}

impl<T: Real> Kernel for Restrict<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let mut out = self.out;
        for place in self.part.clone() {
            let mut sum = [T::ZERO; 3];
            for &(child, weight) in self.table.children.row(place) {
                sum = add_weighted(sum, T::from_f64(f64::from(weight)), self.finer.at(child as usize));
            }
            for (column, number) in out.iter_mut().zip(sum) {
                column[place - self.part.start] = number;
            }
        }
    }
}
