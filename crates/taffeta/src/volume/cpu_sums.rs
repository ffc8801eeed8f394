//! Memory and sums of the bodies that keep their volume. A body is summed up in groups of 256 nodes, each by halves,
//! then its groups the same way. This order depends on neither threads nor vector width, and a GPU can use it.

use crate::assembly::Assembly;
use crate::cpu::column::Column;
use crate::cpu::tiles::TilePlan;
use crate::real::Real;
use crate::topology::LANES;
use crate::volume::volume::{self, Form, Node, SUMS, VolumeCorrection, WEIGHTED_SUMS};
use std::ops::Range;

/// Nodes that are summed up together.
pub const GROUP: usize = 256;

/// A body that keeps its volume, or is under a pressure.
pub struct VolumeBody<T> {
    /// Its first node, the reference of positions.
    pub first: usize,
    /// How the multiplier is found.
    pub form: Form,
    /// Whether nodes are moved after contact.
    pub projects: bool,
    /// Weights of its nodes.
    pub weights: Option<Column<T>>,
    /// Its places among those of all such bodies.
    pub places: Range<usize>,
    /// Its groups among those of all such bodies.
    pub groups: Range<usize>,
}

impl<T: Real> VolumeBody<T> {
    /// All of a scene, and which of them each body is.
    pub fn all(assembly: &Assembly) -> (Vec<Self>, Vec<Option<usize>>) {
        let (mut all, mut of_body): (Vec<Self>, _) = (Vec::new(), Vec::new());
        for body in &assembly.bodies {
            let Some(kept) = body.volume() else {
                of_body.push(None);
                continue;
            };
            of_body.push(Some(all.len()));
            let (place, group) = all.last().map_or((0, 0), |last| (last.places.end, last.groups.end));
            all.push(Self {
                first: body.first,
                form: kept.form,
                projects: kept.projects,
                weights: kept.weights.as_ref().map(|weights| column(weights)),
                places: place..place + body.places(),
                groups: group..group + body.nodes.div_ceil(GROUP),
            });
        }
        (all, of_body)
    }

    /// The number of its sums.
    fn numbers(&self) -> usize {
        if self.weights.is_some() { WEIGHTED_SUMS } else { SUMS }
    }

    /// Sums up its groups.
    fn sums(&self, groups: &[[T; WEIGHTED_SUMS]]) -> [T; WEIGHTED_SUMS] {
        let mut sums = [T::ZERO; WEIGHTED_SUMS];
        for (number, sum) in sums.iter_mut().enumerate().take(self.numbers()) {
            let mut lanes = [T::ZERO; GROUP];
            for (i, group) in groups[self.groups.clone()].iter().enumerate() {
                lanes[i % GROUP] += group[number];
            }
            *sum = halves(&mut lanes);
        }
        sums
    }

    /// The correction of a sub-step of `h` [s].
    pub fn correction(&self, groups: &[[T; WEIGHTED_SUMS]], goal: T, h: T) -> VolumeCorrection<T> {
        volume::correction(self.form, &self.sums(groups)[..self.numbers()], goal, h)
    }

    /// The correction that restores the volume; `None` if it is within tolerance.
    pub fn projection(&self, groups: &[[T; WEIGHTED_SUMS]], goal: T) -> Option<VolumeCorrection<T>> {
        volume::projection(&self.sums(groups)[..self.numbers()], goal, T::PROJECTED)
    }

    /// The index of a run of the scene's places among those of all such bodies.
    pub fn among(&self, run: &Range<usize>) -> Range<usize> {
        let shift = |place: usize| place - self.first + self.places.start;
        shift(run.start)..shift(run.end)
    }
}

fn column<T: Real>(numbers: &[f64]) -> Column<T> {
    let mut column = Column::zeros(numbers.len());
    column.iter_mut().zip(numbers).for_each(|(to, &from)| *to = T::from_f64(from));
    column
}

/// The sum of all lanes: the upper half is added to the lower, repeatedly.
#[inline(always)]
fn halves<T: Real>(lanes: &mut [T; GROUP]) -> T {
    let mut half = GROUP / 2;
    while half > 0 {
        let (low, high) = lanes.split_at_mut(half);
        low.iter_mut().zip(&high[..half]).for_each(|(low, &high)| *low += high);
        half /= 2;
    }
    lanes[0]
}

/// Nodes that are summed up. It is a trait because closures are not always inlined, and a kernel must be.
pub trait Summed<T>: Sized {
    /// Some of them; `#[inline(always)]`, as all of these.
    fn part(&self, part: &Range<usize>) -> Self;
    /// One of them.
    fn node(&self, i: usize) -> Node<T>;
}

/// Sums of a part of a tile, `GROUP` nodes at most.
#[inline(always)]
pub fn group_sums<T: Real>(part: &Range<usize>, nodes: &impl Summed<T>) -> [T; WEIGHTED_SUMS] {
    let [mut volumes, mut fluxes, mut responses] = [[T::ZERO; GROUP]; SUMS];
    let (n, nodes) = (part.len(), nodes.part(part));
    let (volume, flux, response) = (&mut volumes[..n], &mut fluxes[..n], &mut responses[..n]);
    for i in 0..n {
        [volume[i], flux[i], response[i]] = volume::terms(&nodes.node(i));
    }
    let mut sums = [T::ZERO; WEIGHTED_SUMS];
    sums[0] = halves(&mut volumes);
    sums[1] = halves(&mut fluxes);
    sums[2] = halves(&mut responses);
    sums
}

/// The same of nodes with weights and masses [kg].
pub fn weighted_group_sums<T: Real>(
    part: &Range<usize>,
    nodes: &impl Summed<T>,
    weights: &[T],
    mass: &[T],
) -> [T; WEIGHTED_SUMS] {
    let mut lanes = [[T::ZERO; GROUP]; WEIGHTED_SUMS];
    for (at, i) in part.clone().enumerate() {
        let terms = volume::weighted_terms(&nodes.node(i), weights[i], mass[i]);
        lanes.iter_mut().zip(terms).for_each(|(lanes, term)| lanes[at] = term);
    }
    lanes.each_mut().map(halves)
}

/// The groups of a tile: number among those of its body, and places in the tile.
pub fn groups(plan: &TilePlan) -> impl Iterator<Item = (usize, Range<usize>)> + use<> {
    let (first, len) = (plan.units.start * LANES / GROUP, plan.len());
    (0..len.div_ceil(GROUP)).map(move |i| (first + i, i * GROUP..len.min((i + 1) * GROUP)))
}
