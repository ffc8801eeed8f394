//! Springs of a mesh, gathered by node: each node adds up the springs of its row, so that no two workers write one
//! node. Rows are kept in slices of [`LANES`] nodes (sliced ELL), one node a vector lane.

use crate::cpu::column::Column;
use crate::cpu::simd::{Kernel, SimdLevel, prefetch};
use crate::elements::spring::spring;
use crate::real::{Real, dot};
use crate::topology::{Gather, LANES};

/// Nodes from which on a body's state and table are too large for the second-level cache, so that it pays to have them
/// fetched before they are read.
const FETCHED_FROM: usize = 1 << 16;

/// The springs of one kind of a mesh body.
pub struct GatheredSprings<T> {
    /// Stiffness [N/m].
    pub k: T,
    /// Damping [kg/s].
    pub damping: T,
    slice_starts: Vec<u32>,
    /// The other end, counted from the body's first node.
    neighbour: Vec<u32>,
    /// Rest length [m]; 0 in padding, whose two ends are one node.
    rest_length: Vec<T>,
    nodes: usize,
}

impl<T: Real> GatheredSprings<T> {
    /// From a gather table of a body of `nodes` nodes; every neighbour in it is one of them.
    pub fn new((k, damping): (f64, f64), gather: Gather, nodes: usize) -> Self {
        assert!(gather.neighbour.iter().all(|&n| (n as usize) < nodes), "gather table within the body");
        Self {
            k: T::from_f64(k),
            damping: T::from_f64(damping),
            slice_starts: gather.slice_starts,
            neighbour: gather.neighbour,
            rest_length: gather.rest.into_iter().map(T::from_f64).collect(),
            nodes,
        }
    }

    /// Adds to `force` [N] the springs of the nodes of `slices`; `old` is the state from the body's first node on. Returns
    /// whether one of them is longer than `limit` times its rest length, if that is asked.
    pub fn springs(
        &self,
        level: SimdLevel,
        slices: std::ops::Range<usize>,
        old: [&[T]; 6],
        force: &mut [Column<T>; 3],
        limit: Option<T>,
    ) -> bool {
        match limit {
            None => level.run(GatherForces::<T, false> { springs: self, slices, old, force, limit: T::FAR }),
            Some(limit) => {
                level.run(GatherForces::<T, true> { springs: self, slices, old, force, limit: limit * limit })
            }
        }
    }

    /// The table's rows for one slice: for each step, the neighbours and rest lengths of the slice's lanes.
    #[inline(always)]
    pub fn slice(&self, slice: usize) -> impl Iterator<Item = (&[u32; LANES], &[T; LANES])> {
        let range = self.slice_starts[slice] as usize..self.slice_starts[slice + 1] as usize;
        let neighbours = self.neighbour[range.clone()].as_chunks::<LANES>().0;
        neighbours.iter().zip(self.rest_length[range].as_chunks::<LANES>().0)
    }

    /// Has what is read of later slices fetched, and no more of it than the first-level cache can hold.
    #[inline(always)]
    fn fetch_ahead(&self, old: &[&[T]; 6], slice: usize) {
        let later = (slice + 8).min(self.slice_starts.len() - 2);
        let row = self.slice_starts[later] as usize..self.slice_starts[later + 1] as usize;
        for at in row.step_by(LANES) {
            prefetch(&self.neighbour, at);
            prefetch(&self.rest_length, at);
        }
        for column in old {
            prefetch(column, (slice + 32) * LANES);
        }
    }

    /// Number of places that a column of the body must have.
    #[inline(always)]
    pub fn places(&self) -> usize {
        self.nodes.next_multiple_of(LANES)
    }

    /// Bytes that the table takes.
    pub fn bytes(&self) -> usize {
        self.neighbour.len() * (4 + size_of::<T>()) + self.slice_starts.len() * 4
    }
}

/// Kernel: forces of some slices; whether a spring's squared stretch is beyond the one watched for.
struct GatherForces<'a, T, const LIMITED: bool> {
    springs: &'a GatheredSprings<T>,
    slices: std::ops::Range<usize>,
    old: [&'a [T]; 6],
    force: &'a mut [Column<T>; 3],
    limit: T,
}

