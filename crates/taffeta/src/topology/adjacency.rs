//! Which springs and elements meet at a node, laid out for kernels that gather.

use crate::real::LANES;

/// Springs by node, in slices of [`LANES`] nodes (sliced ELLPACK; Monakov, Lokhmotov and Avetisyan 2010).
///
/// Entry `k` of node `16·slice + lane` is at `slice_starts[slice] + 16·k + lane`. Each spring is at both of its
/// ends, each node's entries ascend by neighbour. Each slice is as long as its longest node; what is left is padded
/// with the node itself (lanes past the end: with the last node) and rest length 0, where the vector between the
/// ends is zero and so is the force.
///
/// ```
/// use taffeta::topology::{Gather, LANES};
///
/// // Two springs in a row: the middle node, 1, has both.
/// let gather = Gather::new(3, &[[0, 1], [1, 2]], &[0.1, 0.2])?;
/// let entries = [1, 1 + LANES];
/// assert_eq!(entries.map(|entry| gather.neighbour[entry]), [0, 2]);
/// assert_eq!(entries.map(|entry| gather.rest[entry]), [0.1, 0.2]);
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gather {
    /// Entry offset of each slice; one more than there are slices.
    pub slice_starts: Vec<u32>,
    /// The node at the other end of the spring.
    pub neighbour: Vec<u32>,
    /// Rest length [m].
    pub rest: Vec<f64>,
}

impl Gather {
    /// Lays out the springs `pairs` with rest lengths `rest` [m] among `nodes` nodes. Refuses what 32-bit offsets
    /// cannot reach.
    ///
    /// # Panics
    /// Where a spring has an end beyond `nodes`, or no rest length.
    pub fn new(nodes: usize, pairs: &[[u32; 2]], rest: &[f64]) -> Result<Self, String> {
        let by_node = Csr::corners(nodes, pairs);
        let row = |node: usize| {
            let other = |end: &u32| (pairs[*end as usize / 2][1 - *end as usize % 2], end / 2);
            let mut row: Vec<(u32, u32)> = by_node.row(node).iter().map(other).collect();
            row.sort_unstable();
            row.into_iter().map(|(neighbour, spring)| (neighbour, rest[spring as usize])).collect()
        };
        let mut gather = Self { slice_starts: vec![0], ..Self::default() };
        for slice in 0..nodes.div_ceil(LANES) {
            let rows: Vec<Vec<(u32, f64)>> =
                (slice * LANES..nodes.min((slice + 1) * LANES)).map(row).collect();
            gather.add_slice(slice, &rows, nodes)?;
        }
        Ok(gather)
    }

    /// Adds a slice: for each of its nodes, neighbours and rest lengths [m] in their order.
    pub(crate) fn add_slice(
        &mut self,
        slice: usize,
        rows: &[Vec<(u32, f64)>],
        nodes: usize,
    ) -> Result<(), String> {
        let longest = rows.iter().map(Vec::len).max().unwrap_or(0);
        let start = self.neighbour.len();
        self.pad(slice, longest, nodes);
        for (lane, row) in rows.iter().enumerate() {
            for (k, &(neighbour, rest)) in row.iter().enumerate() {
                let entry = start + k * LANES + lane;
                self.neighbour[entry] = neighbour;
                self.rest[entry] = rest;
            }
        }
        self.slice_starts.push(u32::try_from(self.neighbour.len()).map_err(|_| too_many())?);
        Ok(())
    }

    /// Adds `longest` empty entries for each lane of a slice.
    fn pad(&mut self, slice: usize, longest: usize, nodes: usize) {
        for _ in 0..longest {
            self.neighbour.extend((0..LANES).map(|lane| (slice * LANES + lane).min(nodes - 1) as u32));
        }
        self.rest.resize(self.neighbour.len(), 0.0);
    }
}

fn too_many() -> String {
    "the body has too many springs of one kind: 4294967296 entries are the limit; a coarser mesh would do"
        .into()
}

