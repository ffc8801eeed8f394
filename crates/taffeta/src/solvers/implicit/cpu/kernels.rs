//! Passes of the multigrid cycle over the nodes of a chunk.

use crate::contact::colliders::predicted_contact::PredictedContact;
use crate::contact::triangles::cpu::solved::ContactBlocks;
use crate::cpu::simd::Kernel;
use crate::cpu::sums::Sums;
use crate::real::{Real, times};
use crate::solvers::implicit::cpu::coarse_contacts::CoarseBlocks;
use crate::solvers::implicit::cpu::columns::View;
use crate::solvers::implicit::cpu::elements::Coupled;
use crate::solvers::implicit::cpu::tables::Parents;
use crate::solvers::implicit::implicit::{edge_times, jacobi};
use crate::topology::LANES;
use std::ops::Range;

/// Numbers of a level's block for one slot: q and the stiffness across on the finest, a symmetric matrix on others.
pub const FINE: usize = 4;
pub const COARSE: usize = 6;

/// A level's matrix on the nodes of a chunk.
#[derive(Clone, Copy)]
pub struct Operator<'a, T> {
    pub starts: &'a [u32],
    pub neighbour: &'a [u32],
    /// Distances of neighbours, of a grid.
    pub shifts: &'a [i32],
    /// Places of the body.
    pub body: &'a Range<usize>,
    /// Block of each slot.
    pub blocks: &'a [T],
    pub own: Own<'a, T>,
    /// Blocks of other elements.
    pub coupled: Option<Coupled<'a, T>>,
    /// Contacts of surfaces, on the finest level and on others.
    pub contacts: Option<ContactBlocks<'a, T>>,
    pub coarse_contacts: Option<CoarseBlocks<'a, T>>,
}

/// What is on the diagonal beside edges.
#[derive(Clone, Copy)]
pub enum Own<'a, T> {
    /// Masses [kg], of the finest level.
    Mass(&'a [T]),
    /// Blocks.
    Block(View<'a, T>),
    /// Nothing: edges alone.
    None,
}

/// Three numbers for each lane.
pub type Lanes<T> = [[T; LANES]; 3];

impl<T: Real> Operator<'_, T> {
    /// The matrix times a vector on a slice, and the vector there.
    #[inline(always)]
    pub fn slice<const C: usize>(&self, slice: usize, vector: &View<'_, T>) -> (Lanes<T>, Lanes<T>) {
        let first = slice * LANES;
        let own: Lanes<T> = vector.lanes(first);
        let mut sum = self.diagonal(first, &own);
        let groups = self.starts[slice] as usize..self.starts[slice + 1] as usize;
        let neighbours = self.neighbour[groups.start * LANES..groups.end * LANES].as_chunks::<LANES>().0;
        let blocks = &self.blocks[groups.start * C * LANES..groups.end * C * LANES];
        if self.shifts.is_empty() {
            for (places, block) in neighbours.iter().zip(blocks.chunks_exact(C * LANES)) {
                add_edges::<T, C>(&own, &vector.gather(places), block, &mut sum);
            }
        } else {
            let slots = neighbours.iter().zip(blocks.chunks_exact(C * LANES));
            for (&shift, (places, block)) in self.shifts.iter().zip(slots) {
                let other = vector.beside(first, self.body, shift, places);
                add_edges::<T, C>(&own, &other, block, &mut sum);
            }
        }
        if let Some(coupled) = &self.coupled {
            coupled.add_product(slice, vector, &own, &mut sum);
        }
        if let Some(contacts) = &self.contacts {
            contacts.add_product(slice, &mut sum);
        }
        if let Some(contacts) = &self.coarse_contacts {
            contacts.add_product(slice, vector, &own, &mut sum);
        }
        (sum, own)
    }

    #[inline(always)]
    fn diagonal(&self, first: usize, vector: &Lanes<T>) -> Lanes<T> {
        let mut sum = [[T::ZERO; LANES]; 3];
        match self.own {
            Own::Mass(mass) => {
                let mass: &[T; LANES] = mass[first..].first_chunk().expect("whole slices");
                for axis in 0..3 {
                    for lane in 0..LANES {
                        sum[axis][lane] = mass[lane] * vector[axis][lane];
                    }
                }
            }
            Own::Block(own) => {
                let own: [[T; LANES]; 6] = own.lanes(first);
                add_product(&own, vector, &mut sum);
            }
            Own::None => {}
        }
        sum
    }
}

