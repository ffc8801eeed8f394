//! Elements in lanes: sixteen at a time, a column for each number, so that formulas are plain loops over lanes.

use crate::cpu::column::Column;
use crate::cpu::places::Groups;
use crate::cpu::shared::Shared;
use crate::cpu::simd::Kernel;
use crate::elements::element::{Element, List};
use crate::real::Real;
use crate::topology::LANES;
use std::collections::HashMap;
use std::collections::hash_map::DefaultHasher;
use std::hash::Hasher;
use std::marker::PhantomData;
use std::ops::Range;

/// One number for each node of a slice, or element of a block.
pub type Lanes<T> = [T; LANES];
/// A vector for each node of the elements of a block.
pub type Vectors<T, const N: usize> = [[Lanes<T>; 3]; N];

/// Lines between the starts of columns: columns that are walked through together must not fall on the same sets of the cache.
pub const STAGGER: usize = 5;

/// Elements in blocks of [`LANES`]; the last block is filled up with its last element.
pub struct Blocks<T, const N: usize, const P: usize> {
    /// Number of elements.
    pub count: usize,
    /// Nodes by solver index: by block, then by node of an element.
    nodes: Groups,
    /// Numbers of blocks, those that are alike once; and which are those of each block.
    numbers: Vec<[Lanes<T>; P]>,
    which: Vec<u32>,
}

impl<T: Real, const N: usize, const P: usize> Blocks<T, N, P> {
    /// Those of a list.
    pub fn new(list: &List) -> Self {
        let (nodes, numbers) = (list.all.nodes.as_chunks::<N>().0, list.all.numbers.as_chunks::<P>().0);
        let mut blocks =
            Self { count: nodes.len(), nodes: Groups::default(), numbers: Vec::new(), which: Vec::new() };
        let mut known = HashMap::new();
        for start in (0..nodes.len()).step_by(LANES) {
            let element = |lane: usize| (start + lane).min(nodes.len() - 1);
            let lanes = |node: usize| std::array::from_fn(|lane| nodes[element(lane)][node]);
            (0..N).for_each(|node| blocks.nodes.push(lanes(node)));
            let of_block = std::array::from_fn(|one| {
                std::array::from_fn(|lane| T::from_f64(numbers[element(lane)][one]))
            });
            blocks.add_numbers(of_block, &mut known);
        }
        blocks
    }

    /// Adds the numbers of a block, if no other has the same. `known`: where those of a hash are.
    fn add_numbers(&mut self, numbers: [Lanes<T>; P], known: &mut HashMap<u64, u32>) {
        let bits =
            |numbers: &[Lanes<T>; P]| numbers.map(|lanes| lanes.map(|number| number.to_f64().to_bits()));
        let mut hasher = DefaultHasher::new();
        bits(&numbers).iter().flatten().for_each(|&one| hasher.write_u64(one));
        let next = self.numbers.len() as u32;
        let found = *known.entry(hasher.finish()).or_insert(next);
        let is_same = self.numbers.get(found as usize).is_some_and(|one| bits(one) == bits(&numbers));
        self.which.push(if is_same { found } else { next });
        if !is_same {
            self.numbers.push(numbers);
        }
    }

    /// Number of blocks.
    pub fn len(&self) -> usize {
        self.which.len()
    }

    /// Numbers of the elements of a block.
    #[inline(always)]
    pub fn numbers(&self, block: usize) -> &[Lanes<T>; P] {
        &self.numbers[self.which[block] as usize]
    }

    /// Three columns at the nodes of a block's elements.
    #[inline(always)]
    pub fn fetch(&self, block: usize, columns: [&[T]; 3], all: &mut Vectors<T, N>) {
        for (node, vectors) in all.iter_mut().enumerate() {
            let places = self.nodes.places(N * block + node);
            for (lanes, column) in vectors.iter_mut().zip(columns) {
                places.fetch(column, lanes);
            }
        }
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        self.nodes.bytes() + size_of_val(&self.numbers[..]) + size_of_val(&self.which[..])
    }
}

/// The nodes of one element, by lane.
#[inline(always)]
pub fn lane<T: Real, const N: usize>(all: &Vectors<T, N>, lane: usize) -> [[T; 3]; N] {
    let mut one = [[T::ZERO; 3]; N];
    for node in 0..N {
        for axis in 0..3 {
            one[node][axis] = all[node][axis][lane];
        }
    }
    one
}

/// The numbers of one element, by lane.
#[inline(always)]
pub fn lane_of<T: Real, const P: usize>(all: &[Lanes<T>; P], lane: usize) -> [T; P] {
    let mut one = [T::ZERO; P];
    for (one, lanes) in one.iter_mut().zip(all) {
        *one = lanes[lane];
    }
    one
}

/// Forces on the nodes of elements [N]: a column for each node and axis.
pub struct Forces<T, const N: usize> {
    columns: Shared<T>,
    stride: usize,
}

