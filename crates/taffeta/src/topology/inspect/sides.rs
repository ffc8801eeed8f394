use crate::topology::Edges;

/// The sides of triangles, side 3t + i from corner i of triangle t to the next, and the edges they lie on.
pub(crate) struct Sides {
    /// Edge of each side.
    pub edge: Vec<u32>,
    /// First side of each edge.
    pub first: Vec<u32>,
}

impl Sides {
    /// Looks up the edge of every side.
    pub fn new(nodes: usize, triangles: &[[u32; 3]], edges: &Edges) -> Self {
        // The edges are sorted, so those from one node follow each other.
        let mut start = vec![0_u32; nodes + 1];
        edges.pairs.iter().for_each(|pair| start[pair[0] as usize + 1] += 1);
        (0..nodes).for_each(|node| start[node + 1] += start[node]);
        let edge_of = |a: u32, b: u32| {
            let (low, high) = (a.min(b), a.max(b));
            let [from, to] = [start[low as usize], start[low as usize + 1]].map(|i| i as usize);
            (from + edges.pairs[from..to].partition_point(|pair| pair[1] < high)) as u32
        };
        let edge: Vec<u32> =
            triangles.iter().flat_map(|&[a, b, c]| [edge_of(a, b), edge_of(b, c), edge_of(c, a)]).collect();
        let mut first = vec![u32::MAX; edges.pairs.len()];
        for (side, edge) in (0..edge.len() as u32).zip(&edge).rev() {
            first[*edge as usize] = side;
        }
        Self { edge, first }
    }

    /// Pairs of sides on one edge: the first and each further one, with the number of triangles there.
    pub fn neighbours<'a>(&'a self, edges: &'a Edges) -> impl Iterator<Item = (u32, u32, u32)> + 'a {
        (0..self.edge.len() as u32).zip(&self.edge).filter_map(|(side, edge)| {
            let first = self.first[*edge as usize];
            (side != first).then_some((first, side, edges.uses[*edge as usize]))
        })
    }
}

/// Number of the corner after `corner`, both 3·triangle + i.
pub(crate) fn next(corner: u32) -> u32 {
    corner - corner % 3 + (corner + 1) % 3
}
