//! Couplings: the system of elements that are solved for, as blocks of three by three between two nodes.
//!
//! A mode of an element adds g gᵀ to the system, where g [kg^½] has a direction for each of its nodes. As the directions of a
//! mode add up to 0, so do the blocks of a row, and the product at node i is Σ B (u_i − u_j) with B = −g_i g_jᵀ: what is the same
//! for all nodes meets no resistance, whatever the rounding. A coarser level has the Galerkin product Pᵀ A P (Trottenberg,
//! Oosterlee, Schüller, "Multigrid", 2001, §2.3.2), where P are the weights by which nodes follow coarser ones: its block between
//! I and J is Σ w_iI (w_jJ B_ij − w_iJ S_i) over all finer nodes i and blocks, those of springs among them, where S_i is the sum
//! of a node's blocks.

use crate::assembly::Assembly;
use crate::real::{Real, Symmetric, times};

use crate::topology::{Csr, LANES};
use std::ops::Range;

/// A block, row by row.
pub type Block<T> = [T; 9];

/// A matrix of blocks, laid out in slices of [`LANES`] nodes: slot `k` of node `16·slice + lane` is at
/// `16·(starts[slice] + k) + lane`. The first slot of a node is for the sum of its blocks, others are for blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct Couplings<S> {
    /// Groups of sixteen slots before each slice; one more than there are slices.
    pub starts: Vec<u32>,
    /// The other node; the node itself where a slot is there for the slice's longest row alone.
    pub neighbour: Vec<u32>,
    /// By group: whether the other nodes follow each other, as on a grid.
    pub in_row: Vec<bool>,
    /// Where the sources of each slot start; one more than there are slots.
    pub offsets: Vec<u32>,
    /// What blocks are made of.
    pub sources: Vec<S>,
}

/// Elements of one kind that are solved for, among all such.
#[derive(Clone, Debug, PartialEq)]
pub struct Solved {
    /// Which of the assembly's lists, and which of its elements.
    pub list: usize,
    pub elements: Range<usize>,
    /// Where their forces and directions start.
    pub first_force: usize,
    pub first_direction: usize,
    /// Forces and directions of an element.
    pub forces: usize,
    pub directions: usize,
}

/// All levels of some bodies.
pub struct Tables {
    /// The elements.
    pub solved: Vec<Solved>,
    /// By place: the forces on it.
    pub forces: Csr,
    /// The finest level: two directions for each source.
    pub finest: Couplings<[u32; 2]>,
    /// Coarser levels: a slot of the finer one for each source, and its weight. Those of springs are counted from
    /// [`Couplings::len`] of the finest level on.
    pub coarser: Vec<Couplings<(u32, f32)>>,
}

impl<S> Default for Couplings<S> {
    fn default() -> Self {
        Self {
            starts: vec![0],
            neighbour: Vec::new(),
            in_row: Vec::new(),
            offsets: vec![0],
            sources: Vec::new(),
        }
    }
}

impl<S: Copy> Couplings<S> {
    /// Number of slots.
    pub fn len(&self) -> usize {
        self.neighbour.len()
    }

    /// Slots of a slice of nodes, in groups of sixteen.
    #[inline(always)]
    pub fn groups(&self, slice: usize) -> Range<usize> {
        self.starts[slice] as usize..self.starts[slice + 1] as usize
    }

    /// What the block of a slot is made of.
    #[inline(always)]
    pub fn sources(&self, slot: usize) -> &[S] {
        &self.sources[self.offsets[slot] as usize..self.offsets[slot + 1] as usize]
    }

    /// Groups of a slice's blocks.
    #[inline(always)]
    pub fn blocks(&self, slice: usize) -> Range<usize> {
        let groups = self.groups(slice);
        (groups.start + 1).min(groups.end)..groups.end
    }

    /// Slots of a node's blocks, and the nodes that they lead to.
    pub fn row(&self, node: usize) -> impl Iterator<Item = (usize, usize)> {
        let slots = self.blocks(node / LANES).map(move |group| group * LANES + node % LANES);
        slots.map(|slot| (slot, self.neighbour[slot] as usize))
    }

    /// The slot of the sum of a node's blocks, in a slice that has some.
    #[cfg(feature = "gpu")]
    pub fn sum_of(&self, node: usize) -> usize {
        self.groups(node / LANES).start * LANES + node % LANES
    }

