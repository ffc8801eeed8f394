//! Elements that are solved for beside springs: blocks between their nodes on all levels.

use crate::assembly::Assembly;
use crate::cpu::column::Column;
use crate::cpu::shared::Shared;
use crate::cpu::simd::Kernel;
use crate::real::Real;
use crate::solvers::implicit::coarsening::Weighted;
use crate::solvers::implicit::couplings::{
    Block, Couplings, Springs, Tables, add_mode, block_times, symmetric_part, whole,
};
use crate::solvers::implicit::cpu::columns::{Columns, View};
use crate::solvers::implicit::cpu::kernels::{FINE, Lanes};
use crate::solvers::implicit::cpu::tables::{Table, own_of_children};
use crate::solvers::implicit::implicit::{Symmetric, add_weighted, block, inverse};
use crate::topology::{Csr, LANES};
use std::ops::Range;

/// Numbers of a block.
pub(super) const BLOCK: usize = 9;

/// Tables, and what is found again in each Newton step.
pub struct ElementBlocks<T> {
    pub(super) tables: Tables,
    /// Whether each body has some.
    pub(super) bodies: Vec<bool>,
    /// By level: the block of each slot, and what Jacobi's iteration multiplies a diagonal's inverse by.
    pub(super) blocks: Vec<Shared<T>>,
    pub(super) factors: Vec<Columns<T>>,
    /// Of each element: forces [N] where the Newton step starts, and directions [kg^½].
    pub(super) forces: Shared<[T; 3]>,
    pub(super) directions: Shared<[T; 3]>,
}

impl<T: Real> ElementBlocks<T> {
    /// Those of a scene that has elements to solve for.
    pub fn new(assembly: &Assembly, tables: &[Table<T>]) -> Option<Self> {
        let bodies = 0..assembly.bodies.len();
        let couplings = Tables::new(assembly, &bodies, &tables[0].slots, Springs::Beside)?;
        let slots = [couplings.finest.len()].into_iter().chain(couplings.coarser.iter().map(Couplings::len));
        let [forces, directions] = couplings.counts().map(|count| vec![[T::ZERO; 3]; count].into());
        Some(Self {
            blocks: slots.map(|count| Column::zeros(BLOCK * count).into()).collect(),
            factors: tables.iter().map(|table| Columns::new(1, table.places, 0)).collect(),
            forces,
            directions,
            bodies: bodies.map(|body| assembly.has_solved_elements(body)).collect(),
            tables: couplings,
        })
    }

    /// Whether a body has some.
    pub fn has(&self, body: usize) -> bool {
        self.bodies[body]
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        let coarser = self.tables.coarser.iter().map(Couplings::bytes).sum::<usize>();
        let found = self.blocks.iter().map(Shared::bytes).sum::<usize>()
            + self.factors.iter().map(Columns::bytes).sum::<usize>()
            + (self.forces.len() + self.directions.len()) * size_of::<[T; 3]>();
        self.tables.finest.bytes() + coarser + found
    }

    /// The blocks of a level, to multiply by.
    pub fn coupled(&self, level: usize) -> Coupled<'_, T> {
        let (starts, neighbour) = match level.checked_sub(1) {
            None => (&self.tables.finest.starts, &self.tables.finest.neighbour),
            Some(coarser) => {
                let couplings = &self.tables.coarser[coarser];
                (&couplings.starts, &couplings.neighbour)
            }
        };
        // SAFETY: found before a barrier, and found again after another.
        Coupled { starts, neighbour, blocks: unsafe { self.blocks[level].read() } }
    }

    /// What a chunk of the finest level is set up from.
    pub fn chunk(&self, part: &Range<usize>, h: T) -> OfChunk<'_, T> {
        let groups = groups(&self.tables.finest, part);
        // SAFETY: elements were linearised before a barrier; chunks do not overlap.
        unsafe {
            OfChunk {
                couplings: &self.tables.finest,
                forces_of: &self.tables.forces,
                forces: self.forces.read(),
                directions: self.directions.read(),
                h,
                start: groups.start,
                blocks: self.blocks[0].write(groups.start * BLOCK * LANES..groups.end * BLOCK * LANES),
            }
        }
    }
}

/// Groups of slots of some places.
pub(super) fn groups<S: Copy>(couplings: &Couplings<S>, part: &Range<usize>) -> Range<usize> {
    couplings.starts[part.start / LANES] as usize..couplings.starts[part.end / LANES] as usize
}

/// The block of a slot.
#[inline(always)]
pub(super) fn block_at<T: Real>(blocks: &[T], slot: usize) -> Block<T> {
    let (group, lane) = (slot / LANES, slot % LANES);
    std::array::from_fn(|one| blocks[(group * BLOCK + one) * LANES + lane])
}

#[inline(always)]
fn put_block<T: Real>(blocks: &mut [T], slot: usize, block: &Block<T>) {
    let (group, lane) = (slot / LANES, slot % LANES);
    for (one, number) in block.iter().enumerate() {
        blocks[(group * BLOCK + one) * LANES + lane] = *number;
    }
}

/// Blocks of a level.
#[derive(Clone, Copy)]
pub struct Coupled<'a, T> {
    pub(super) starts: &'a [u32],
    pub(super) neighbour: &'a [u32],
    pub(super) blocks: &'a [T],
}

