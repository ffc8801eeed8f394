//! Which triangles meet at an edge, found by counting.

use super::clean::counted;

/// Nothing across: an open edge.
pub(super) const OPEN: u32 = u32::MAX;
/// Across is more than one triangle.
pub(super) const CROWDED: u32 = u32::MAX - 1;
/// Set in a side across that runs the same way along the edge, so that the surface changes its winding there.
const SAME_WAY: u32 = 1 << 31;
/// Most triangles whose sides can be numbered beside these marks.
pub(super) const MOST_TRIANGLES: u32 = (SAME_WAY - 2) / 3;

/// Sides that are sorted at a time: what stays in the cache,
const BLOCK: usize = 1 << 20;
/// but in no more passes over the triangles than this.
const BLOCKS: usize = 16;
/// How many edges a message names.
const NAMED: usize = 3;

/// Neighbours across edges. Side `3·triangle + i` runs from the triangle's corner i to i + 1.
pub(super) struct Edges {
    /// The side across the edge of each side, or [`OPEN`], or [`CROWDED`].
    across: Vec<u32>,
    /// Sides of the edges with more than two triangles, edge after edge.
    crowded: Vec<u32>,
    /// Where each of these edges ends in `crowded`.
    ends: Vec<u32>,
}

/// What is across a side.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Across {
    Open,
    Crowded,
    /// A side of another triangle, and whether it runs the same way.
    Side(u32, bool),
}

impl Edges {
    /// The edges of triangles, none of which has a node twice.
    pub fn of(nodes: usize, triangles: &[[u32; 3]]) -> Self {
        let mut edges =
            Self { across: vec![OPEN; 3 * triangles.len()], crowded: Vec::new(), ends: Vec::new() };
        let blocks = (edges.across.len() / BLOCK).clamp(1, BLOCKS);
        let block = nodes.div_ceil(blocks);
        let mut rows = Rows::default();
        for first in (0..nodes).step_by(block) {
            rows.gather(first as u32, block.min(nodes - first), triangles);
            let mut start = 0;
            for end in rows.ends.iter().map(|end| *end as usize) {
                let row = &mut rows.runs[start..end];
                row.sort_unstable();
                row.chunk_by(|a, b| a.other() == b.other()).for_each(|edge| edges.push(edge));
                start = end;
            }
        }
        edges
    }

    fn push(&mut self, edge: &[Run]) {
        match *edge {
            [_] => {}
            [a, b] => {
                let mark = if a.rises() == b.rises() { SAME_WAY } else { 0 };
                self.across[a.side() as usize] = b.side() | mark;
                self.across[b.side() as usize] = a.side() | mark;
            }
            _ => {
                for run in edge {
                    self.across[run.side() as usize] = CROWDED;
                    self.crowded.push(run.side());
                }
                self.ends.push(self.crowded.len() as u32);
            }
        }
    }

    /// What is across a side.
    pub fn across(&self, side: u32) -> Across {
        match self.across[side as usize] {
            OPEN => Across::Open,
            CROWDED => Across::Crowded,
            other => Across::Side(other & !SAME_WAY, other & SAME_WAY != 0),
        }
    }

    /// Number of sides.
    pub fn sides(&self) -> u32 {
        self.across.len() as u32
    }

    /// The sides at each edge with more than two triangles.
    pub fn crowded(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(&0).chain(&self.ends);
        starts.zip(&self.ends).map(|(&start, &end)| &self.crowded[start as usize..end as usize])
    }

    /// Follows triangles that are turned over by an exchange of corners 1 and 2: their sides 0 and 2 change places.
    pub fn turn(&mut self, turned: &[bool]) {
        let of = |side: u32| turned[side as usize / 3];
        let new = |side: u32| if of(side) { side - side % 3 + (2 - side % 3) } else { side };
        for (sides, own) in self.across.chunks_exact_mut(3).zip(turned) {
            if *own {
                sides.swap(0, 2);
            }
            for side in sides.iter_mut().filter(|side| !matches!(**side, OPEN | CROWDED)) {
                let (other, mark) = (*side & !SAME_WAY, *side & SAME_WAY);
                *side = new(other) | if *own == of(other) { mark } else { mark ^ SAME_WAY };
            }
        }
        self.crowded.iter_mut().for_each(|side| *side = new(*side));
    }

    /// Says how many edges have more than two triangles, and between which vertices the first of them run.
    pub fn report(&self, triangles: &[[u32; 3]], node_of_vertex: &[u32], repairs: &mut Vec<String>) {
        if self.ends.is_empty() {
            return;
        }
        let vertex = |node: u32| node_of_vertex.iter().position(|&n| n == node).unwrap_or(0);
        let named = self.crowded().take(NAMED).map(|sides| {
            let [a, b] = ends(triangles, sides[0]).map(vertex);
            format!("{} and {}", a.min(b), a.max(b))
        });
        let named: Vec<String> = named.collect();
        let more = if self.ends.len() > NAMED { ", …" } else { "" };
        let edges = counted(self.ends.len(), "edge");
        repairs.push(format!(
            "not a manifold: {edges} with more than two triangles, between vertices {}{more}",
            named.join(", ")
        ));
    }
}

/// The nodes that a side runs from and to.
pub(super) fn ends(triangles: &[[u32; 3]], side: u32) -> [u32; 2] {
    let (triangle, i) = (triangles[side as usize / 3], side as usize % 3);
    [triangle[i], triangle[(i + 1) % 3]]
}

/// A side seen from its smaller node: the larger one, and the side, with a mark if it runs from the smaller one.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Run(u64);

impl Run {
    fn new(side: u32, from: u32, to: u32) -> Self {
        Self(u64::from(from.max(to)) << 32 | u64::from(side) << 1 | u64::from(from < to))
    }

    fn other(self) -> u32 {
        (self.0 >> 32) as u32
    }

    fn side(self) -> u32 {
        self.0 as u32 >> 1
    }

    fn rises(self) -> bool {
        self.0 & 1 == 1
    }
}

/// Sides by their smaller node, for some nodes.
#[derive(Default)]
struct Rows {
    /// Where each row ends in `runs`.
    ends: Vec<u32>,
    runs: Vec<Run>,
}

impl Rows {
    /// Sorts, by counting, the sides whose smaller node is one of the `count` from `first`.
    fn gather(&mut self, first: u32, count: usize, triangles: &[[u32; 3]]) {
        let Self { ends, runs } = self;
        let row = |from: u32, to: u32| from.min(to).wrapping_sub(first) as usize;
        ends.clear();
        ends.resize(count, 0);
        for &[a, b, c] in triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                ends.get_mut(row(from, to)).into_iter().for_each(|count| *count += 1);
            }
        }
        let mut sum = 0;
        ends.iter_mut().for_each(|end| (*end, sum) = (sum, sum + *end));
        runs.clear();
        runs.resize(sum as usize, Run::default());
        // Each row's end starts as its start, and moves up with each side.
        for (&[a, b, c], side) in triangles.iter().zip((0..).step_by(3)) {
            for (side, [from, to]) in (side..).zip([[a, b], [b, c], [c, a]]) {
                if let Some(end) = ends.get_mut(row(from, to)) {
                    runs[*end as usize] = Run::new(side, from, to);
                    *end += 1;
                }
            }
        }
    }
}
