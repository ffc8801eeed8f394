//! Coarser levels of couplings, for a device: the Galerkin products of `couplings.rs`, as lists of what their blocks are made of.

use crate::assembly::Assembly;
use crate::solvers::implicit::coarsening::Weighted;
use crate::solvers::implicit::couplings::{Couplings, Tables};
use crate::solvers::implicit::levels::Level;
use crate::solvers::implicit::slots::{NO_EDGE, Slots};
use crate::topology::LANES;
use std::ops::Range;

impl Tables {
    /// As [`Self::of_finest`] and with coarser levels, whose nodes are counted likewise. Springs on the finest level are in these
    /// slots.
    pub fn new(assembly: &Assembly, levels: &[Level], bodies: &Range<usize>, slots: &Slots) -> Option<Self> {
        let mut tables = Self::of_finest(assembly, bodies)?;
        tables.add_coarser(assembly, levels, bodies, slots);
        Some(tables)
    }

    fn add_coarser(&mut self, assembly: &Assembly, levels: &[Level], bodies: &Range<usize>, slots: &Slots) {
        let (tables, first) = (self, assembly.bodies[bodies.start].first);
        let last = &assembly.bodies[bodies.end - 1];
        let mut finer = Finer {
            places: first..last.first + last.places(),
            is_plain: (0..bodies.end).map(|body| !assembly.has_solved_elements(body)).collect(),
            slots: slots.of_edge.iter().map(|&slot| tables.finest.len() as u32 + slot).collect(),
            first_edge: assembly.constraints().ends.partition_point(|ends| (ends[0] as usize) < first),
        };
        for (number, level) in levels.iter().enumerate() {
            let Some(here) = Finer::places_of(level, bodies) else { break };
            let own = if number == 0 {
                let from = tables.finest.len();
                let springs = |node| spring_row(slots, node).map(move |(slot, to)| (from + slot, to));
                let row = |node| tables.finest.row(node).chain(springs(node));
                finer.coarsened(level, &here, |node| (tables.finest.sum_of(node), row(node)))
            } else {
                let finest = &tables.coarser[number - 1];
                finer.coarsened(level, &here, |node| (finest.sum_of(node), finest.row(node)))
            };
            finer.step(level, here, &own);
            tables.coarser.push(own);
        }
    }
}

/// Slots of a node's springs, and the nodes at their other ends.
fn spring_row(springs: &Slots, node: usize) -> impl Iterator<Item = (usize, usize)> {
    let groups = springs.starts[node / LANES] as usize..springs.starts[node / LANES + 1] as usize;
    let slots = groups.map(move |group| group * LANES + node % LANES);
    slots.filter(|&slot| springs.edge[slot] != NO_EDGE).map(|slot| (slot, springs.neighbour[slot] as usize))
}

/// A level, as the next coarser one is made of it.
struct Finer {
    /// Its places in the scene.
    places: Range<usize>,
    /// By body: whether it has no elements. Its springs are coarsened edge by edge, as where no body has elements, if at all.
    is_plain: Vec<bool>,
    /// By edge from the first of the bodies on: its slot, where it is one of theirs.
    slots: Vec<u32>,
    first_edge: usize,
}

impl Finer {
    /// Places of some bodies on a level.
    fn places_of(level: &Level, bodies: &Range<usize>) -> Option<Range<usize>> {
        let of_bodies = &level.bodies[bodies.clone()];
        let places = of_bodies.first()?.start..of_bodies.last()?.end.next_multiple_of(LANES);
        (!places.is_empty()).then_some(places)
    }

    /// Whether a place of a coarser level is of a body without elements.
    fn is_plain(&self, level: &Level, place: usize) -> bool {
        self.is_plain[level.bodies.partition_point(|nodes| nodes.end <= place)]
    }

    /// Edges among some places of a coarser level that are made edge by edge.
    fn plain_edges(&self, level: &Level, here: &Range<usize>) -> impl Iterator<Item = (usize, [u32; 2])> {
        let all = edges_of(level, here).map(|edge| (edge, level.edges[edge]));
        all.filter(|(_, ends)| self.is_plain(level, ends[0] as usize))
    }

    /// The coarser level with these places: the Galerkin product of the blocks of each node's row.
    fn coarsened<R: Iterator<Item = (usize, usize)>>(
        &self,
        level: &Level,
        here: &Range<usize>,
        blocks: impl Fn(usize) -> (usize, R),
    ) -> Couplings<(u32, f32)> {
        let mut parents = Weighted::default();
        for place in self.places.clone() {
            let own = |&(parent, weight): &(u32, f32)| (parent - here.start as u32, weight);
            parents.push(level.parents.row(place).iter().map(own));
        }
        let mut plain: Vec<Vec<(u32, (u32, f32))>> = vec![Vec::new(); here.len()];
        for (edge, ends) in self.plain_edges(level, here) {
            let [a, b] = ends.map(|node| node - here.start as u32);
            for &(source, weight) in level.sources.row(edge) {
                let slot = self.slots[source as usize - self.first_edge];
                plain[a as usize].push((b, (slot, weight)));
                plain[b as usize].push((a, (slot, weight)));
            }
        }
        let children = parents.transposed(here.len());
        let mut couplings = Couplings::default();
        for slice in (0..here.len()).step_by(LANES) {
            let is_plain = self.is_plain(level, here.start + slice);
            let row = |lane: usize| {
                let place = slice + lane;
                if is_plain {
                    return std::mem::take(&mut plain[place]);
                }
                galerkin_row(place as u32, &parents, children.row(place), &blocks)
            };
            couplings.push_slice(std::array::from_fn(row), !is_plain);
        }
        couplings
    }

    /// Goes on to the coarser level that was made.
    fn step(&mut self, level: &Level, here: Range<usize>, couplings: &Couplings<(u32, f32)>) {
        let edges = edges_of(level, &here);
        let mut slots = vec![u32::MAX; edges.len()];
        for (edge, ends) in self.plain_edges(level, &here) {
            let [a, b] = ends.map(|node| node as usize - here.start);
            let slot = couplings.row(a).find(|slot| slot.1 == b).map(|slot| slot.0 as u32);
            slots[edge - edges.start] = slot.expect("every edge has a slot");
        }
        (self.slots, self.first_edge, self.places) = (slots, edges.start, here);
    }
}

/// Edges among some places of a level: those are in the order of places.
fn edges_of(level: &Level, places: &Range<usize>) -> Range<usize> {
    let before = |place: usize| level.edges.partition_point(|ends| (ends[0] as usize) < place);
    before(places.start)..before(places.end)
}

/// Blocks of a coarse node, from the sum and the blocks of each node that follows it.
fn galerkin_row<R: Iterator<Item = (usize, usize)>>(
    place: u32,
    parents: &Weighted,
    children: &[(u32, f32)],
    blocks: impl Fn(usize) -> (usize, R),
) -> Vec<(u32, (u32, f32))> {
    let mut row = Vec::new();
    for &(child, own) in children {
        let (sum, blocks) = blocks(child as usize);
        let mut add = |slot: usize, node: usize, own: f32| {
            let others = parents.row(node).iter().filter(|one| one.0 != place);
            row.extend(others.map(|&(parent, weight)| (parent, (slot as u32, own * weight))));
        };
        add(sum, child as usize, -own);
        blocks.for_each(|(slot, other)| add(slot, other, own));
    }
    row
}

#[cfg(test)]
mod tests;
