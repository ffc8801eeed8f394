//! Directions in which elements resist that are solved for, in lanes.

use crate::cpu::column::Column;
use crate::cpu::shared::Shared;
use crate::cpu::simd::Kernel;
use crate::elements::element::{Element, Kind, MODES, TENSIONS};
use crate::elements::lanes::{FindForces, Lanes, STAGGER, lane, lane_of, none, put};
use crate::real::Real;
use crate::topology::LANES;
use std::ops::Range;

/// Where directions of modes over a step [kg^½] are: a column for each mode, node and axis, and one for the weights of what resists
/// alike in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionLayout {
    /// Nodes of an element, and modes.
    pub nodes: usize,
    /// Modes of an element.
    pub modes: usize,
    /// Whether it has weights.
    pub is_tense: bool,
    /// From one column to the next.
    pub stride: usize,
    /// Where there are zeros.
    pub nowhere: u32,
}

/// Columns of a direction.
pub const NUMBERS: usize = 4;

impl DirectionLayout {
    /// Of so many elements of a kind that can be solved for.
    pub fn new(kind: &Kind, elements: usize) -> Option<Self> {
        let (implicit, blocks) = (kind.implicit.as_ref()?, elements.div_ceil(LANES));
        Some(Self {
            nodes: kind.nodes,
            modes: implicit.modes,
            is_tense: implicit.is_tense,
            stride: (blocks + 1 + STAGGER) * LANES,
            nowhere: (blocks * LANES) as u32,
        })
    }

    /// Where the direction of the first mode is at a node of an element, along the first axis.
    pub fn place(&self, element: usize, node: usize) -> usize {
        NUMBERS * node * self.stride + element
    }

    /// From one mode to the next.
    #[inline(always)]
    pub fn mode(&self) -> usize {
        NUMBERS * self.nodes * self.stride
    }

    fn len(&self) -> usize {
        self.modes * self.mode()
    }
}

/// Directions of modes over a step [kg^½].
pub struct Directions<T> {
    columns: Shared<T>,
    layout: DirectionLayout,
}

impl<T: Real> Directions<T> {
    /// Zeros, of so many elements of a kind that can be solved for.
    pub fn new(kind: &Kind, elements: usize) -> Option<Self> {
        let layout = DirectionLayout::new(kind, elements)?;
        Some(Self { columns: Column::zeros(layout.len()).into(), layout })
    }

    /// Those of some blocks, to write; nothing of modes that there are not.
    ///
    /// # Safety
    /// As of [`Shared::write`].
    #[expect(clippy::mut_from_ref, reason = "the caller promises that the reference is unique")]
    unsafe fn write<const N: usize>(&self, blocks: &Range<usize>) -> [[[&mut [T]; NUMBERS]; N]; MODES] {
        let places = blocks.start * LANES..blocks.end * LANES;
        let of = |mode: usize, node: usize, axis: usize| {
            let from = mode * self.layout.mode() + (NUMBERS * node + axis) * self.layout.stride;
            let is_there = mode < self.layout.modes && (axis < 3 || self.layout.is_tense);
            let range = if is_there { from + places.start..from + places.end } else { 0..0 };
            // SAFETY: promised by the caller; columns do not overlap.
            unsafe { self.columns.write(range) }
        };
        std::array::from_fn(|mode| {
            std::array::from_fn(|node| std::array::from_fn(|axis| of(mode, node, axis)))
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

    /// Those of `count` elements one after the other, by mode, then by node, with weights as fourth numbers.
    #[cfg(feature = "gpu")]
    pub fn listed(&self, count: usize, all: &[T]) -> Vec<[T; NUMBERS]> {
        let layout = self.layout;
        let modes = move |element| (0..layout.modes).map(move |mode| (element, mode));
        let nodes = move |(element, mode)| (0..layout.nodes).map(move |node| (element, mode, node));
        let at = |(element, mode, node)| {
            let from = mode * layout.mode() + layout.place(element, node);
            [0, 1, 2, 3].map(|axis| all[from + axis * layout.stride])
        };
        (0..count).flat_map(modes).flat_map(nodes).map(at).collect()
    }

    /// Where they are.
    pub fn layout(&self) -> DirectionLayout {
        self.layout
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        self.columns.bytes()
    }
}

/// Kernel: forces on the nodes of blocks of elements, and directions of their modes.
pub struct Linearise<'a, T, E, const N: usize, const P: usize> {
    forces: FindForces<'a, T, E, N, P>,
    directions: [[[&'a mut [T]; NUMBERS]; N]; MODES],
    /// Step [s].
    h: T,
}

impl<'a, T: Real, E: Element<N, P>, const N: usize, const P: usize> Linearise<'a, T, E, N, P> {
    /// Of the same blocks.
    ///
    /// # Safety
    /// As of [`Shared::write`].
    pub unsafe fn new(forces: FindForces<'a, T, E, N, P>, directions: &'a Directions<T>, h: T) -> Self {
        // SAFETY: promised by the caller.
        let directions = unsafe { directions.write(&forces.part) };
        Self { forces, directions, h }
    }
}

impl<T: Real, E: Element<N, P>, const N: usize, const P: usize> Kernel for Linearise<'_, T, E, N, P> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { forces, mut directions, h } = self;
        let FindForces { blocks, state: [x, y, z, u, v, w], part, mut out, .. } = forces;
        let (mut places, mut velocities, mut found) = (none(), none(), none());
        let mut modes = [none::<T, NUMBERS, N>(); MODES];
        for (at, block) in part.enumerate() {
            blocks.fetch(block, [x, y, z], &mut places);
            blocks.fetch(block, [u, v, w], &mut velocities);
            let numbers = blocks.numbers(block);
            for one in 0..LANES {
                let (x, numbers) = (lane(&places, one), lane_of(numbers, one));
                let forces = E::forces(x, lane(&velocities, one), numbers);
                for node in 0..N {
                    for axis in 0..3 {
                        found[node][axis][one] = forces[node][axis];
                    }
                }
                let (found, tensions) = (E::modes(x, numbers), E::tensions(x, numbers));
                for mode in 0..MODES {
                    let directions = found[mode].over_step(h);
                    for node in 0..N {
                        for axis in 0..3 {
                            modes[mode][node][axis][one] = directions[node][axis];
                        }
                    }
                }
                for tension in 0..TENSIONS {
                    let (weights, k) = tensions[tension];
                    let root = (h * (h * k)).sqrt();
                    for node in 0..N {
                        modes[tension][node][3][one] = weights[node] * root;
                    }
                }
            }
            put(&mut out, at, &found);
            for (out, found) in directions.iter_mut().zip(&modes) {
                put_some(out, at, found);
            }
        }
    }
}

/// Writes the numbers of a block, of columns that are there.
#[inline(always)]
fn put_some<T: Real, const A: usize, const N: usize>(
    out: &mut [[&mut [T]; A]; N],
    at: usize,
    found: &[[Lanes<T>; A]; N],
) {
    for (columns, found) in out.iter_mut().zip(found) {
        for (column, found) in columns.iter_mut().zip(found) {
            if !column.is_empty() {
                column[at * LANES..(at + 1) * LANES].copy_from_slice(found);
            }
        }
    }
}
