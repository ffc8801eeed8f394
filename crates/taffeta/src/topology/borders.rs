//! The open edges of a surface, put together to loops.

use crate::topology::Csr;

/// What open edges make together.
///
/// ```
/// use taffeta::scene::{Cylinder, Mesh};
/// use taffeta::topology::{Edges, shapes};
///
/// // A tube has two ends.
/// let tube = Cylinder { radius: 0.1, height: 0.3, segments: 12, rings: 3, capped: false };
/// let tube = shapes::surface(&Mesh::Cylinder(tube))?;
/// let borders = Edges::new(tube.nodes.len(), &tube.triangles, &[]).borders();
/// assert_eq!(borders.loops.iter().map(Vec::len).collect::<Vec<_>>(), [12, 12]);
/// assert_eq!(borders.ends, 0);
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Borders {
    /// Closed loops of nodes, each passing a node once: holes, and the outer border of a sheet. Loops that touch at a
    /// node are apart; where they touch at several nodes there is more than one way to tell them apart.
    pub loops: Vec<Vec<u32>>,
    /// Number of borders that end, at edges with more than two triangles.
    pub ends: usize,
}

impl Borders {
    /// Puts `open` edges together, whose nodes are all in `nodes`, ascending.
    pub(crate) fn new(nodes: &[u32], open: &[[u32; 2]]) -> Self {
        let place = |node: u32| nodes.partition_point(|n| *n < node) as u32;
        let edges: Vec<[u32; 2]> = open.iter().map(|edge| edge.map(place)).collect();
        let at = Csr::corners(nodes.len(), &edges);
        let mut walk = Walk { edges: &edges, used: vec![false; edges.len()], next: at.offsets.clone(), at };
        let mut borders = Self::default();
        let mut taken = vec![false; nodes.len()];
        // Borders that end are walked first, so that what is left closes.
        let odd = |n: &usize| walk.at.row(*n).len() % 2 == 1;
        let starts: Vec<usize> = (0..nodes.len()).filter(odd).chain(0..nodes.len()).collect();
        for start in starts {
            while let Some(first) = walk.step(start as u32) {
                let path = borders.follow(&mut walk, start as u32, first, &mut taken);
                borders.ends += usize::from(path.len() > 1);
                path.iter().for_each(|n| taken[*n as usize] = false);
            }
        }
        borders.loops.iter_mut().flatten().for_each(|n| *n = nodes[*n as usize]);
        borders
    }

    /// Walks on until there is no way, and takes off a loop whenever it comes to a node of its path. Returns the rest.
    fn follow(&mut self, walk: &mut Walk, start: u32, first: u32, taken: &mut [bool]) -> Vec<u32> {
        let mut path = vec![start];
        taken[start as usize] = true;
        let mut step = Some(first);
        while let Some(node) = step {
            if taken[node as usize] {
                let from = path.iter().rposition(|n| *n == node).unwrap_or(0);
                self.loops.push(path[from..].to_vec());
                path.drain(from + 1..).for_each(|n| taken[n as usize] = false);
            } else {
                taken[node as usize] = true;
                path.push(node);
            }
            step = walk.step(node);
        }
        path
    }
}

/// Edges that have been walked, and those that have not.
struct Walk<'a> {
    edges: &'a [[u32; 2]],
    at: Csr,
    used: Vec<bool>,
    /// Where each node's edges are looked at next.
    next: Vec<u32>,
}

impl Walk<'_> {
    /// Walks along an edge from `node` that has not been walked, and returns its other end.
    fn step(&mut self, node: u32) -> Option<u32> {
        let node = node as usize;
        while self.next[node] < self.at.offsets[node + 1] {
            let end = self.at.items[self.next[node] as usize] as usize;
            self.next[node] += 1;
            if !std::mem::replace(&mut self.used[end / 2], true) {
                return Some(self.edges[end / 2][1 - end % 2]);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn borders(open: &[[u32; 2]]) -> Borders {
        let mut nodes: Vec<u32> = open.as_flattened().to_vec();
        nodes.sort_unstable();
        nodes.dedup();
        Borders::new(&nodes, open)
    }

    #[test]
    fn loops_that_touch_at_a_node_are_two() {
        let eight = [[7, 1], [1, 2], [2, 7], [7, 3], [3, 4], [4, 7]];
        let found = borders(&eight);
        assert_eq!(found.ends, 0);
        assert_eq!(found.loops, [vec![1, 7, 2], vec![3, 7, 4]]);
    }

    #[test]
    fn a_border_that_ends_is_no_loop() {
        assert_eq!(borders(&[[0, 5], [5, 9]]), Borders { loops: vec![], ends: 1 });
        let with_loop = borders(&[[0, 1], [1, 2], [2, 3], [3, 1]]);
        assert_eq!((with_loop.loops.len(), with_loop.ends), (1, 1));
        assert_eq!(borders(&[]), Borders::default());
    }
}
