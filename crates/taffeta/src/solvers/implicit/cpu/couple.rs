//! What a worker finds of elements in each Newton step.

use crate::cpu::simd::Kernel;
use crate::elements::lanes::{Lanes, lane_of};
use crate::elements::sets::Elements;
use crate::real::Real;
use crate::solvers::implicit::couplings::{coupling, jacobi_factor, whole};
use crate::solvers::implicit::cpu::ImplicitWorker;
use crate::solvers::implicit::cpu::assembled::Sets;
use crate::solvers::implicit::cpu::columns::View;
use crate::solvers::implicit::cpu::elements::{BLOCK, Coarsen, Coupled, ElementBlocks, OfChunk, groups};
use crate::solvers::implicit::cpu::galerkin::Half;
use crate::solvers::implicit::cpu::kernels::FINE;
use crate::solvers::implicit::cpu::tables::Chunk;
use crate::solvers::implicit::implicit::block;
use crate::solvers::implicit::slots::Slots;
use crate::topology::{Csr, LANES};
use std::ops::Range;

impl<T: Real> ImplicitWorker<'_, '_, T> {
    /// Elements that are solved for.
    fn solved_sets(&self) -> &Sets<T> {
        self.worker.features.get::<Elements<T>>().map_or(&[], Elements::solved)
    }

    /// Finds forces and directions of all elements where the Newton step starts.
    pub fn linearise(&self) {
        if self.multigrid.elements.is_none() {
            return;
        }
        // SAFETY: what was moved was written before a barrier.
        let moved = unsafe { self.shared.moved.read() };
        let state: [&[T]; 6] = std::array::from_fn(|axis| moved.column(axis));
        if let Some(elements) = self.worker.features.get::<Elements<T>>() {
            elements.linearise(self.worker, &state, self.h);
        }
        self.worker.synchronise();
    }

    /// What elements give a chunk of the finest level.
    pub fn set_up_elements(&self, part: &Range<usize>) -> Option<OfChunk<'_, T>> {
        let elements = self.multigrid.elements.as_ref()?;
        Some(elements.chunk(part, self.solved_sets(), self.worker.nodes.level, self.h))
    }

    /// Finds blocks of A P of a chunk of a level, where P leads to the next coarser one.
    pub fn multiply_by_weights(&self, elements: &ElementBlocks<T>, level: usize, chunk: &Chunk) {
        let (part, product) = (chunk.part.clone(), &elements.products[level]);
        // SAFETY: blocks were found before a barrier; chunks do not overlap.
        let kernel = unsafe {
            Half {
                product,
                finer: elements.blocks[level].read(),
                springs: self.shared.levels[level].blocks.read(),
                out: elements.half.write(product.slots(&part)),
                part,
            }
        };
        self.worker.nodes.level.run(kernel);
    }

    /// Finds blocks and diagonals of a chunk of a coarser level.
    pub fn coarsen_elements(&self, elements: &ElementBlocks<T>, level: usize, chunk: &Chunk) {
        let part = &chunk.part;
        let (finer, here) = (&self.shared.levels[level - 1], &self.shared.levels[level]);
        let couplings = &elements.tables.coarser[level - 1];
        let slots = groups(couplings, part);
        // SAFETY: the finer level and A P were found before barriers; chunks do not overlap.
        let kernel = unsafe {
            Coarsen {
                part: part.clone(),
                couplings,
                children: &self.multigrid.tables[level].children,
                half: elements.half.read(),
                finer_own: finer.own.read(),
                contacts: self.shares_of_contacts(level),
                inverse: here.inverse.write(part),
                own: here.own.write(part),
                blocks: elements.blocks[level].write(slots.start * BLOCK * LANES..slots.end * BLOCK * LANES),
            }
        };
        self.worker.nodes.level.run(kernel);
    }

    /// Scales the inverses of all levels so that Jacobi's iteration converges.
    pub fn scale_jacobi(&mut self) {
        let Some(elements) = &self.multigrid.elements else { return };
        for level in 0..self.multigrid.tables.len() {
            self.each(level, |worker, chunk| {
                if elements.has(chunk.body) {
                    worker.find_factors(elements, level, chunk);
                }
            });
        }
        self.worker.synchronise();
        for level in 0..self.multigrid.tables.len() {
            self.each(level, |worker, chunk| {
                if !elements.has(chunk.body) {
                    return;
                }
                // SAFETY: only this chunk's places; others read after a barrier.
                let (factors, inverse) = unsafe {
                    (
                        elements.factors[level].read(),
                        worker.shared.levels[level].inverse.write::<6>(&chunk.part),
                    )
                };
                let factors = &factors.column(0)[chunk.part.clone()];
                for column in inverse {
                    column.iter_mut().zip(factors).for_each(|(number, &factor)| *number = *number * factor);
                }
            });
        }
        self.worker.synchronise();
    }

    fn find_factors(&self, elements: &ElementBlocks<T>, level: usize, chunk: &Chunk) {
        let (table, here) = (&self.multigrid.tables[level], &self.shared.levels[level]);
        // SAFETY: blocks and inverses were found before a barrier; only this chunk's factors.
        let kernel = unsafe {
            let [out] = elements.factors[level].write::<1>(&chunk.part);
            FindFactors {
                part: chunk.part.clone(),
                inverse: here.inverse.read(),
                slots: &table.slots,
                springs: here.blocks.read(),
                coupled: elements.coupled(level),
                around: (level == 0).then_some(&elements.tables.forces),
                out,
            }
        };
        self.worker.nodes.level.run(kernel);
    }
}

