//! Elements that are solved for beside springs: blocks between their nodes on all levels.

use crate::assembly::Assembly;
use crate::cpu::column::Column;
use crate::cpu::shared::Shared;
use crate::cpu::simd::{Kernel, SimdLevel};
use crate::real::Real;
use crate::solvers::implicit::coarsening::Weighted;
use crate::solvers::implicit::couplings::{Block, Couplings, Tables, block_times, symmetric_part, whole};
use crate::solvers::implicit::cpu::assembled::{Assembled, KindDirections, Sets, directions};
use crate::solvers::implicit::cpu::columns::{Columns, View};
use crate::solvers::implicit::cpu::galerkin::{Coarse, Product};
use crate::solvers::implicit::cpu::kernels::Lanes;
use crate::solvers::implicit::cpu::tables::{CHUNK, Table, own_of_children};
use crate::solvers::implicit::implicit::{add_weighted, inverse};
use crate::solvers::implicit::levels::Level;
use crate::topology::LANES;
use std::ops::Range;

/// Numbers of a block.
pub(super) const BLOCK: usize = 9;

/// Tables, and what is found again in each Newton step.
pub struct ElementBlocks<T> {
    pub(super) tables: Tables,
    /// What blocks of the finest level are made of, and those of coarser ones.
    assembled: Assembled,
    pub(super) products: Vec<Product<T>>,
    /// Whether each body has some.
    pub(super) bodies: Vec<bool>,
    /// By level: the block of each slot, and what Jacobi's iteration multiplies a diagonal's inverse by.
    pub(super) blocks: Vec<Shared<T>>,
    pub(super) factors: Vec<Columns<T>>,
    /// Blocks of A P, of one level at a time.
    pub(super) half: Shared<Block<T>>,
}

impl<T: Real> ElementBlocks<T> {
    /// Those of a scene that has elements to solve for, on the finest level and on coarser ones.
    pub fn new(assembly: &Assembly, levels: &[Level], tables: &[Table<T>]) -> Option<Self> {
        let bodies = 0..assembly.bodies.len();
        let mut couplings = Tables::of_finest(assembly, &bodies)?;
        let assembled = Assembled::new(assembly, &couplings);
        couplings.finest.forget_sources();
        let mut products = Vec::new();
        for (number, level) in levels.iter().enumerate() {
            let is_solved = |place: usize| {
                assembly.has_solved_elements(level.bodies.partition_point(|nodes| nodes.end <= place))
            };
            let coarse = Coarse { level, is_solved: &is_solved };
            let (product, coarser) = match number.checked_sub(1) {
                None => Product::new(&couplings.finest, Some(&tables[0].slots), &coarse),
                Some(finer) => Product::new(&couplings.coarser[finer], None, &coarse),
            };
            products.push(product);
            couplings.coarser.push(coarser);
        }
        let slots = [couplings.finest.len()].into_iter().chain(couplings.coarser.iter().map(Couplings::len));
        let half = products.iter().map(Product::len).max().unwrap_or(0);
        Some(Self {
            blocks: slots.map(|count| Column::zeros(BLOCK * count).into()).collect(),
            factors: tables.iter().map(|table| Columns::new(1, table.places)).collect(),
            half: vec![[T::ZERO; BLOCK]; half].into(),
            bodies: bodies.map(|body| assembly.has_solved_elements(body)).collect(),
            assembled,
            products,
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
        let products = self.products.iter().map(Product::bytes).sum::<usize>();
        let found = self.blocks.iter().map(Shared::bytes).sum::<usize>()
            + self.factors.iter().map(Columns::bytes).sum::<usize>()
            + self.half.bytes();
        self.tables.finest.bytes() + self.assembled.bytes() + products + coarser + found
    }

    /// The blocks of a level, to multiply by.
    pub fn coupled(&self, level: usize) -> Coupled<'_, T> {
        let (starts, neighbour, in_row) = match level.checked_sub(1) {
            None => self.tables.finest.lists(),
            Some(coarser) => self.tables.coarser[coarser].lists(),
        };
        // SAFETY: found before a barrier, and found again after another.
        Coupled { starts, neighbour, in_row, blocks: unsafe { self.blocks[level].read() } }
    }

    /// What a chunk of the finest level is set up from.
    pub fn chunk<'a>(
        &'a self,
        part: &Range<usize>,
        sets: &'a Sets<T>,
        level: SimdLevel,
        h: T,
    ) -> OfChunk<'a, T> {
        let groups = groups(&self.tables.finest, part);
        let mut impulses = [[[T::ZERO; LANES]; 3]; CHUNK / LANES];
        for (impulse, first) in impulses.iter_mut().zip(part.clone().step_by(LANES)) {
            sets.iter().for_each(|set| set.gather(level, first..first + LANES, impulse));
            for number in impulse.iter_mut().flatten() {
                *number = h * *number;
            }
        }
        // SAFETY: elements were linearised before a barrier; chunks do not overlap.
        unsafe {
            OfChunk {
                couplings: &self.tables.finest,
                assembled: &self.assembled,
                directions: directions(sets),
                impulses,
                first: part.start / LANES,
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

/// Keeps the block of a slot.
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
    pub(super) in_row: &'a [bool],
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
        let in_row = &self.in_row[groups];
        for ((places, block), &in_row) in neighbours.iter().zip(blocks.as_chunks::<BLOCK>().0).zip(in_row) {
            let other: Lanes<T> =
                if in_row { vector.lanes(places[0] as usize) } else { vector.gather(places) };
            let [[x, y, z], [a, b, c]] = [own, &other];
            let [xx, xy, xz, yx, yy, yz, zx, zy, zz] = block;
            for lane in 0..LANES {
                let d = [x[lane] - a[lane], y[lane] - b[lane], z[lane] - c[lane]];
                let block = [
                    xx[lane], xy[lane], xz[lane], yx[lane], yy[lane], yz[lane], zx[lane], zy[lane], zz[lane],
                ];
                let product = block_times(&block, d);
                sum[0][lane] += product[0];
                sum[1][lane] += product[1];
                sum[2][lane] += product[2];
            }
        }
    }
}

/// What a chunk of the finest level is set up from, and its blocks.
pub struct OfChunk<'a, T> {
    couplings: &'a Couplings<[u32; 2]>,
    assembled: &'a Assembled,
    directions: KindDirections<'a, T>,
    /// Of elements on the nodes of each slice [N s].
    impulses: [Lanes<T>; CHUNK / LANES],
    /// Slices and groups of slots before the chunk's.
    first: usize,
    start: usize,
    blocks: &'a mut [T],
}

