//! Elements on the CPU: forces are found element by element, then gathered by node. Nothing scatters.

use crate::cpu::shared::Shared;
use crate::cpu::simd::SimdLevel;
use crate::cpu::worker::Worker;
use crate::elements::element::{Element, List};
use crate::real::Real;
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
    /// Finds the forces [N] on the nodes of some elements in another state, and the directions of their modes over a step `h` [s],
    /// of kinds that are solved for: by element, mode and node.
    fn linearise(&self, _part: Range<usize>, _state: &[&[T]; 6], _h: T, _out: Linearised<'_, T>) {}
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

/// What is found of some elements that are solved for.
pub struct Linearised<'a, T> {
    /// Forces [N], by element and node.
    pub forces: &'a mut [[T; 3]],
    /// Directions [kg^½], by element, mode and node.
    pub directions: &'a mut [[T; 3]],
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

    fn linearise(&self, part: Range<usize>, state: &[&[T]; 6], h: T, out: Linearised<'_, T>) {
        let modes = out.directions.len() / (N * part.len()).max(1);
        let directions = out.directions.chunks_exact_mut(N * modes);
        for ((i, forces), directions) in part.zip(out.forces.chunks_exact_mut(N)).zip(directions) {
            let [x, v] = [&state[..3], &state[3..]].map(|columns| self.positions(i, columns));
            forces.copy_from_slice(&E::forces(x, v, self.numbers[i]));
            directions.fill([T::ZERO; 3]);
            let mut next = directions.chunks_exact_mut(N);
            E::modes(x, self.numbers[i], |mode| {
                let room = next.next().expect("an element has no more modes than its kind says");
                room.copy_from_slice(&mode.over_step(h));
            });
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