/// Adds what edges with a block each contribute.
#[inline(always)]
pub fn add_edges<T: Real, const C: usize>(own: &Lanes<T>, other: &Lanes<T>, block: &[T], sum: &mut Lanes<T>) {
    let numbers = block.as_chunks::<LANES>().0;
    if C == FINE {
        let [x, y, z, across] = [&numbers[0], &numbers[1], &numbers[2], &numbers[3]];
        for lane in 0..LANES {
            let d =
                [own[0][lane] - other[0][lane], own[1][lane] - other[1][lane], own[2][lane] - other[2][lane]];
            let product = edge_times([x[lane], y[lane], z[lane]], across[lane], d);
            sum[0][lane] += product[0];
            sum[1][lane] += product[1];
            sum[2][lane] += product[2];
        }
    } else {
        let mut d = [[T::ZERO; LANES]; 3];
        for axis in 0..3 {
            for lane in 0..LANES {
                d[axis][lane] = own[axis][lane] - other[axis][lane];
            }
        }
        let matrix: &[[T; LANES]; 6] = numbers.first_chunk().expect("six numbers a slot");
        add_product(matrix, &d, sum);
    }
}

/// Adds a symmetric matrix times a vector, by lanes.
#[inline(always)]
fn add_product<T: Real>(m: &[[T; LANES]; 6], v: &Lanes<T>, sum: &mut Lanes<T>) {
    for lane in 0..LANES {
        let matrix = [m[0][lane], m[1][lane], m[2][lane], m[3][lane], m[4][lane], m[5][lane]];
        let product = times(&matrix, [v[0][lane], v[1][lane], v[2][lane]]);
        sum[0][lane] += product[0];
        sum[1][lane] += product[1];
        sum[2][lane] += product[2];
    }
}

/// Adds a step of Jacobi's iteration, by lanes.
#[inline(always)]
fn add_step<T: Real>(inverse: &[[T; LANES]; 6], residual: &Lanes<T>, sum: &mut Lanes<T>) {
    for lane in 0..LANES {
        let m = inverse;
        let matrix = [m[0][lane], m[1][lane], m[2][lane], m[3][lane], m[4][lane], m[5][lane]];
        let step = jacobi(&matrix, [residual[0][lane], residual[1][lane], residual[2][lane]]);
        sum[0][lane] += step[0];
        sum[1][lane] += step[1];
        sum[2][lane] += step[2];
    }
}

/// Which directions nodes are free in, on the finest level.
#[derive(Clone, Copy)]
pub struct Hold<'a, T> {
    /// By place the inverse mass [1/kg]; 0: held. Empty: all are free.
    pub inverse_mass: &'a [T],
    /// By place: how a surface holds it. Empty: nothing does.
    pub predicted: &'a [PredictedContact<T>],
}

impl<T: Real> Hold<'_, T> {
    /// A vector on a slice, as far as nodes yield to it.
    #[inline(always)]
    pub fn filtered(&self, first: usize, vector: &mut Lanes<T>) {
        if let Some(inverse_mass) = self.inverse_mass.get(first..first + LANES) {
            for axis in vector.iter_mut() {
                for (number, &inverse_mass) in axis.iter_mut().zip(inverse_mass) {
                    *number = if inverse_mass > T::ZERO { *number } else { T::ZERO };
                }
            }
        }
        if self.predicted.is_empty() {
            return;
        }
        for (lane, predicted) in self.predicted[first..first + LANES].iter().enumerate() {
            let filtered = predicted.filtered([vector[0][lane], vector[1][lane], vector[2][lane]]);
            for axis in 0..3 {
                vector[axis][lane] = filtered[axis];
            }
        }
    }
}

/// Writes a slice's lanes to a chunk's columns.
#[inline(always)]
pub fn store<T: Real, const N: usize>(out: &mut [&mut [T]; N], at: usize, lanes: &[[T; LANES]; N]) {
    for (out, lanes) in out.iter_mut().zip(lanes) {
        out[at..at + LANES].copy_from_slice(lanes);
    }
}

/// Kernel: what a vector leaves of a right side, right − A vector.
pub struct Residual<'a, T, const C: usize> {
    pub part: Range<usize>,
    pub operator: Operator<'a, T>,
    pub hold: Hold<'a, T>,
    pub right: View<'a, T>,
    pub vector: View<'a, T>,
    pub out: [&'a mut [T]; 3],
}

impl<T: Real, const C: usize> Kernel for Residual<'_, T, C> {
    type Output = ();
    #[inline(always)]
    fn run(mut self) {
        for first in self.part.clone().step_by(LANES) {
            let (product, _) = self.operator.slice::<C>(first / LANES, &self.vector);
            let mut residual: Lanes<T> = self.right.lanes(first);
            for axis in 0..3 {
                for lane in 0..LANES {
                    residual[axis][lane] -= product[axis][lane];
                }
            }
            self.hold.filtered(first, &mut residual);
            store(&mut self.out, first - self.part.start, &residual);
        }
    }
}

/// Kernel: a step of Jacobi's iteration.
pub struct Smooth<'a, T, const C: usize> {
    pub part: Range<usize>,
    pub operator: Operator<'a, T>,
    /// Inverse of each diagonal block.
    pub inverse: View<'a, T>,
    pub right: View<'a, T>,
    pub vector: View<'a, T>,
    pub out: [&'a mut [T]; 3],
}

