//! Blocks of coarser levels, Pᵀ A P in two steps: first A P, of which a finer node needs its own blocks alone, so that sixteen nodes
//! are one after the other in memory; then Pᵀ of that.

use crate::cpu::simd::Kernel;
use crate::real::Real;
use crate::solvers::implicit::couplings::{Block, Couplings};
use crate::solvers::implicit::cpu::elements::BLOCK;
use crate::solvers::implicit::cpu::kernels::FINE;
use crate::solvers::implicit::implicit::block;
use crate::solvers::implicit::levels::Level;
use crate::solvers::implicit::slots::{NO_EDGE, Slots};
use crate::topology::LANES;
use std::collections::BTreeMap;
use std::ops::Range;

/// Marks a group of slots of springs.
const SPRINGS: u32 = 1 << 31;

/// A coarser level, and whether a place of it is of a body with elements that are solved for.
pub struct Coarse<'a> {
    pub level: &'a Level,
    pub is_solved: &'a dyn Fn(usize) -> bool,
}

/// A P: what each finer node's blocks are by coarser nodes.
pub struct Product<T> {
    /// Groups of sixteen blocks of A P before each slice of finer nodes; one more than there are slices.
    starts: Vec<u32>,
    /// By group: where its sources start; one more than there are groups.
    offsets: Vec<u32>,
    /// A group of the same slice's blocks, and a weight by lane.
    sources: Vec<(u32, [T; LANES])>,
}

/// What a block of A P is made of: by group of the finer node's blocks a weight.
type Row = Vec<(u32, BTreeMap<u32, f32>)>;

impl<T: Real> Product<T> {
    /// From a level with its springs, if it has some that are no blocks, to a coarser one. Returns the blocks of that, too, with
    /// blocks of A P as their sources.
    pub fn new<S: Copy>(
        finer: &Couplings<S>,
        springs: Option<&Slots>,
        coarse: &Coarse<'_>,
    ) -> (Self, Couplings<(u32, f32)>) {
        let mut product = Self { starts: vec![0], offsets: vec![0], sources: Vec::new() };
        // By finer place: coarser nodes, and where the block of A P is.
        let mut halves: Vec<Vec<(u32, u32)>> = Vec::new();
        for slice in 0..finer.starts.len() - 1 {
            let rows: [Row; LANES] = std::array::from_fn(|lane| row(finer, springs, coarse, slice, lane));
            let first = product.offsets.len() as u32 - 1;
            for (lane, row) in rows.iter().enumerate() {
                let slot = |rank: u32| (first + rank) * LANES as u32 + lane as u32;
                halves.push((0..).zip(row).map(|(rank, one)| (one.0, slot(rank))).collect());
            }
            for rank in 0..rows.iter().map(Vec::len).max().unwrap_or(0) {
                product.push_group(&rows, rank);
            }
            product.starts.push(product.offsets.len() as u32 - 1);
        }
        (product, coarser(coarse, &halves))
    }

    fn push_group(&mut self, rows: &[Row; LANES], rank: usize) {
        let mut weights: BTreeMap<u32, [T; LANES]> = BTreeMap::new();
        for (lane, row) in rows.iter().enumerate() {
            for (&group, &weight) in row.get(rank).iter().flat_map(|one| &one.1) {
                weights.entry(group).or_insert([T::ZERO; LANES])[lane] = T::from_f64(f64::from(weight));
            }
        }
        self.sources.extend(weights);
        self.offsets.push(self.sources.len() as u32);
    }

    /// Number of blocks of A P.
    pub fn len(&self) -> usize {
        (self.offsets.len() - 1) * LANES
    }

    /// Where blocks of some finer places are.
    pub fn slots(&self, part: &Range<usize>) -> Range<usize> {
        let at = |place: usize| self.starts[place / LANES] as usize * LANES;
        at(part.start)..at(part.end)
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        4 * (self.starts.len() + self.offsets.len()) + size_of_val(&self.sources[..])
    }
}

