//! The part of a grid that is looked at.

use crate::assembly::body::BodyAssembly;
use crate::elements::element::List;

/// Rows and columns of a grid that are looked at: its corners and edges, and enough of its middle for the shortest
/// waves, which are the fastest.
const PATCH: usize = 48;

/// How far numbers of elements may differ that are those of one fabric.
const SAME: f64 = 1e-6;

/// A small grid that has the corners of another, or all of it: rows and columns of both.
#[derive(Clone, Copy)]
pub struct Patch {
    pub all: [usize; 2],
    pub small: [usize; 2],
}

impl Patch {
    /// The corners of a grid put together: its fastest waves are as short as two nodes. All of it where an element is like none
    /// of those in the corners, as in a zone of another fabric.
    pub fn of(body: &BodyAssembly, index: usize, elements: &[&List], layout: [usize; 2]) -> Self {
        let corners = Self { all: layout, small: layout.map(|count| count.min(PATCH)) };
        if corners.small == layout {
            return corners;
        }
        let is_shown = |list: &&List| {
            let of_body = || list.of(list.bodies[index].clone());
            let in_corners = |nodes: &[u32]| corners.mover(nodes, body.first).is_some();
            let mut known = Known::new(of_body().map(|(_, numbers)| numbers));
            of_body().filter(|(nodes, _)| in_corners(nodes)).for_each(|(_, numbers)| known.add(numbers));
            of_body().filter(|(nodes, _)| !in_corners(nodes)).all(|(_, numbers)| known.has(numbers))
        };
        if elements.iter().all(is_shown) { corners } else { Self { all: layout, small: layout } }
    }

    /// The grid's node of a node of the patch.
    pub fn of_grid(&self, node: usize) -> usize {
        let real = |axis: usize, i: usize| {
            if i < self.small[axis] / 2 { i } else { i + self.all[axis] - self.small[axis] }
        };
        real(0, node / self.small[1]) * self.all[1] + real(1, node % self.small[1])
    }

    /// How the nodes of an element go over to the patch, if its first row and column are of those that the patch has.
    pub fn mover(&self, nodes: &[u32], first: usize) -> Option<impl Fn(u32) -> Option<u32> + use<>> {
        let Self { all, small } = *self;
        let place = move |node: u32| {
            let node = node as usize - first;
            [node / all[1], node % all[1]]
        };
        let mut back = [0; 2];
        for axis in 0..2 {
            let least = nodes.iter().map(|&node| place(node)[axis]).min()?;
            if least >= small[axis] / 2 {
                back[axis] = all[axis] - small[axis];
                least.checked_sub(back[axis] + small[axis] / 2)?;
            }
        }
        Some(move |node: u32| {
            let [row, col] = place(node);
            let [row, col] = [row - back[0], col - back[1]];
            (row < small[0] && col < small[1]).then_some((row * small[1] + col) as u32)
        })
    }
}

/// Elements with different numbers.
struct Known<'a> {
    /// Largest of each number.
    scales: Vec<f64>,
    /// The last one asked for first.
    all: Vec<&'a [f64]>,
}

impl<'a> Known<'a> {
    /// None yet, among all of these.
    fn new(numbers: impl Iterator<Item = &'a [f64]>) -> Self {
        let mut scales: Vec<f64> = Vec::new();
        for one in numbers {
            scales.resize(one.len(), 0.0);
            scales.iter_mut().zip(one).for_each(|(scale, number)| *scale = scale.max(number.abs()));
        }
        Self { scales, all: Vec::new() }
    }

    /// Whether one is known that is the same but for roundings.
    fn has(&mut self, numbers: &[f64]) -> bool {
        let same = |other: &&[f64]| {
            let pairs = other.iter().zip(numbers).zip(&self.scales);
            pairs.into_iter().all(|((a, b), scale)| (a - b).abs() <= SAME * scale)
        };
        let found = self.all.iter().position(same);
        found.is_some_and(|at| {
            self.all[..=at].rotate_right(1);
            true
        })
    }

    fn add(&mut self, numbers: &'a [f64]) {
        if !self.has(numbers) {
            self.all.push(numbers);
        }
    }
}
