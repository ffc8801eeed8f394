//! Constraints by lists, sixteen of a colour at a time.

use crate::cpu::shared::Shared;
use crate::cpu::simd::Kernel;
use crate::real::Real;
use crate::solvers::implicit::coarsening::Weighted;
use crate::solvers::xpbd::cpu::kernels::{Block, Length, Mixed, Pull, act};
use crate::solvers::xpbd::cpu::level::{FREE, LevelNodes};
use crate::solvers::xpbd::levels::{self, Coloured, Lists};
use crate::solvers::xpbd::project::Stiffness;
use crate::topology::{Csr, LANES};
use std::ops::Range;

/// A body by lists.
pub struct ListBody<T> {
    pub springs: ColourLists<T>,
    pub materials: Vec<[f64; 2]>,
    /// Mass of its lightest node [kg].
    pub lightest: f64,
    pub levels: Vec<ListLevel<T>>,
    /// Nodes of the levels.
    pub nodes: Vec<LevelNodes<T>>,
}

/// Constraints by colour, each colour a multiple of sixteen, of which the last may have fewer that act.
#[derive(Default)]
pub struct ColourLists<T> {
    pub ends: [Vec<u32>; 2],
    /// Squared lengths at rest [m²].
    pub rest: Vec<T>,
    pub material: Vec<u32>,
    /// How many of each sixteen act.
    pub counts: Vec<u8>,
    /// Sixteens of each colour.
    pub colours: Vec<Range<usize>>,
}

/// A level.
pub struct ListLevel<T> {
    pub own: Vec<u32>,
    pub parents: Weighted,
    /// Nodes of the finer level that follow each node, and how much of its mass theirs is.
    pub children: Csr,
    pub shares: Vec<T>,
    pub limits: ColourLists<T>,
}

impl<T: Real> ColourLists<T> {
    fn new(all: &Coloured) -> Self {
        let mut lists = Self { ends: [Vec::new(), Vec::new()], ..Self::default() };
        for colour in &all.colours {
            let from = lists.rest.len() / LANES;
            for index in colour.clone() {
                let [a, b] = all.ends[index];
                lists.push([a, b], T::from_f64(all.rest[index]), all.material[index]);
            }
            lists.counts.extend(colour.clone().step_by(LANES).map(|at| LANES.min(colour.end - at) as u8));
            while !lists.rest.len().is_multiple_of(LANES) {
                lists.push(all.ends[colour.end - 1], T::ONE, all.material[colour.end - 1]);
            }
            lists.colours.push(from..lists.rest.len() / LANES);
        }
        lists
    }

    fn push(&mut self, [a, b]: [u32; 2], rest: T, material: u32) {
        self.ends[0].push(a);
        self.ends[1].push(b);
        self.rest.push(rest);
        self.material.push(material);
    }

    fn bytes(&self) -> usize {
        (12 + size_of::<T>()) * self.rest.len()
    }
}

impl<T: Real> ListBody<T> {
    pub fn new(lists: &Lists, masses: &[f64]) -> Self {
        let (mut finer, mut nodes, mut all) = (masses.to_vec(), Vec::new(), Vec::new());
        for level in &lists.levels {
            let masses = levels::masses(&level.parents, level.own.len(), &finer);
            all.push(ListLevel::new(level, &finer, &masses));
            nodes.push(LevelNodes::new(&masses));
            finer = masses;
        }
        Self {
            nodes,
            springs: ColourLists::new(&lists.springs),
            materials: lists.materials.clone(),
            lightest: levels::lightest(masses),
            levels: all,
        }
    }

    pub fn bytes(&self) -> usize {
        let of_level = |level: &ListLevel<T>| {
            let parents = 4 * level.parents.offsets.len() + 8 * level.parents.items.len();
            let children = level.children.bytes() + size_of_val(&level.shares[..]);
            4 * level.own.len() + parents + children + level.limits.bytes()
        };
        let levels: usize = self.levels.iter().map(of_level).sum();
        levels + self.springs.bytes() + self.nodes.iter().map(LevelNodes::bytes).sum::<usize>()
    }
}

impl<T: Real> ListLevel<T> {
    fn new(level: &levels::Level, finer: &[f64], masses: &[f64]) -> Self {
        let parents = &level.parents;
        let pairs = || {
            (0..parents.rows()).flat_map(|row| parents.row(row).iter().map(move |one| (one.0, row as u32)))
        };
        let children = Csr::new(level.own.len(), pairs());
        let share = |(node, child): (usize, u32)| {
            let weight = parents
                .row(child as usize)
                .iter()
                .find(|one| one.0 as usize == node)
                .map_or(0.0, |one| one.1);
            let mass = masses[node];
            T::from_f64(if mass > 0.0 { f64::from(weight) * finer[child as usize] / mass } else { 0.0 })
        };
        let each =
            (0..level.own.len()).flat_map(|node| children.row(node).iter().map(move |&child| (node, child)));
        let shares = each.map(share).collect();
        Self {
            shares,
            children,
            own: level.own.clone(),
            parents: parents.clone(),
            limits: ColourLists::new(&level.limits),
        }
    }