impl<T: Real> Coupled<'_, T> {
    /// Adds the product of a slice's blocks with a vector.
    #[inline(always)]
    pub fn add_product(&self, slice: usize, vector: &View<'_, T>, own: &Lanes<T>, sum: &mut Lanes<T>) {
        let (start, end) = (self.starts[slice] as usize, self.starts[slice + 1] as usize);
        let groups = (start + 1).min(end)..end;
        let neighbours = self.neighbour[groups.start * LANES..groups.end * LANES].as_chunks::<LANES>().0;
        let blocks =
            self.blocks[groups.start * BLOCK * LANES..groups.end * BLOCK * LANES].as_chunks::<LANES>().0;
        for (places, block) in neighbours.iter().zip(blocks.as_chunks::<BLOCK>().0) {
            let other: Lanes<T> = vector.gather(places);
            for lane in 0..LANES {
                let d = [0, 1, 2].map(|axis| own[axis][lane] - other[axis][lane]);
                let product = block_times(&std::array::from_fn(|one| block[one][lane]), d);
                for axis in 0..3 {
                    sum[axis][lane] += product[axis];
                }
            }
        }
    }
}

/// What a chunk of the finest level is set up from, and its blocks.
pub struct OfChunk<'a, T> {
    couplings: &'a Couplings<[u32; 2]>,
    forces_of: &'a Csr,
    forces: &'a [[T; 3]],
    directions: &'a [[T; 3]],
    h: T,
    /// Groups of slots before the chunk's.
    start: usize,
    blocks: &'a mut [T],
}

impl<T: Real> OfChunk<'_, T> {
    /// Finds the blocks of a node; returns its impulse [N s] and the sum of the blocks.
    #[inline(always)]
    pub fn set_up(&mut self, node: usize) -> ([T; 3], Symmetric<T>) {
        let (mut impulse, mut diagonal) = ([T::ZERO; 3], [T::ZERO; 6]);
        for &force in self.forces_of.row(node) {
            impulse = add_weighted(impulse, self.h, self.forces[force as usize]);
        }
        for group in self.couplings.blocks(node / LANES) {
            let mut block = [T::ZERO; BLOCK];
            for &[a, b] in self.couplings.sources(group * LANES + node % LANES) {
                block = add_mode(block, self.directions[a as usize], self.directions[b as usize]);
            }
            self.put(group, node, &block);
            diagonal = add_weighted(diagonal, T::ONE, symmetric_part(&block));
        }
        (impulse, diagonal)
    }

    /// Keeps the sum of all blocks of a node, those of springs among them.
    #[inline(always)]
    pub fn put_sum(&mut self, node: usize, sum: &Symmetric<T>) {
        let groups = self.couplings.groups(node / LANES);
        if !groups.is_empty() {
            self.put(groups.start, node, &whole(sum));
        }
    }

    #[inline(always)]
    fn put(&mut self, group: usize, node: usize, block: &Block<T>) {
        put_block(self.blocks, (group - self.start) * LANES + node % LANES, block);
    }
}

/// Kernel: blocks and diagonals of a chunk of a coarser level.
pub(super) struct Coarsen<'a, T> {
    pub(super) part: Range<usize>,
    pub(super) couplings: &'a Couplings<(u32, f32)>,
    pub(super) children: &'a Weighted,
    /// Blocks of the finer level, and those of springs behind so many slots of it.
    pub(super) finer: &'a [T],
    pub(super) springs: &'a [T],
    pub(super) slots: usize,
    pub(super) finer_own: View<'a, T>,
    pub(super) inverse: [&'a mut [T]; 6],
    pub(super) own: [&'a mut [T]; 6],
    pub(super) blocks: &'a mut [T],
}

impl<T: Real> Kernel for Coarsen<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let start = groups(self.couplings, &self.part).start;
        for (at, place) in self.part.clone().enumerate() {
            let own = own_of_children(self.children, &self.finer_own, place);
            let (mut all, groups) = ([T::ZERO; 6], self.couplings.groups(place / LANES));
            let at_slot = |group: usize| (group - start) * LANES + place % LANES;
            for group in self.couplings.blocks(place / LANES) {
                let mut sum = [T::ZERO; BLOCK];
                for &(slot, weight) in self.couplings.sources(group * LANES + place % LANES) {
                    sum = add_weighted(sum, T::from_f64(f64::from(weight)), self.finer_block(slot as usize));
                }
                put_block(self.blocks, at_slot(group), &sum);
                all = add_weighted(all, T::ONE, symmetric_part(&sum));
            }
            if !groups.is_empty() {
                put_block(self.blocks, at_slot(groups.start), &whole(&all));
            }
            let diagonal = add_weighted(own, T::ONE, all);
            let inverse = inverse(&diagonal);
            for one in 0..6 {
                self.own[one][at] = own[one];
                self.inverse[one][at] = inverse[one];
            }
        }
    }
}

impl<T: Real> Coarsen<'_, T> {
    #[inline(always)]
    fn finer_block(&self, slot: usize) -> Block<T> {
        slot.checked_sub(self.slots)
            .map_or_else(|| block_at(self.finer, slot), |slot| spring_block(self.springs, slot))
    }
}

/// The block of a spring's slot.
#[inline(always)]
pub(super) fn spring_block<T: Real>(blocks: &[T], slot: usize) -> Block<T> {
    let at = |one: usize| blocks[(slot / LANES * FINE + one) * LANES + slot % LANES];
    whole(&block([at(0), at(1), at(2)], at(3)))
}