impl<T: Real, const N: usize> Forces<T, N> {
    /// Zeros, for so many blocks.
    pub fn new(blocks: usize) -> Self {
        let stride = (blocks + 1 + STAGGER) * LANES;
        Self { columns: Column::zeros(3 * N * stride).into(), stride }
    }

    /// Those of some blocks, to write.
    ///
    /// # Safety
    /// As of [`Shared::write`].
    #[expect(clippy::mut_from_ref, reason = "the caller promises that the reference is unique")]
    pub unsafe fn write(&self, blocks: &Range<usize>) -> [[&mut [T]; 3]; N] {
        let places = blocks.start * LANES..blocks.end * LANES;
        std::array::from_fn(|node| {
            std::array::from_fn(|axis| {
                let from = (3 * node + axis) * self.stride;
                // SAFETY: promised by the caller; columns do not overlap.
                unsafe { self.columns.write(from + places.start..from + places.end) }
            })
        })
    }

    /// All of them, to read.
    ///
    /// # Safety
    /// As of [`Shared::read`].
    pub unsafe fn read(&self) -> &[T] {
        // SAFETY: promised by the caller.
        unsafe { self.columns.read() }
    }

    /// Where the force on a node of an element is, along the first axis.
    pub fn place(&self, element: usize, node: usize) -> usize {
        3 * node * self.stride + element
    }

    /// From one axis to the next.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// Where there is none, for `blocks` blocks.
    pub fn nowhere(&self, blocks: usize) -> u32 {
        (blocks * LANES) as u32
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        self.columns.bytes()
    }
}

/// Kernel: forces on the nodes of blocks of elements, a function of positions and velocities.
pub struct FindForces<'a, T, E, const N: usize, const P: usize> {
    /// The elements.
    pub blocks: &'a Blocks<T, N, P>,
    /// Position and velocity, by axis.
    pub state: [&'a [T]; 6],
    /// Which blocks.
    pub part: Range<usize>,
    /// Forces of these.
    pub out: [[&'a mut [T]; 3]; N],
    /// The formula.
    pub formula: PhantomData<E>,
}

impl<T: Real, E: Element<N, P>, const N: usize, const P: usize> Kernel for FindForces<'_, T, E, N, P> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { blocks, state: [x, y, z, u, v, w], part, mut out, .. } = self;
        let (mut places, mut velocities, mut found) = (none(), none(), none());
        for (at, block) in part.enumerate() {
            blocks.fetch(block, [x, y, z], &mut places);
            blocks.fetch(block, [u, v, w], &mut velocities);
            let numbers = blocks.numbers(block);
            #[allow(clippy::needless_range_loop, reason = "a lane of many columns")]
            for one in 0..LANES {
                let forces = E::forces(lane(&places, one), lane(&velocities, one), lane_of(numbers, one));
                for node in 0..N {
                    for axis in 0..3 {
                        found[node][axis][one] = forces[node][axis];
                    }
                }
            }
            put(&mut out, at, &found);
        }
    }
}

/// Kernel: energy of all elements [J], added up in their order in 64 bits.
pub struct Energy<'a, T, E, const N: usize, const P: usize> {
    /// The elements.
    pub blocks: &'a Blocks<T, N, P>,
    /// Positions, by axis.
    pub places: [&'a [T]; 3],
    /// The formula.
    pub formula: PhantomData<E>,
}

impl<T: Real, E: Element<N, P>, const N: usize, const P: usize> Kernel for Energy<'_, T, E, N, P> {
    type Output = f64;
    #[inline(always)]
    fn run(self) -> f64 {
        let (mut places, mut found, mut sum) = (none(), [T::ZERO; LANES], 0.0);
        for block in 0..self.blocks.len() {
            self.blocks.fetch(block, self.places, &mut places);
            let numbers = self.blocks.numbers(block);
            for (one, energy) in found.iter_mut().enumerate() {
                *energy = E::energy(lane(&places, one), lane_of(numbers, one));
            }
            let count = LANES.min(self.blocks.count - block * LANES);
            found[..count].iter().for_each(|energy| sum += energy.to_f64());
        }
        sum
    }
}

/// Zeros.
#[inline(always)]
pub fn none<T: Real, const A: usize, const N: usize>() -> [[Lanes<T>; A]; N] {
    [[[T::ZERO; LANES]; A]; N]
}

/// Writes the numbers of a block.
#[inline(always)]
pub fn put<T: Real, const A: usize, const N: usize>(
    out: &mut [[&mut [T]; A]; N],
    at: usize,
    found: &[[Lanes<T>; A]; N],
) {
    for (columns, found) in out.iter_mut().zip(found) {
        for (column, found) in columns.iter_mut().zip(found) {
            column[at * LANES..(at + 1) * LANES].copy_from_slice(found);
        }
    }
}