    /// Which nodes of the finer level hold those of the level: their own, or else the last that follows one most.
    pub fn hold(&self, finer: &[T], held_by: &mut [u32]) {
        held_by.fill(FREE);
        for (row, _) in finer.iter().enumerate().filter(|(_, mass)| **mass <= T::ZERO) {
            let parents = self.parents.row(row).iter();
            if let Some(&(most, _)) = parents.reduce(|most, one| if one.1 > most.1 { one } else { most }) {
                let holder = &mut held_by[most as usize];
                if *holder != self.own[most as usize] {
                    *holder = row as u32;
                }
            }
        }
    }

    /// How far a node of the finer level goes with those that it follows.
    #[inline(always)]
    pub fn displacement(&self, row: usize, moved: &[T]) -> T {
        let mut by = T::ZERO;
        for &(parent, weight) in self.parents.row(row) {
            by += T::from_f64(f64::from(weight)) * moved[parent as usize];
        }
        by
    }

    /// The mean of the nodes that follow one.
    #[inline(always)]
    pub fn mean(&self, node: usize, position: &[T]) -> T {
        let first = self.children.offsets[node] as usize;
        let mut sum = T::ZERO;
        for (index, &child) in self.children.row(node).iter().enumerate() {
            sum += self.shares[first + index] * position[child as usize];
        }
        sum
    }
}

/// Kernel: lets some sixteens of a colour act.
///
/// No other worker reads or writes the nodes at the ends of these constraints until the next barrier.
pub struct ActLists<'a, T> {
    pub lists: &'a ColourLists<T>,
    pub sixteens: Range<usize>,
    /// Positions [m], of which those from `first` on are the body's.
    pub position: [&'a Shared<T>; 3],
    pub first: usize,
    pub inverse_mass: &'a [T],
    /// Places that the nodes had before [m], of the body.
    pub before: [&'a [T]; 3],
    /// By material; none: limits act.
    pub springs: Option<&'a [Stiffness<T>]>,
}

impl<T: Real> Kernel for ActLists<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        for sixteen in self.sixteens.clone() {
            match self.springs {
                None => self.act(sixteen, &Length),
                Some(springs) => {
                    let of = &self.lists.material[sixteen * LANES..(sixteen + 1) * LANES];
                    let mut mixed = Mixed { elastic: [T::ZERO; LANES], damping: [T::ZERO; LANES] };
                    for lane in 0..LANES {
                        let spring = springs[of[lane] as usize];
                        (mixed.elastic[lane], mixed.damping[lane]) = (spring.elastic, spring.damping);
                    }
                    self.act(sixteen, &mixed);
                }
            }
        }
    }
}

impl<T: Real> ActLists<'_, T> {
    #[inline(always)]
    fn act<P: Pull<T>>(&self, sixteen: usize, pull: &P) {
        let at = sixteen * LANES;
        let [mut a, mut b] = [self.take::<P>(at, 0), self.take::<P>(at, 1)];
        let mut rest = [T::ZERO; LANES];
        rest.copy_from_slice(&self.lists.rest[at..at + LANES]);
        act(pull, &mut a, &mut b, &rest);
        let count = usize::from(self.lists.counts[sixteen]);
        if count == LANES {
            self.put(at, LANES, [&a, &b]);
        } else {
            self.put(at, count, [&a, &b]);
        }
    }

    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "a lane of many columns")]
    fn take<P: Pull<T>>(&self, at: usize, end: usize) -> Block<T, LANES> {
        let mut all = Block::NONE;
        let ends = &self.lists.ends[end][at..at + LANES];
        for lane in 0..LANES {
            let node = ends[lane] as usize;
            // SAFETY: by the kernel's promise.
            let place = |axis: usize| unsafe { *self.position[axis].item(self.first + node) };
            (all.x[lane], all.y[lane], all.z[lane]) = (place(0), place(1), place(2));
            all.w[lane] = self.inverse_mass[node];
            if P::LOOKS_BACK {
                (all.x0[lane], all.y0[lane], all.z0[lane]) =
                    (self.before[0][node], self.before[1][node], self.before[2][node]);
            }
        }
        all
    }

    #[inline(always)]
    fn put(&self, at: usize, count: usize, ends: [&Block<T, LANES>; 2]) {
        for (end, all) in ends.into_iter().enumerate() {
            for lane in 0..count {
                self.put_one(at + lane, end, [all.x[lane], all.y[lane], all.z[lane]]);
            }
        }
    }

    #[inline(always)]
    fn put_one(&self, at: usize, end: usize, place: [T; 3]) {
        let node = self.first + self.lists.ends[end][at] as usize;
        for (column, x) in self.position.iter().zip(place) {
            // SAFETY: by the kernel's promise.
            unsafe { *column.item(node) = x };
        }
    }
}