impl<T: Real, const LIMITED: bool> Kernel for GatherForces<'_, T, LIMITED> {
    type Output = bool;
    #[inline(always)]
    fn run(self) -> bool {
        let Self { springs, slices, old, force: [fx, fy, fz], limit } = self;
        let mut over = [T::ZERO; LANES];
        let places = springs.places();
        let [x, y, z, u, v, w] = old;
        let old = [&x[..places], &y[..places], &z[..places], &u[..places], &v[..places], &w[..places]];
        let mut other = [[T::ZERO; LANES]; 6];
        for (index, slice) in slices.enumerate() {
            let mut sum = [[T::ZERO; LANES]; 3];
            let own = lanes_of(&old, slice);
            if springs.nodes >= FETCHED_FROM {
                springs.fetch_ahead(&old, slice);
            }
            for (neighbours, rest_lengths) in springs.slice(slice) {
                gather(&old, neighbours, &mut other);
                add_springs(springs, &own, &other, rest_lengths, &mut sum);
                if LIMITED {
                    note_longest(&own, &other, rest_lengths, limit, &mut over);
                }
            }
            let here = index * LANES..(index + 1) * LANES;
            add_lanes(&mut fx[here.clone()], &sum[0]);
            add_lanes(&mut fy[here.clone()], &sum[1]);
            add_lanes(&mut fz[here], &sum[2]);
        }
        over.into_iter().any(|over| over > T::ZERO)
    }
}

/// Notes by how much a squared length is beyond `limit` times that at rest.
#[inline(always)]
fn note_longest<T: Real>(
    own: &[[T; LANES]; 6],
    other: &[[T; LANES]; 6],
    rest_lengths: &[T; LANES],
    limit: T,
    over: &mut [T; LANES],
) {
    for lane in 0..LANES {
        let d = [other[0][lane] - own[0][lane], other[1][lane] - own[1][lane], other[2][lane] - own[2][lane]];
        let beyond = dot(d, d) - limit * (rest_lengths[lane] * rest_lengths[lane]);
        over[lane] = if beyond > over[lane] { beyond } else { over[lane] };
    }
}

/// State of the nodes of a slice.
#[inline(always)]
pub fn lanes_of<T: Real>(state: &[&[T]; 6], slice: usize) -> [[T; LANES]; 6] {
    let mut lanes = [[T::ZERO; LANES]; 6];
    for axis in 0..6 {
        lanes[axis].copy_from_slice(&state[axis][slice * LANES..(slice + 1) * LANES]);
    }
    lanes
}

#[inline(always)]
fn add_lanes<T: Real>(force: &mut [T], sum: &[T; LANES]) {
    for (force, &sum) in force.iter_mut().zip(sum) {
        *force += sum;
    }
}

#[inline(always)]
fn add_springs<T: Real>(
    springs: &GatheredSprings<T>,
    own: &[[T; LANES]; 6],
    other: &[[T; LANES]; 6],
    rest_lengths: &[T; LANES],
    sum: &mut [[T; LANES]; 3],
) {
    for lane in 0..LANES {
        let d = [other[0][lane] - own[0][lane], other[1][lane] - own[1][lane], other[2][lane] - own[2][lane]];
        let dv =
            [other[3][lane] - own[3][lane], other[4][lane] - own[4][lane], other[5][lane] - own[5][lane]];
        let factor = spring::factor(d, dv, springs.k, springs.damping, rest_lengths[lane]);
        sum[0][lane] += factor * d[0];
        sum[1][lane] += factor * d[1];
        sum[2][lane] += factor * d[2];
    }
}

/// Position and velocity of each lane's neighbour.
#[inline(always)]
pub fn gather<T: Real>(state: &[&[T]; 6], neighbours: &[u32; LANES], values: &mut [[T; LANES]; 6]) {
    let [x, y, z, u, v, w] = *state;
    for lane in 0..LANES {
        let node = neighbours[lane] as usize;
        // SAFETY: `GatheredSprings::new` asserted that neighbours are below the body's node count, and callers pass
        // columns with at least that many nodes.
        unsafe {
            values[0][lane] = *x.get_unchecked(node);
            values[1][lane] = *y.get_unchecked(node);
            values[2][lane] = *z.get_unchecked(node);
            values[3][lane] = *u.get_unchecked(node);
            values[4][lane] = *v.get_unchecked(node);
            values[5][lane] = *w.get_unchecked(node);
        }
    }
}

/// Position of each lane's neighbour.
#[inline(always)]
pub fn gather_places<T: Real>(places: &[&[T]; 3], neighbours: &[u32; LANES], values: &mut [[T; LANES]; 3]) {
    let [x, y, z] = *places;
    for lane in 0..LANES {
        let node = neighbours[lane] as usize;
        // SAFETY: as in `gather`.
        unsafe {
            values[0][lane] = *x.get_unchecked(node);
            values[1][lane] = *y.get_unchecked(node);
            values[2][lane] = *z.get_unchecked(node);
        }
    }
}
