//! Edges of graphs by node, laid out for kernels that gather.

use crate::topology::{Csr, LANES};
use std::ops::Range;

/// No edge.
pub const NO_EDGE: u32 = u32::MAX;

/// Edges by node, in slices of [`LANES`] nodes as [`Gather`](super::Gather): slot `k` of node `16·slice + lane` is at
/// `16·(starts[slice] + k) + lane`. Each edge has a slot at both of its ends. What a slice's longest node does not need is
/// padded with the node itself and no edge.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Slots {
    /// Groups of sixteen slots before each slice; one more than there are slices.
    pub starts: Vec<u32>,
    /// The node at the other end.
    pub neighbour: Vec<u32>,
    /// The edge.
    pub edge: Vec<u32>,
    /// By edge: its slot at its first end.
    pub of_edge: Vec<u32>,
    /// By body: how much further on the neighbour of each slot is, of a grid; else nothing. A grid's slots without an edge
    /// are padded, too.
    pub shifts: Vec<Vec<i32>>,
}

impl Slots {
    /// Lays out `edges`, whose ends ascend, among `places`; bodies are grids or not, each from a multiple of [`LANES`] on.
    pub fn new(places: usize, edges: &[[u32; 2]], bodies: &[(Range<usize>, bool)]) -> Self {
        let by_node = Csr::corners(places, edges);
        let mut slots = Self { starts: vec![0], of_edge: vec![0; edges.len()], ..Self::default() };
        for (body, is_grid) in bodies {
            let shifts = if *is_grid { shifts(&by_node, edges, body.clone()) } else { Vec::new() };
            // A body that has no nodes here takes no slices, either.
            for slice in body.start / LANES..body.end.div_ceil(LANES) {
                slots.pad_to(slice);
                slots.add_slice(slice, (&by_node, edges, body.end), &shifts);
            }
            slots.shifts.push(shifts);
        }
        slots.pad_to(places / LANES);
        slots
    }

    /// Empty slices up to one.
    fn pad_to(&mut self, slice: usize) {
        let last = self.starts[self.starts.len() - 1];
        self.starts.resize(self.starts.len().max(slice + 1), last);
    }

    fn add_slice(&mut self, slice: usize, (by_node, edges, end): (&Csr, &[[u32; 2]], usize), shifts: &[i32]) {
        let nodes = slice * LANES..end.min((slice + 1) * LANES);
        let row = |node: usize| {
            let other = |&corner: &u32| (edges[corner as usize / 2][1 - corner as usize % 2], corner);
            let mut row: Vec<(u32, u32)> = by_node.row(node).iter().map(other).collect();
            row.sort_unstable();
            row
        };
        let rows: Vec<Vec<(u32, u32)>> = nodes.clone().map(row).collect();
        let longest =
            if shifts.is_empty() { rows.iter().map(Vec::len).max().unwrap_or(0) } else { shifts.len() };
        let start = self.neighbour.len();
        for _ in 0..longest {
            self.neighbour.extend((0..LANES).map(|lane| (slice * LANES + lane) as u32));
        }
        self.edge.resize(self.neighbour.len(), NO_EDGE);
        for (lane, (row, node)) in rows.iter().zip(nodes).enumerate() {
            for (k, &(neighbour, corner)) in row.iter().enumerate() {
                let shift = i64::from(neighbour) - node as i64;
                let k = shifts.iter().position(|&one| i64::from(one) == shift).unwrap_or(k);
                let slot = start + k * LANES + lane;
                (self.neighbour[slot], self.edge[slot]) = (neighbour, corner / 2);
                if corner % 2 == 0 {
                    self.of_edge[corner as usize / 2] = slot as u32;
                }
            }
        }
        self.starts.push((self.neighbour.len() / LANES) as u32);
    }
}

/// How far the ends of a grid's edges are from each other, both ways.
fn shifts(by_node: &Csr, edges: &[[u32; 2]], body: Range<usize>) -> Vec<i32> {
    let mut shifts: Vec<i32> = Vec::new();
    for node in body {
        for &corner in by_node.row(node) {
            let [a, b] = edges[corner as usize / 2];
            let shift = (b - a) as i32;
            if let Err(at) = shifts.binary_search(&shift) {
                shifts.insert(at, shift);
            }
        }
    }
    shifts.iter().rev().map(|shift| -shift).chain(shifts.iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(slots: &Slots, edges: &[[u32; 2]], places: usize) {
        assert_eq!(slots.starts.len(), places / LANES + 1);
        let mut seen = vec![0; edges.len()];
        for slice in 0..places / LANES {
            for slot in slots.starts[slice] as usize * LANES..slots.starts[slice + 1] as usize * LANES {
                let (node, edge) = ((slice * LANES + slot % LANES) as u32, slots.edge[slot]);
                if edge == NO_EDGE {
                    assert_eq!(slots.neighbour[slot], node);
                    continue;
                }
                let [a, b] = edges[edge as usize];
                assert_eq!(
                    [a.min(b), a.max(b)],
                    [node.min(slots.neighbour[slot]), node.max(slots.neighbour[slot])]
                );
                assert_eq!(slots.of_edge[edge as usize] as usize == slot, node == a);
                seen[edge as usize] += 1;
            }
        }
        assert!(seen.iter().all(|&count| count == 2));
    }

    #[test]
    fn every_edge_has_a_slot_at_both_ends() {
        let edges = [[0, 1], [0, 19], [1, 2], [32, 33], [33, 40]];
        let slots = Slots::new(48, &edges, &[(0..20, false), (32..32, false), (32..41, false)]);
        check(&slots, &edges, 48);
        assert_eq!(slots.starts, [0, 2, 3, 5]);
    }

    #[test]
    fn slots_of_a_grid_are_as_far_away_for_all_its_nodes() {
        for cols in 1..6_u32 {
            let rows = 7;
            let mut edges = Vec::new();
            for (row, col) in (0..rows).flat_map(|row| (0..cols).map(move |col| (row, col))) {
                for (down, across) in crate::elements::spring::stencil::GRID_STEPS {
                    let (to, there) = (row + down as u32, i64::from(col) + across as i64);
                    if to < rows && (0..i64::from(cols)).contains(&there) {
                        edges.push([row * cols + col, to * cols + there as u32]);
                    }
                }
            }
            let nodes = (rows * cols) as usize;
            let places = nodes.next_multiple_of(LANES);
            let slots = Slots::new(places, &edges, &[(0..nodes, true)]);
            check(&slots, &edges, places);
            let width = slots.shifts[0].len();
            for (slot, (&edge, &neighbour)) in slots.edge.iter().zip(&slots.neighbour).enumerate() {
                let node = slot / LANES / width * LANES + slot % LANES;
                let shift = slots.shifts[0][slot / LANES % width];
                assert!(edge == NO_EDGE || i64::from(neighbour) == node as i64 + i64::from(shift));
            }
        }
    }
}