    /// Adds a slice whose nodes have these sources, each with the node that it leads to. Where it is of a body with elements,
    /// nodes have slots for sums in any case.
    pub(super) fn push_slice(&mut self, rows: [Vec<(u32, S)>; LANES], has_elements: bool) {
        let first = (self.starts.len() - 1) * LANES;
        let rows = rows.map(|mut row| {
            row.sort_by_key(|one| one.0);
            row
        });
        let mut rows: Vec<_> = rows.iter().map(|row| row.chunk_by(|a, b| a.0 == b.0)).collect();
        let mut group: Vec<_> = rows.iter_mut().map(Iterator::next).collect();
        if has_elements || group.iter().any(Option::is_some) {
            self.push_group(first, vec![None; LANES]);
        }
        while group.iter().any(Option::is_some) {
            self.push_group(first, group);
            group = rows.iter_mut().map(Iterator::next).collect();
        }
        self.starts.push((self.neighbour.len() / LANES) as u32);
    }

    /// Adds a slot for each node from `first` on.
    fn push_group(&mut self, first: usize, group: Vec<Option<&[(u32, S)]>>) {
        for (lane, slot) in group.into_iter().enumerate() {
            let sources = slot.unwrap_or_default();
            self.neighbour.push(sources.first().map_or((first + lane) as u32, |one| one.0));
            self.sources.extend(sources.iter().map(|one| one.1));
            self.offsets.push(self.sources.len() as u32);
        }
        let nodes = &self.neighbour[self.neighbour.len() - LANES..];
        self.in_row.push((0..).zip(nodes).all(|(lane, &node)| node == nodes[0] + lane));
    }

    /// Groups before each slice, the other node of each slot, and whether those of a group follow each other.
    pub fn lists(&self) -> (&[u32], &[u32], &[bool]) {
        (&self.starts, &self.neighbour, &self.in_row)
    }

    /// Gives back what only tells what blocks are made of.
    pub fn forget_sources(&mut self) {
        (self.sources, self.offsets) = (Vec::new(), Vec::new());
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        4 * (self.starts.len() + self.neighbour.len() + self.offsets.len()) + size_of_val(&self.sources[..])
    }
}

impl Tables {
    /// Those of some bodies, without coarser levels; none where no element is solved for. Nodes are counted from the first of the
    /// bodies.
    pub fn of_finest(assembly: &Assembly, bodies: &Range<usize>) -> Option<Self> {
        let solved = solved(assembly, bodies);
        if solved.is_empty() {
            return None;
        }
        let first = assembly.bodies[bodies.start].first;
        let last = &assembly.bodies[bodies.end - 1];
        let places = last.first + last.places() - first;
        let nodes = |one: &Solved| -> Vec<&[u32]> {
            assembly.elements()[one.list].of(one.elements.clone()).map(|element| element.0).collect()
        };
        let corners: Vec<(&Solved, Vec<&[u32]>)> = solved.iter().map(|one| (one, nodes(one))).collect();
        let forces = Csr::new(
            places,
            corners.iter().flat_map(|(one, elements)| {
                let nodes = elements.iter().copied().flatten().map(|node| node - first as u32);
                nodes.zip(one.first_force as u32..)
            }),
        );
        let has_elements = |place: usize| {
            let body = assembly.bodies.partition_point(|body| body.first + body.places() <= first + place);
            assembly.has_solved_elements(body)
        };
        let finest = finest((first, places), &corners, has_elements);
        Some(Self { solved, forces, finest, coarser: Vec::new() })
    }

    /// Number of forces, and of directions.
    #[cfg(test)]
    pub fn counts(&self) -> [usize; 2] {
        let last = self.solved.last();
        last.map_or([0; 2], |one| {
            let count = one.elements.len();
            [one.first_force + one.forces * count, one.first_direction + one.directions * count]
        })
    }
}

/// Kinds of elements of some bodies that are solved for.
fn solved(assembly: &Assembly, bodies: &Range<usize>) -> Vec<Solved> {
    let (mut all, mut first_force, mut first_direction) = (Vec::new(), 0, 0);
    for (number, list) in assembly.elements().iter().enumerate() {
        let (Some(implicit), true) = (&list.kind.implicit, list.implicit) else { continue };
        let of_bodies = &list.bodies[bodies.clone()];
        let start = of_bodies.first().map_or(0, |body| body.start);
        let elements = start..of_bodies.last().map_or(start, |body| body.end);
        if elements.is_empty() {
            continue;
        }
        let (forces, directions) = (list.kind.nodes, list.kind.nodes * implicit.modes);
        let (next_force, next_direction) =
            (first_force + forces * elements.len(), first_direction + directions * elements.len());
        all.push(Solved { list: number, elements, first_force, first_direction, forces, directions });
        (first_force, first_direction) = (next_force, next_direction);
    }
    all
}

