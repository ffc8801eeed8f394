//! What a worker finds of elements in each Newton step.

use crate::elements::cpu::Linearised;
use crate::elements::sets::Elements;
use crate::real::Real;
use crate::solvers::implicit::couplings::{coupling, jacobi_factor};
use crate::solvers::implicit::cpu::ImplicitWorker;
use crate::solvers::implicit::cpu::elements::{
    BLOCK, Coarsen, ElementBlocks, block_at, groups, spring_block,
};
use crate::solvers::implicit::cpu::tables::Chunk;
use crate::solvers::implicit::implicit::Symmetric;
use crate::topology::LANES;

impl<T: Real> ImplicitWorker<'_, '_, T> {
    /// Finds forces and directions of all elements where the Newton step starts.
    pub fn linearise(&self) {
        let (Some(blocks), Some(sets)) =
            (&self.primal.elements, self.worker.features.get::<Elements<T>>().map(Elements::solved))
        else {
            return;
        };
        // SAFETY: what was moved was written before a barrier.
        let moved = unsafe { self.shared.moved.read() };
        let state: [&[T]; 6] = std::array::from_fn(|axis| moved.column(axis));
        for (solved, set) in blocks.tables.solved.iter().zip(sets) {
            let part = self.worker.part(solved.elements.len());
            let of = |first: usize, each: usize| first + each * part.start..first + each * part.end;
            // SAFETY: parts of workers do not overlap, and others read after a barrier.
            let out = unsafe {
                Linearised {
                    forces: blocks.forces.write(of(solved.first_force, solved.forces)),
                    directions: blocks.directions.write(of(solved.first_direction, solved.directions)),
                }
            };
            set.linearise(part, &state, self.h, out);
        }
        self.worker.synchronise();
    }

    /// Finds blocks and diagonals of a chunk of a coarser level.
    pub fn coarsen_elements(&self, elements: &ElementBlocks<T>, level: usize, chunk: &Chunk) {
        let part = &chunk.part;
        let (finer, here) = (&self.shared.levels[level - 1], &self.shared.levels[level]);
        let couplings = &elements.tables.coarser[level - 1];
        let slots = groups(couplings, part);
        // SAFETY: the finer level was found before a barrier; chunks do not overlap.
        let kernel = unsafe {
            let finer_blocks = elements.blocks[level - 1].read();
            Coarsen {
                part: part.clone(),
                couplings,
                children: &self.primal.tables[level].children,
                slots: if level == 1 { elements.tables.finest.len() } else { usize::MAX },
                finer: finer_blocks,
                springs: finer.blocks.read(),
                finer_own: finer.own.read(),
                inverse: here.inverse.write(part),
                own: here.own.write(part),
                blocks: elements.blocks[level].write(slots.start * BLOCK * LANES..slots.end * BLOCK * LANES),
            }
        };
        self.worker.nodes.level.run(kernel);
    }

    /// Scales the inverses of all levels so that Jacobi's iteration converges.
    pub fn scale_jacobi(&mut self) {
        let Some(elements) = &self.primal.elements else { return };
        for level in 0..self.primal.tables.len() {
            self.each(level, |worker, chunk| {
                if elements.has(chunk.body) {
                    worker.find_factors(elements, level, chunk);
                }
            });
        }
        self.worker.synchronise();
        for level in 0..self.primal.tables.len() {
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
        let (table, here) = (&self.primal.tables[level], &self.shared.levels[level]);
        // SAFETY: blocks and inverses were found before a barrier; only this chunk's factors.
        let (inverse, springs, [out]) = unsafe {
            (here.inverse.read(), here.blocks.read(), elements.factors[level].write::<1>(&chunk.part))
        };
        let coupled = elements.coupled(level);
        for (out, place) in out.iter_mut().zip(chunk.part.clone()) {
            if level == 0 && elements.tables.forces.row(place).is_empty() {
                // Springs alone: no more than 2 times the diagonal.
                *out = T::ONE;
                continue;
            }
            let (own, mut sum): (Symmetric<T>, T) = (inverse.at(place), T::ZERO);
            let slots = |starts: &[u32], skipped: usize| {
                let groups = starts[place / LANES] as usize..starts[place / LANES + 1] as usize;
                groups.skip(skipped).map(move |group| group * LANES + place % LANES)
            };
            for slot in slots(&table.slots.starts, 0) {
                let other = inverse.at(table.slots.neighbour[slot] as usize);
                sum += coupling(&own, &spring_block(springs, slot), &other);
            }
            for slot in slots(coupled.starts, 1) {
                let other = inverse.at(coupled.neighbour[slot] as usize);
                sum += coupling(&own, &block_at(coupled.blocks, slot), &other);
            }
            *out = jacobi_factor(sum);
        }
    }
}
