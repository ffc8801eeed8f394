//! Drivers that take the CPU's formulas of blocks of elements through the GPU's arrays.

use crate::gpu::layout::Four;
use crate::real::{Real, add, sub};
use crate::solvers::dual::twin::three;
use crate::solvers::implicit::couplings::{
    Block, block_times, coupling, jacobi_factor, symmetric_part, whole,
};
use crate::solvers::implicit::gpu_layout::{Diagonal, LevelGroup, Vector};
use crate::solvers::implicit::gpu_tables::{ROW, SPRING};
use crate::solvers::implicit::implicit::{add_weighted, block, inverse};
use crate::solvers::implicit::twin::{Twin, record, six};

/// The arrays that kernels of elements work on beside those of springs.
#[derive(Clone, Default)]
pub struct OfElements {
    /// As [`CouplingWords`](crate::solvers::implicit::gpu_tables::CouplingWords); none where springs alone are solved for.
    pub words: Vec<[u32; 4]>,
    pub forces: Vec<Four>,
    pub directions: Vec<Four>,
}

impl Twin<'_> {
    /// Where the blocks of a node begin.
    fn blocks(&self, node: usize) -> impl Iterator<Item = usize> + use<> {
        let [first, count, ..] = self.work.elements.words[node].map(|word| word as usize);
        (1..=count).map(move |slot| first + 3 * ROW * slot)
    }

    fn block(&self, at: usize) -> Block<f32> {
        let row = |row: usize| self.work.elements.words[at + row * ROW];
        let [a, b, c] = [row(0), row(1), row(2)];
        [a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]].map(f32::from_bits)
    }

    fn put_block(&mut self, at: usize, block: &Block<f32>) {
        for (row, numbers) in block.as_chunks::<3>().0.iter().enumerate() {
            let words = &mut self.work.elements.words[at + row * ROW];
            (0..3).for_each(|column| words[column] = numbers[column].to_bits());
        }
    }

    /// Keeps the sum of a node's blocks.
    pub fn keep_sum(&mut self, node: usize, sum: [f32; 6]) {
        let first = self.work.elements.words[node][0];
        if first > 0 {
            self.put_block(first as usize, &whole(&sum));
        }
    }

    /// The node at the other end of a block.
    fn other(&self, at: usize) -> usize {
        self.work.elements.words[at][3] as usize
    }

    /// What a block is made of.
    fn sources(&self, at: usize) -> Vec<[u32; 2]> {
        let words = &self.work.elements.words;
        let range = words[at + ROW][3] as usize..words[at + 2 * ROW][3] as usize;
        self.all_sources()[range].to_vec()
    }

    fn all_sources(&self) -> &[[u32; 2]] {
        self.fixture.tables.multigrid.couplings.as_ref().map_or(&[], |couplings| &couplings.sources)
    }

    /// A sum, and the product of a node's blocks with a vector.
    pub fn add_coupled(&self, sum: [f32; 3], which: Vector, node: usize) -> [f32; 3] {
        let own = self.get(which, node);
        self.blocks(node).fold(sum, |sum, at| {
            add(sum, block_times(&self.block(at), sub(own, self.get(which, self.other(at)))))
        })
    }

    /// Blocks of the finest level, their sum, and impulses.
    pub fn set_up_couplings(&mut self) {
        for (node, _) in self.finest() {
            let [_, _, from, to] = self.work.elements.words[node].map(|word| word as usize);
            let mut impulse = [0.0; 3];
            for [force, _] in &self.all_sources()[from..to] {
                impulse = add_weighted(
                    impulse,
                    self.solving.inner,
                    three(self.work.elements.forces[*force as usize]),
                );
            }
            let mut all = [0.0; 6];
            for at in self.blocks(node) {
                let mut block = [0.0; 9];
                for source in self.sources(at) {
                    let [a, b] = source.map(|one| self.work.elements.directions[one as usize]);
                    block = add_mode(block, a, b);
                }
                self.put_block(at, &block);
                all = add_weighted(all, 1.0, symmetric_part(&block));
            }
            self.put(Vector::Impulse, node, impulse);
            self.work.diagonals[node].own = record(all);
        }
    }

    fn spring_block(&self, slot: usize) -> Block<f32> {
        let [x, y, z, across] = self.work.blocks[slot];
        whole(&block([x, y, z], across))
    }

    /// Blocks and diagonals of a coarser level.
    pub fn coarsen_couplings(&mut self, groups: &[LevelGroup]) {
        for (node, _) in Self::nodes(groups) {
            let mut own = [0.0; 6];
            for (child, weight) in self.children(node) {
                own = add_weighted(own, weight, six(&self.work.diagonals[child].own));
            }
            let mut all = [0.0; 6];
            for at in self.blocks(node) {
                let mut sum = [0.0; 9];
                for [source, weight] in self.sources(at) {
                    let finer = if source & SPRING != 0 {
                        self.spring_block((source & !SPRING) as usize)
                    } else {
                        self.block(source as usize)
                    };
                    sum = add_weighted(sum, f32::from_bits(weight), finer);
                }
                self.put_block(at, &sum);
                all = add_weighted(all, 1.0, symmetric_part(&sum));
            }
            self.keep_sum(node, all);
            let diagonal = add_weighted(own, 1.0, all);
            self.work.diagonals[node] = Diagonal { own: record(own), inverse: record(inverse(&diagonal)) };
        }
    }

    /// What inverses are multiplied by.
    pub fn bound_couplings(&mut self, groups: &[LevelGroup]) {
        for (node, _) in Self::nodes(groups) {
            let [_, _, from, to] = self.work.elements.words[node];
            let factor = if from == to { 1.0 } else { jacobi_factor(self.couplings_of(node)) };
            self.put(Vector::Product, node, [factor, 0.0, 0.0]);
        }
    }

    /// The sum of a node's couplings, springs first.
    fn couplings_of(&self, node: usize) -> f32 {
        let inverse = |node: usize| six(&self.work.diagonals[node].inverse);
        let own = inverse(node);
        let springs = if node < self.fixture.tables.len() { self.slots(node) } else { Vec::new() };
        let of_springs = springs
            .iter()
            .fold(0.0, |sum, &(slot, other)| sum + coupling(&own, &self.spring_block(slot), &inverse(other)));
        self.blocks(node)
            .fold(of_springs, |sum, at| sum + coupling(&own, &self.block(at), &inverse(self.other(at))))
    }

    pub fn scale_inverses(&mut self, groups: &[LevelGroup]) {
        for (node, _) in Self::nodes(groups) {
            let factor = self.get(Vector::Product, node)[0];
            let inverse = six(&self.work.diagonals[node].inverse).map(|number| number * factor);
            self.work.diagonals[node].inverse = record(inverse);
        }
    }
}

/// Some blocks, in place of all that there are: `number` gives numbers.
pub fn any_blocks(words: &mut [[u32; 4]], nodes: usize, mut number: impl FnMut() -> f32) {
    for node in 0..nodes {
        let [first, count, ..] = words[node].map(|word| word as usize);
        if first == 0 {
            continue;
        }
        for row in (0..3 * (count + 1)).map(|row| first + row * ROW) {
            (0..3).for_each(|column| words[row][column] = number().to_bits());
        }
    }
}

/// Adds what a mode with directions `a` here and `b` at the other node gives a block; their fourth numbers are weights of what
/// resists alike in all directions.
#[inline(always)]
pub(super) fn add_mode<T: Real>(mut block: Block<T>, a: [T; 4], b: [T; 4]) -> Block<T> {
    for row in 0..3 {
        for column in 0..3 {
            block[3 * row + column] -= a[row] * b[column];
        }
        block[4 * row] -= a[3] * b[3];
    }
    block
}