/// Blocks between all nodes of each element, of so many places from the first on.
fn finest(
    (first, places): (usize, usize),
    corners: &[(&Solved, Vec<&[u32]>)],
    has_elements: impl Fn(usize) -> bool,
) -> Couplings<[u32; 2]> {
    // By node: kind, element, corner.
    let mut around: Vec<Vec<(u32, u32, u32)>> = vec![Vec::new(); places];
    for (kind, (_, elements)) in (0..).zip(corners) {
        for (element, nodes) in (0..).zip(elements) {
            for (corner, &node) in (0..).zip(*nodes) {
                around[node as usize - first].push((kind, element, corner));
            }
        }
    }
    let row = |node: usize| {
        let mut row = Vec::new();
        for &(kind, element, corner) in &around[node] {
            let (solved, elements) = &corners[kind as usize];
            let nodes = elements[element as usize];
            let base = solved.first_direction + solved.directions * element as usize;
            for mode in (base..base + solved.directions).step_by(nodes.len()) {
                // An element may have a node twice, where it is not used: at a border of the fabric.
                let others = nodes.iter().enumerate().filter(|&(_, &other)| other as usize != node + first);
                row.extend(others.map(|(other, &node)| {
                    (node - first as u32, [(mode + corner as usize) as u32, (mode + other) as u32])
                }));
            }
        }
        row
    };
    let mut couplings = Couplings::default();
    for slice in (0..places).step_by(LANES) {
        couplings.push_slice(std::array::from_fn(|lane| row(slice + lane)), has_elements(slice));
    }
    couplings
}

/// A block times a vector.
#[inline(always)]
pub fn block_times<T: Real>(m: &Block<T>, v: [T; 3]) -> [T; 3] {
    [
        m[0] * v[0] + m[1] * v[1] + m[2] * v[2],
        m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
        m[6] * v[0] + m[7] * v[1] + m[8] * v[2],
    ]
}

/// The symmetric part of a block.
#[inline(always)]
pub fn symmetric_part<T: Real>(m: &Block<T>) -> Symmetric<T> {
    let half = T::from_f64(0.5);
    [m[0], m[4], m[8], half * (m[1] + m[3]), half * (m[2] + m[6]), half * (m[5] + m[7])]
}

/// A symmetric matrix as a block.
#[inline(always)]
pub fn whole<T: Real>(m: &Symmetric<T>) -> Block<T> {
    let [xx, yy, zz, xy, xz, yz] = *m;
    [xx, xy, xz, xy, yy, yz, xz, yz, zz]
}

/// How much a block couples two nodes whose diagonals have these inverses: the Frobenius norm of D_i^−½ B D_j^−½, from
/// tr(D_i⁻¹ B D_j⁻¹ Bᵀ).
#[inline(always)]
pub fn coupling<T: Real>(inverse: &Symmetric<T>, block: &Block<T>, other: &Symmetric<T>) -> T {
    let first = times(inverse, [block[0], block[3], block[6]]);
    let second = times(inverse, [block[1], block[4], block[7]]);
    let third = times(inverse, [block[2], block[5], block[8]]);
    let x = times(other, [block[0], block[1], block[2]]);
    let y = times(other, [block[3], block[4], block[5]]);
    let z = times(other, [block[6], block[7], block[8]]);
    let trace = first[0] * x[0]
        + second[0] * x[1]
        + third[0] * x[2]
        + first[1] * y[0]
        + second[1] * y[1]
        + third[1] * y[2]
        + first[2] * z[0]
        + second[2] * z[1]
        + third[2] * z[2];
    let root = (if trace > T::ZERO { trace } else { T::ZERO }).sqrt();
    if trace > T::ZERO { root } else { T::ZERO }
}

/// What a diagonal's inverse is multiplied by so that Jacobi's iteration converges: with Σ of all [`coupling`]s of a node, the
/// system is not above 1 + Σ times its diagonal (Gershgorin, by blocks), and may be 2 times it.
#[inline(always)]
pub fn jacobi_factor<T: Real>(couplings: T) -> T {
    let two = T::ONE + T::ONE;
    let all = T::ONE + couplings;
    let less = two / if all > two { all } else { T::ONE };
    if all > two { less } else { T::ONE }
}