/// What a finer node's blocks are by coarser nodes, by ascending node: Σ w_jJ B_ij − w_iJ S_i.
fn row<S: Copy>(
    finer: &Couplings<S>,
    springs: Option<&Slots>,
    coarse: &Coarse<'_>,
    slice: usize,
    lane: usize,
) -> Row {
    let (own, groups, parents) = (slice * LANES + lane, finer.groups(slice), &coarse.level.parents);
    if groups.is_empty() || own >= parents.rows() {
        return Vec::new();
    }
    let mut all: BTreeMap<u32, BTreeMap<u32, f32>> = BTreeMap::new();
    let mut add = |group: u32, node: usize, sign: f32| {
        for &(parent, weight) in parents.row(node) {
            *all.entry(parent).or_default().entry(group).or_insert(0.0) += sign * weight;
        }
    };
    add(groups.start as u32, own, -1.0);
    for (slot, other) in finer.row(own).filter(|one| one.1 != own) {
        add((slot / LANES) as u32, other, 1.0);
    }
    if let Some(springs) = springs {
        for group in springs.starts[slice]..springs.starts[slice + 1] {
            let slot = group as usize * LANES + lane;
            if springs.edge[slot] != NO_EDGE {
                add(SPRINGS | group, springs.neighbour[slot] as usize, 1.0);
            }
        }
    }
    all.into_iter().collect()
}

/// The blocks of the coarser level.
fn coarser(coarse: &Coarse<'_>, halves: &[Vec<(u32, u32)>]) -> Couplings<(u32, f32)> {
    let places = coarse.level.places;
    let children = coarse.level.parents.transposed(places);
    let row = |place: usize| {
        let mut row = Vec::new();
        for &(child, weight) in children.row(place) {
            let others = halves[child as usize].iter().filter(|one| one.0 as usize != place);
            row.extend(others.map(|&(node, slot)| (node, (slot, weight))));
        }
        row
    };
    let mut couplings = Couplings::default();
    for slice in (0..places).step_by(LANES) {
        let is_solved = (coarse.is_solved)(slice);
        let rows = std::array::from_fn(|lane| if is_solved { row(slice + lane) } else { Vec::new() });
        couplings.push_slice(rows, is_solved);
    }
    couplings
}

/// Kernel: blocks of A P of a chunk of the finer level.
pub struct Half<'a, T> {
    pub part: Range<usize>,
    pub product: &'a Product<T>,
    /// Blocks of the finer level, and those of its springs.
    pub finer: &'a [T],
    pub springs: &'a [T],
    pub out: &'a mut [Block<T>],
}

impl<T: Real> Kernel for Half<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { part, product, finer, springs, out } = self;
        let groups = product.starts[part.start / LANES] as usize..product.starts[part.end / LANES] as usize;
        for (group, out) in groups.zip(out.chunks_exact_mut(LANES)) {
            let range = product.offsets[group] as usize..product.offsets[group + 1] as usize;
            let mut sum = [[T::ZERO; LANES]; BLOCK];
            for (source, weights) in &product.sources[range] {
                if source & SPRINGS == 0 {
                    let from = *source as usize * BLOCK * LANES;
                    let blocks = finer[from..from + BLOCK * LANES].as_chunks::<LANES>().0;
                    for (sum, block) in sum.iter_mut().zip(blocks) {
                        for lane in 0..LANES {
                            sum[lane] += weights[lane] * block[lane];
                        }
                    }
                } else {
                    let from = (source & !SPRINGS) as usize * FINE * LANES;
                    add_springs(&springs[from..from + FINE * LANES], weights, &mut sum);
                }
            }
            for (lane, out) in out.iter_mut().enumerate() {
                for (out, sum) in out.iter_mut().zip(&sum) {
                    *out = sum[lane];
                }
            }
        }
    }
}

/// Adds blocks of a group of springs, each times a weight.
#[inline(always)]
fn add_springs<T: Real>(springs: &[T], weights: &[T; LANES], sum: &mut [[T; LANES]; BLOCK]) {
    let numbers = springs.as_chunks::<LANES>().0;
    for lane in 0..LANES {
        let q = [numbers[0][lane], numbers[1][lane], numbers[2][lane]];
        let [xx, yy, zz, xy, xz, yz] = block(q, numbers[3][lane]);
        let block = [xx, xy, xz, xy, yy, yz, xz, yz, zz];
        for one in 0..BLOCK {
            sum[one][lane] += weights[lane] * block[one];
        }
    }
}