impl<T: Real> OfChunk<'_, T> {
    /// Finds the blocks of a slice of nodes; returns their impulses [N s] and the sums of their blocks.
    #[inline(always)]
    pub fn set_up(&mut self, slice: usize) -> (Lanes<T>, [[T; LANES]; 6]) {
        let mut diagonal = [[T::ZERO; LANES]; 6];
        for group in self.couplings.blocks(slice) {
            let block = self.assembled.block(group, &self.directions);
            add_symmetric_part(&block, &mut diagonal);
            self.put(group, &block);
        }
        (self.impulses[slice - self.first], diagonal)
    }

    /// Keeps the sums of all blocks of a slice of nodes, those of springs among them.
    #[inline(always)]
    pub fn put_sum(&mut self, slice: usize, sum: &[[T; LANES]; 6]) {
        let groups = self.couplings.groups(slice);
        if !groups.is_empty() {
            let [xx, yy, zz, xy, xz, yz] = *sum;
            self.put(groups.start, &[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
        }
    }

    #[inline(always)]
    fn put(&mut self, group: usize, block: &[[T; LANES]; BLOCK]) {
        let from = (group - self.start) * BLOCK * LANES;
        self.blocks[from..from + BLOCK * LANES].copy_from_slice(block.as_flattened());
    }
}

/// Adds the symmetric parts of blocks, by lanes.
#[inline(always)]
fn add_symmetric_part<T: Real>(block: &[[T; LANES]; BLOCK], sum: &mut [[T; LANES]; 6]) {
    let half = T::from_f64(0.5);
    for (sum, one) in sum.iter_mut().zip([0, 4, 8]) {
        for lane in 0..LANES {
            sum[lane] += block[one][lane];
        }
    }
    for (sum, (one, other)) in sum[3..].iter_mut().zip([(1, 3), (2, 6), (5, 7)]) {
        for lane in 0..LANES {
            sum[lane] += half * (block[one][lane] + block[other][lane]);
        }
    }
}

/// Kernel: blocks and diagonals of a chunk of a coarser level.
pub(super) struct Coarsen<'a, T> {
    pub(super) part: Range<usize>,
    pub(super) couplings: &'a Couplings<(u32, f32)>,
    pub(super) children: &'a Weighted,
    /// Blocks of A P.
    pub(super) half: &'a [Block<T>],
    pub(super) finer_own: View<'a, T>,
    /// What contacts add to diagonals.
    pub(super) contacts: Option<View<'a, T>>,
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
                    sum = add_weighted(sum, T::from_f64(f64::from(weight)), self.half[slot as usize]);
                }
                put_block(self.blocks, at_slot(group), &sum);
                all = add_weighted(all, T::ONE, symmetric_part(&sum));
            }
            if !groups.is_empty() {
                put_block(self.blocks, at_slot(groups.start), &whole(&all));
            }
            let mut diagonal = add_weighted(own, T::ONE, all);
            if let Some(contacts) = &self.contacts {
                diagonal = add_weighted(diagonal, T::ONE, contacts.at(place));
            }
            let inverse = inverse(&diagonal);
            for one in 0..6 {
                self.own[one][at] = own[one];
                self.inverse[one][at] = inverse[one];
            }
        }
    }
}