/// Items by row (compressed sparse rows).
///
/// ```
/// use taffeta::topology::{Csr, shapes::grid_surface};
///
/// // The triangles at a node.
/// let sheet = grid_surface(2, 3, [0.2, 0.1]);
/// let corners = Csr::corners(sheet.nodes.len(), &sheet.triangles);
/// let at_node: Vec<u32> = corners.row(4).iter().map(|corner| corner / 3).collect();
/// assert_eq!(at_node, [1, 2, 3]);
/// assert!(at_node.iter().all(|&triangle| sheet.triangles[triangle as usize].contains(&4)));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Csr {
    /// Where each row starts in `items`; one more than there are rows.
    pub offsets: Vec<u32>,
    /// Items, row after row, each row in the order in which it was given.
    pub items: Vec<u32>,
}

impl Csr {
    /// Sorts `(row, item)` entries, fewer than 2³², by row; counting, so that the order within a row is kept.
    ///
    /// # Panics
    /// Where an entry is of a row beyond `rows`.
    pub fn new(rows: usize, entries: impl Iterator<Item = (u32, u32)> + Clone) -> Self {
        let mut offsets = vec![0u32; rows + 1];
        for (row, _) in entries.clone() {
            offsets[row as usize + 1] += 1;
        }
        for row in 0..rows {
            offsets[row + 1] += offsets[row];
        }
        let mut next = offsets.clone();
        let mut items = vec![0; offsets[rows] as usize];
        for (row, item) in entries {
            let place = &mut next[row as usize];
            items[*place as usize] = item;
            *place += 1;
        }
        Self { offsets, items }
    }

    /// For each node the corners of elements (springs, triangles, hinges) at it: item = N·element + corner.
    ///
    /// # Panics
    /// Where an element names a node that is not there.
    pub fn corners<const N: usize>(nodes: usize, elements: &[[u32; N]]) -> Self {
        Self::new(nodes, elements.as_flattened().iter().copied().zip(0..))
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.offsets[..]) + size_of_val(&self.items[..])
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Items of a row.
    pub fn row(&self, row: usize) -> &[u32] {
        &self.items[self.offsets[row] as usize..self.offsets[row + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::{Edges, measure::length, shapes::grid_surface};

    #[test]
    fn rows_hold_their_items_in_the_order_given() {
        let csr = Csr::new(4, [(2, 7), (0, 5), (2, 3), (3, 1)].into_iter());
        assert_eq!(csr.offsets, [0, 1, 1, 3, 4]);
        assert_eq!(csr.row(2), [7, 3]);
        assert!(csr.row(1).is_empty());
        assert_eq!(Csr::corners(3, &[[0, 1, 2], [2, 1, 0]]).row(2), [2, 3]);
    }

    #[test]
    fn gather_reproduces_the_springs_and_pads_with_the_node_itself() {
        let surface = grid_surface(5, 7, [2.0, 1.0]);
        let n = surface.nodes.len();
        let pairs = Edges::new(n, &surface.triangles, &[]).pairs;
        let rest: Vec<f64> = pairs.iter().map(|p| length(&surface.nodes, *p)).collect();
        let gather = Gather::new(n, &pairs, &rest).unwrap();
        assert_eq!(gather.slice_starts.len(), 4);
        let mut found = Vec::new();
        for slice in 0..3 {
            let [start, end] = [0, 1].map(|i| gather.slice_starts[slice + i] as usize);
            for lane in 0..LANES {
                let node = slice * LANES + lane;
                let entries: Vec<usize> = (start + lane..end).step_by(LANES).collect();
                let used = entries.iter().take_while(|e| gather.rest[**e] != 0.0).count();
                assert!(entries[..used].windows(2).all(|w| gather.neighbour[w[0]] < gather.neighbour[w[1]]));
                for &e in &entries[used..] {
                    assert_eq!((gather.neighbour[e], gather.rest[e]), (node.min(n - 1) as u32, 0.0));
                }
                found.extend(
                    entries[..used].iter().map(|&e| (node as u32, gather.neighbour[e], gather.rest[e])),
                );
            }
        }
        let mut given: Vec<_> =
            pairs.iter().zip(&rest).flat_map(|(&[a, b], &l)| [(a, b, l), (b, a, l)]).collect();
        given.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(found, given);
    }

    #[test]
    fn a_body_without_springs_or_nodes_has_empty_slices() {
        assert_eq!(Gather::new(17, &[], &[]).unwrap().slice_starts, [0, 0, 0]);
        assert_eq!(Gather::new(0, &[], &[]).unwrap().slice_starts, [0]);
    }
}
