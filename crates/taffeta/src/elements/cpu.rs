//! Elements on the CPU: forces are found element by element, then gathered by node. Nothing scatters.

use crate::cpu::backend::Context;
use crate::cpu::feature::{Feature, Flow};
use crate::cpu::shared::Shared;
use crate::cpu::simd::SimdLevel;
use crate::cpu::tile::Tile;
use crate::cpu::worker::Worker;
use crate::diagnostics::{ElementEnergy, FrameSums};
use crate::elements;
use crate::elements::element::{Element, List};
use crate::real::Real;
use crate::step::Op;
use crate::topology::{Csr, LANES};
use std::marker::PhantomData;
use std::ops::Range;

/// All elements of one kind.
pub trait ElementSet<T: Real>: Send + Sync {
    /// The name of the kind.
    fn name(&self) -> &'static str;
    /// Finds the forces of a worker's part of them.
    fn find(&self, worker: &Worker<'_, T>);
    /// Adds to the sums of up to [`LANES`] nodes the forces [N] of the elements around them, in order.
    fn gather(&self, level: SimdLevel, nodes: Range<usize>, sum: &mut [[T; LANES]; 3]);
    /// Energy of all of them [J], of kinds that have some.
    fn energy(&self, _state: [&[T]; 6]) -> Option<f64> {
        None
    }
    /// Bytes that they take.
    fn bytes(&self) -> usize;
    /// The forces of each [N], as last found and as many as its kind keeps.
    #[cfg(feature = "gpu")]
    fn forces(&self) -> Vec<[T; 3]>;
}

/// The elements of a formula: what serves every kind that does not bring a faster way of its own.
pub struct ByElement<T, E, const N: usize, const P: usize> {
    name: &'static str,
    /// Nodes by solver index.
    corners: Vec<[u32; N]>,
    numbers: Vec<[T; P]>,
    /// For each place: N·element + corner.
    by_node: Csr,
    /// Forces on the corners of each [N].
    forces: Shared<[[T; 3]; N]>,
    formula: PhantomData<E>,
}

impl<T: Real, E: Element<N, P>, const N: usize, const P: usize> ByElement<T, E, N, P> {
    /// Those of a list, among so many places.
    pub fn new(list: &List, places: usize) -> Self {
        let corners = list.all.nodes.as_chunks::<N>().0.to_vec();
        Self {
            name: list.kind.name,
            by_node: Csr::corners(places, &corners),
            forces: vec![[[T::ZERO; 3]; N]; corners.len()].into(),
            numbers: list.all.numbers.as_chunks::<P>().0.iter().map(|all| all.map(T::from_f64)).collect(),
            corners,
            formula: PhantomData,
        }
    }

    fn positions(&self, element: usize, state: &[&[T]]) -> [[T; 3]; N] {
        self.corners[element].map(|node| [0, 1, 2].map(|axis| state[axis][node as usize]))
    }
}

impl<T: Real, E: Element<N, P>, const N: usize, const P: usize> ElementSet<T> for ByElement<T, E, N, P> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn find(&self, worker: &Worker<'_, T>) {
        let (state, mine) = (worker.old(), worker.part(self.corners.len()));
        // SAFETY: parts of workers do not overlap, and forces are read only after the barrier.
        let out = unsafe { self.forces.write(mine.clone()) };
        for (i, out) in mine.zip(out) {
            let [x, v] = [&state[..3], &state[3..]].map(|columns| self.positions(i, columns));
            *out = E::forces(x, v, self.numbers[i]);
        }
    }

    fn gather(&self, _: SimdLevel, nodes: Range<usize>, sum: &mut [[T; LANES]; 3]) {
        // SAFETY: found before a barrier, and found again after the sub-step's last.
        let forces = unsafe { self.forces.read() }.as_flattened();
        for (lane, node) in nodes.enumerate() {
            for &corner in self.by_node.row(node) {
                let force = forces[corner as usize];
                for axis in 0..3 {
                    sum[axis][lane] += force[axis];
                }
            }
        }
    }

    fn energy(&self, state: [&[T]; 6]) -> Option<f64> {
        let one = |i: usize| E::energy(self.positions(i, &state[..3]), self.numbers[i]).to_f64();
        Some((0..self.corners.len()).map(one).sum())
    }

    fn bytes(&self) -> usize {
        let each = size_of::<[u32; N]>() + size_of::<[T; P]>() + size_of::<[[T; 3]; N]>() + 4 * N;
        self.corners.len() * each
    }

    #[cfg(feature = "gpu")]
    fn forces(&self) -> Vec<[T; 3]> {
        // SAFETY: asked for between frames, when no worker works.
        unsafe { self.forces.read() }.as_flattened().to_vec()
    }
}

/// All elements of a scene whose forces are found one by one.
pub struct Elements<T> {
    sets: Vec<Box<dyn ElementSet<T>>>,
}

impl<T: Real> Elements<T> {
    /// Those of a scene, if it has any.
    pub fn new(context: &Context<'_, T>) -> Option<Self> {
        let sets = elements::sets(context.assembly);
        (!sets.is_empty()).then_some(Self { sets })
    }

    /// The forces of each element of a kind [N], as last found.
    #[cfg(feature = "gpu")]
    pub fn forces(&self, kind: &str) -> Vec<[T; 3]> {
        self.sets.iter().find(|set| set.name() == kind).map_or_else(Vec::new, |set| set.forces())
    }

    /// Adds up the forces on a run of nodes, slices of nodes at a time.
    fn gather(&self, tile: &mut Tile<'_, T>, at: usize, run: &Range<usize>) {
        let mut start = run.start;
        while start < run.end {
            let nodes = start..run.end.min((start / LANES + 1) * LANES);
            let mut sum = [[T::ZERO; LANES]; 3];
            self.sets.iter().for_each(|set| set.gather(tile.nodes.level, nodes.clone(), &mut sum));
            let here = at + start - run.start;
            for (column, sum) in tile.scratch.force.iter_mut().zip(&sum) {
                for (force, &sum) in column[here..here + nodes.len()].iter_mut().zip(sum) {
                    *force += sum;
                }
            }
            start = nodes.end;
        }
    }
}

impl<T: Real> Feature<T> for Elements<T> {
    fn ops(&self) -> &'static [Op] {
        &[Op::Elements, Op::Gather]
    }

    fn run(&self, _: Op, worker: &mut Worker<'_, T>) -> Flow {
        self.sets.iter().for_each(|set| set.find(worker));
        Flow::Go
    }

    fn tile(&self, _: Op, tile: &mut Tile<'_, T>) {
        for (at, run) in tile.plan.runs() {
            self.gather(tile, at, &run);
        }
    }

    fn measure(&mut self, state: [&[T]; 6], _: usize, sums: &mut FrameSums) {
        let energies = self.sets.iter().map(|set| (set.name(), set.energy(state)));
        let some = energies.filter_map(|(kind, energy)| Some(ElementEnergy::new(kind, energy?)));
        sums.elements = some.collect();
    }

    fn bytes(&self) -> usize {
        self.sets.iter().map(|set| set.bytes()).sum()
    }
}