impl<T: Real, const C: usize> Kernel for Smooth<'_, T, C> {
    type Output = ();
    #[inline(always)]
    fn run(mut self) {
        for first in self.part.clone().step_by(LANES) {
            let (product, mut vector) = self.operator.slice::<C>(first / LANES, &self.vector);
            let mut residual: Lanes<T> = self.right.lanes(first);
            for axis in 0..3 {
                for lane in 0..LANES {
                    residual[axis][lane] -= product[axis][lane];
                }
            }
            add_step(&self.inverse.lanes(first), &residual, &mut vector);
            store(&mut self.out, first - self.part.start, &vector);
        }
    }
}

/// Kernel: the first step of Jacobi's iteration, from 0.
pub struct Begin<'a, T> {
    pub part: Range<usize>,
    pub inverse: View<'a, T>,
    pub right: [&'a [T]; 3],
    pub out: [&'a mut [T]; 3],
}

impl<T: Real> Kernel for Begin<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(mut self) {
        for first in self.part.clone().step_by(LANES) {
            let at = first - self.part.start;
            let mut right = [[T::ZERO; LANES]; 3];
            for (lanes, column) in right.iter_mut().zip(&self.right) {
                lanes.copy_from_slice(&column[at..at + LANES]);
            }
            let mut vector = [[T::ZERO; LANES]; 3];
            add_step(&self.inverse.lanes(first), &right, &mut vector);
            store(&mut self.out, at, &vector);
        }
    }
}

/// Kernel: the matrix times a vector.
pub struct Apply<'a, T> {
    pub part: Range<usize>,
    pub operator: Operator<'a, T>,
    pub hold: Hold<'a, T>,
    pub vector: View<'a, T>,
    pub other: View<'a, T>,
    pub out: [&'a mut [T]; 3],
}

impl<T: Real> Kernel for Apply<'_, T> {
    /// The vector times another, and times the product.
    type Output = [f64; 2];
    #[inline(always)]
    fn run(mut self) -> [f64; 2] {
        let mut sums = [Sums::ZERO; 2];
        for first in self.part.clone().step_by(LANES) {
            let (mut product, vector) = self.operator.slice::<FINE>(first / LANES, &self.vector);
            self.hold.filtered(first, &mut product);
            let other: Lanes<T> = self.other.lanes(first);
            for axis in 0..3 {
                sums[0].add(&vector[axis], &other[axis]);
                sums[1].add(&vector[axis], &product[axis]);
            }
            store(&mut self.out, first - self.part.start, &product);
        }
        sums.map(|sum| sum.total())
    }
}

/// Kernel: adds what nodes follow of a coarser level's vector.
pub struct Interpolate<'a, T> {
    pub part: Range<usize>,
    /// By slice of the level.
    pub parents: &'a [Parents<T>],
    pub hold: Hold<'a, T>,
    pub coarser: View<'a, T>,
    pub out: [&'a mut [T]; 3],
}

impl<T: Real> Kernel for Interpolate<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let mut out = self.out;
        for first in self.part.clone().step_by(LANES) {
            let mut sum = [[T::ZERO; LANES]; 3];
            let Parents { nodes, weights } = &self.parents[first / LANES];
            for (nodes, weights) in nodes.iter().zip(weights) {
                let followed: Lanes<T> = self.coarser.gather(nodes);
                for axis in 0..3 {
                    for lane in 0..LANES {
                        sum[axis][lane] += weights[lane] * followed[axis][lane];
                    }
                }
            }
            self.hold.filtered(first, &mut sum);
            let at = first - self.part.start;
            for (column, lanes) in out.iter_mut().zip(&sum) {
                for (number, &lane) in column[at..at + LANES].iter_mut().zip(lanes) {
                    *number += lane;
                }
            }
        }
    }
}

/// Kernel: a step of conjugate gradients.
pub struct Advance<'a, T> {
    pub alpha: T,
    pub beta: T,
    pub x: [&'a mut [T]; 3],
    pub r: [&'a mut [T]; 3],
    pub p: [&'a mut [T]; 3],
    pub s: [&'a mut [T]; 3],
    /// The preconditioned residual, and the system times it.
    pub z: [&'a [T]; 3],
    pub w: [&'a [T]; 3],
}

impl<T: Real> Kernel for Advance<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let (alpha, beta) = (self.alpha, self.beta);
        for axis in 0..3 {
            let (z, w) = (self.z[axis], self.w[axis]);
            let n = z.len();
            let (x, r) = (&mut self.x[axis][..n], &mut self.r[axis][..n]);
            let (p, s) = (&mut self.p[axis][..n], &mut self.s[axis][..n]);
            for i in 0..n {
                p[i] = z[i] + beta * p[i];
                s[i] = w[i] + beta * s[i];
                x[i] += alpha * p[i];
                r[i] -= alpha * s[i];
            }
        }
    }
}
