//! Elements on the CPU: forces are found element by element, then gathered by node. Nothing scatters.

use crate::cpu::simd::SimdLevel;
use crate::cpu::worker::Worker;
use crate::elements::directions::{Directions, Linearise};
use crate::elements::element::{Element, Kind, List};
use crate::elements::gathered::{Gather, Gathered};
use crate::elements::lanes::{Blocks, Energy, FindForces, Forces, Lanes};
use crate::real::Real;
use crate::topology::{Csr, LANES};
use std::marker::PhantomData;
use std::ops::Range;

/// All elements of one kind.
pub trait ElementSet<T: Real>: Send + Sync {
    /// The name of the kind.
    fn name(&self) -> &'static str;
    /// Number of blocks of [`LANES`] elements.
    fn blocks(&self) -> usize;
    /// Blocks of the elements around a slice of nodes: from the first to the last.
    fn around(&self, slice: usize) -> Range<usize>;
    /// Finds the forces of some blocks.
    fn find(&self, worker: &Worker<'_, T>, blocks: Range<usize>);
    /// Adds to the sums of up to [`LANES`] nodes the forces [N] of the elements around them, in order.
    fn gather(&self, level: SimdLevel, nodes: Range<usize>, sum: &mut [Lanes<T>; 3]);
    /// Finds the forces [N] on the nodes of blocks of elements in another state, and the directions of their modes over a step `h`
    /// [s], of kinds that are solved for.
    fn linearise(&self, _level: SimdLevel, _blocks: Range<usize>, _state: &[&[T]; 6], _h: T) {}
    /// Directions as last found, of kinds that are solved for.
    fn directions(&self) -> Option<&Directions<T>> {
        None
    }
    /// Energy of all of them [J], of kinds that have some.
    fn energy(&self, _state: [&[T]; 6]) -> Option<f64> {
        None
    }
    /// Bytes that they take.
    fn bytes(&self) -> usize;
    /// The forces of each [N], as last found and as many as its kind keeps.
    #[cfg(feature = "gpu")]
    fn forces(&self) -> Vec<[T; 3]>;
    /// Directions of the modes of all over a step `h` [s] in some state, by element, mode and node, whether or not they are solved
    /// for.
    #[cfg(feature = "gpu")]
    fn listed_directions(&self, _state: &[&[T]; 6], _h: T) -> Vec<[T; 4]> {
        Vec::new()
    }
}

/// The elements of a formula: what serves every kind that does not bring a faster way of its own.
pub struct ByElement<T, E, const N: usize, const P: usize> {
    kind: &'static Kind,
    blocks: Blocks<T, N, P>,
    /// Which forces nodes add up.
    gathered: Gathered,
    /// Forces on the nodes of each [N].
    forces: Forces<T, N>,
    /// Where they are solved for.
    directions: Option<Directions<T>>,
    formula: PhantomData<E>,
}

impl<T: Real, E: Element<N, P>, const N: usize, const P: usize> ByElement<T, E, N, P> {
    /// Those of a list, among so many places.
    pub fn new(list: &List, places: usize) -> Self {
        let by_node = Csr::corners(places, list.all.nodes.as_chunks::<N>().0);
        let blocks = Blocks::new(list);
        let forces = Forces::new(blocks.len());
        let gathered = Gathered::new(&by_node, &forces, blocks.len());
        let directions = if list.implicit { Directions::new(list.kind, list.len()) } else { None };
        Self { kind: list.kind, blocks, gathered, forces, directions, formula: PhantomData }
    }

    fn linearise_into(
        &self,
        directions: &Directions<T>,
        level: SimdLevel,
        part: Range<usize>,
        (state, h): (&[&[T]; 6], T),
    ) {
        // SAFETY: parts of workers do not overlap, and others read only after a barrier.
        let kernel = unsafe {
            let (blocks, out) = (&self.blocks, self.forces.write(&part));
            let find = FindForces::<T, E, N, P> { blocks, state: *state, part, out, formula: PhantomData };
            Linearise::new(find, directions, h)
        };
        level.run(kernel);
    }
}

impl<T: Real, E: Element<N, P>, const N: usize, const P: usize> ElementSet<T> for ByElement<T, E, N, P> {
    fn name(&self) -> &'static str {
        self.kind.name
    }

    fn blocks(&self) -> usize {
        self.blocks.len()
    }

    fn around(&self, slice: usize) -> Range<usize> {
        self.gathered.around(slice)
    }

    fn find(&self, worker: &Worker<'_, T>, part: Range<usize>) {
        let blocks = &self.blocks;
        // SAFETY: parts of workers do not overlap, and forces are read only after the barrier.
        let out = unsafe { self.forces.write(&part) };
        let find = FindForces::<T, E, N, P> { blocks, state: worker.old(), part, out, formula: PhantomData };
        worker.nodes.level.run(find);
    }

    fn gather(&self, level: SimdLevel, nodes: Range<usize>, sum: &mut [Lanes<T>; 3]) {
        // SAFETY: found before a barrier, and found again after the sub-step's last.
        let forces = unsafe { self.forces.read() };
        let (slice, first) = (nodes.start / LANES, nodes.start % LANES);
        let mut of_slice = [[T::ZERO; LANES]; 3];
        for (lanes, sum) in of_slice.iter_mut().zip(&*sum) {
            lanes[first..].copy_from_slice(&sum[..LANES - first]);
        }
        let stride = self.forces.stride();
        level.run(Gather { gathered: &self.gathered, slice, forces, stride, sum: &mut of_slice });
        for (sum, lanes) in sum.iter_mut().zip(&of_slice) {
            sum[..LANES - first].copy_from_slice(&lanes[first..]);
        }
    }

    fn linearise(&self, level: SimdLevel, part: Range<usize>, state: &[&[T]; 6], h: T) {
        if let Some(directions) = &self.directions {
            self.linearise_into(directions, level, part, (state, h));
        }
    }

    fn directions(&self) -> Option<&Directions<T>> {
        self.directions.as_ref()
    }

    fn energy(&self, state: [&[T]; 6]) -> Option<f64> {
        let [x, y, z, ..] = state;
        let energy = Energy::<T, E, N, P> { blocks: &self.blocks, places: [x, y, z], formula: PhantomData };
        Some(SimdLevel::detect().run(energy))
    }

    fn bytes(&self) -> usize {
        let directions = self.directions.as_ref().map_or(0, Directions::bytes);
        self.blocks.bytes() + self.gathered.bytes() + self.forces.bytes() + directions
    }

    #[cfg(feature = "gpu")]
    fn forces(&self) -> Vec<[T; 3]> {
        // SAFETY: asked for between frames, when no worker works.
        let all = unsafe { self.forces.read() };
        let at = |corner: usize| self.forces.place(corner / N, corner % N);
        let of = |place: usize| [0, 1, 2].map(|axis| all[place + axis * self.forces.stride()]);
        (0..N * self.blocks.count).map(|corner| of(at(corner))).collect()
    }

    #[cfg(feature = "gpu")]
    fn listed_directions(&self, state: &[&[T]; 6], h: T) -> Vec<[T; 4]> {
        let count = self.blocks.count;
        let Some(directions) = Directions::new(self.kind, count) else { return Vec::new() };
        self.linearise_into(&directions, SimdLevel::detect(), 0..self.blocks.len(), (state, h));
        // SAFETY: nobody else has them.
        directions.listed(count, unsafe { directions.read() })
    }
}