/// Kernel: what inverses are multiplied by, of a chunk.
struct FindFactors<'a, T> {
    part: Range<usize>,
    inverse: View<'a, T>,
    slots: &'a Slots,
    springs: &'a [T],
    coupled: Coupled<'a, T>,
    /// Forces of elements on each place, of the finest level.
    around: Option<&'a Csr>,
    out: &'a mut [T],
}

impl<T: Real> Kernel for FindFactors<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { part, inverse, slots, springs, coupled, around, out } = self;
        for (first, out) in part.step_by(LANES).zip(out.chunks_exact_mut(LANES)) {
            let slice = first / LANES;
            let (own, mut sum): ([Lanes<T>; 6], Lanes<T>) = (inverse.lanes(first), [T::ZERO; LANES]);
            for group in slots.starts[slice] as usize..slots.starts[slice + 1] as usize {
                let block = spring_lanes(springs, group);
                add(&inverse, (&own, &block), places(&slots.neighbour, group), false, &mut sum);
            }
            let groups = coupled.starts[slice] as usize..coupled.starts[slice + 1] as usize;
            for group in groups.skip(1) {
                let block = &coupled.blocks[group * BLOCK * LANES..(group + 1) * BLOCK * LANES];
                let block = block.as_chunks::<LANES>().0.first_chunk().expect("nine numbers a block");
                let in_row = coupled.in_row[group];
                add(&inverse, (&own, block), places(coupled.neighbour, group), in_row, &mut sum);
            }
            for (lane, (out, &sum)) in out.iter_mut().zip(&sum).enumerate() {
                // Springs alone: no more than 2 times the diagonal.
                let alone = around.is_some_and(|around| around.row(first + lane).is_empty());
                *out = if alone { T::ONE } else { jacobi_factor(sum) };
            }
        }
    }
}

/// Adds couplings of a group of blocks.
#[inline(always)]
fn add<T: Real>(
    inverse: &View<'_, T>,
    (own, block): (&[Lanes<T>; 6], &[Lanes<T>; BLOCK]),
    places: &[u32; LANES],
    in_row: bool,
    sum: &mut Lanes<T>,
) {
    let other: [Lanes<T>; 6] =
        if in_row { inverse.lanes(places[0] as usize) } else { inverse.gather(places) };
    for (lane, sum) in sum.iter_mut().enumerate() {
        *sum += coupling(&lane_of(own, lane), &lane_of(block, lane), &lane_of(&other, lane));
    }
}

/// The other nodes of a group of slots.
#[inline(always)]
fn places(neighbour: &[u32], group: usize) -> &[u32; LANES] {
    neighbour[group * LANES..].first_chunk().expect("whole groups")
}

/// The blocks of a group of springs.
#[inline(always)]
fn spring_lanes<T: Real>(springs: &[T], group: usize) -> [Lanes<T>; BLOCK] {
    let numbers = springs[group * FINE * LANES..(group + 1) * FINE * LANES].as_chunks::<LANES>().0;
    let mut blocks = [[T::ZERO; LANES]; BLOCK];
    for lane in 0..LANES {
        let all = whole(&block([numbers[0][lane], numbers[1][lane], numbers[2][lane]], numbers[3][lane]));
        for one in 0..BLOCK {
            blocks[one][lane] = all[one];
        }
    }
    blocks
}
