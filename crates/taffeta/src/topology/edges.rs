//! Edges of a surface, and what lies at either side of them.

use crate::topology::{Borders, Csr};

/// No triangle at this side of an edge.
pub const NONE: u32 = u32::MAX;

/// The undirected edges of a surface, found by sorting.
///
/// ```
/// use taffeta::topology::{Edges, NONE, shapes::grid_surface};
///
/// let sheet = grid_surface(2, 3, [0.2, 0.1]);
/// let edges = Edges::new(sheet.nodes.len(), &sheet.triangles, &sheet.links);
/// assert_eq!((edges.pairs.len(), edges.boundary_edges(), edges.holes()), (9, 6, 1));
/// assert!(!edges.is_closed());
/// let open = edges.triangles.iter().filter(|sides| sides.contains(&NONE));
/// assert_eq!(open.count(), 6);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Edges {
    /// Ends `[a, b]`, a < b, sorted.
    pub pairs: Vec<[u32; 2]>,
    /// Triangles at each edge: the one that runs a→b, then the one that runs b→a; [`NONE`] where there is none.
    /// If two run the same way, or more than two meet: the first two, by index.
    pub triangles: Vec<[u32; 2]>,
    /// How many triangles meet at each edge: 0 a link, 1 an open edge, 2 the inside of a sheet, 3 or more none.
    pub uses: Vec<u32>,
    /// Edges whose two triangles run along it the same way, so that the surface changes sides there.
    pub flipped: usize,
}

/// One triangle's run along an edge, or a link's: other end, triangle, whether from the larger to the smaller end.
type Run = (u32, u32, bool);

impl Edges {
    /// Finds the edges of triangles and links among `nodes` nodes; all indices are below `nodes`, and no triangle
    /// or link has a node twice.
    ///
    /// # Panics
    /// Where a triangle or a link names a node that is not there.
    pub fn new(nodes: usize, triangles: &[[u32; 3]], links: &[[u32; 2]]) -> Self {
        let half_edges = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let ends = half_edges.chain(links.iter().copied());
        let by_smaller = Csr::new(nodes, ends.clone().map(|[a, b]| a.min(b)).zip(0..));
        let mut edges = Self::default();
        let mut runs: Vec<Run> = Vec::new();
        for a in 0..nodes {
            runs.clear();
            runs.extend(by_smaller.row(a).iter().map(|&half| run(triangles, links, a as u32, half as usize)));
            runs.sort_unstable();
            for same in runs.chunk_by(|x, y| x.0 == y.0) {
                edges.push(a as u32, same);
            }
        }
        edges
    }

    /// Adds the edge from `a` that all of `runs` share.
    fn push(&mut self, a: u32, runs: &[Run]) {
        let real = &runs[..runs.iter().take_while(|r| r.1 != NONE).count()];
        self.pairs.push([a, runs[0].0]);
        self.uses.push(real.len() as u32);
        self.flipped += usize::from(matches!(real, [x, y] if x.2 == y.2));
        self.triangles.push(match *real {
            [] => [NONE; 2],
            [(_, t, false)] => [t, NONE],
            [(_, t, true)] => [NONE, t],
            [(_, t, true), (_, u, false)] => [u, t],
            [(_, t, _), (_, u, _), ..] => [t, u],
        });
    }

    /// Number of edges with one triangle.
    pub fn boundary_edges(&self) -> usize {
        self.uses.iter().filter(|n| **n == 1).count()
    }

    /// Number of edges with more than two triangles.
    pub fn non_manifold_edges(&self) -> usize {
        self.uses.iter().filter(|n| **n > 2).count()
    }

    /// Whether there are triangles, each edge has two, and they run along it in opposite directions.
    pub fn is_closed(&self) -> bool {
        !self.pairs.is_empty() && self.flipped == 0 && self.uses.iter().all(|n| *n == 2)
    }

    /// Nodes on an open edge, ascending.
    pub fn boundary_nodes(&self) -> Vec<u32> {
        let mut nodes: Vec<u32> = self.open().flatten().collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// The open edges put together to loops, a sheet's outer border among them.
    pub fn borders(&self) -> Borders {
        Borders::new(&self.boundary_nodes(), &self.open().collect::<Vec<_>>())
    }

    /// Number of boundary loops, a sheet's outer border among them.
    pub fn holes(&self) -> usize {
        self.borders().loops.len()
    }

    /// Edges whose two triangles run along it the same way, in the order of the edges.
    pub fn flipped_pairs(&self, triangles: &[[u32; 3]]) -> impl Iterator<Item = [u32; 2]> {
        let runs = |[a, b]: [u32; 2], t: u32| {
            let corners = triangles[t as usize];
            (0..3).any(|i| corners[i] == a && corners[(i + 1) % 3] == b)
        };
        let inner = self.pairs.iter().zip(&self.triangles).zip(&self.uses).filter(|(_, uses)| **uses == 2);
        inner
            .map(|(edge, _)| edge)
            .filter(move |(pair, [t, u])| runs(**pair, *t) == runs(**pair, *u))
            .map(|(p, _)| *p)
    }

    /// Edges with this many triangles, in order.
    pub fn with_uses(&self, which: impl Fn(u32) -> bool) -> impl Iterator<Item = [u32; 2]> {
        self.pairs.iter().zip(&self.uses).filter(move |(_, uses)| which(**uses)).map(|(pair, _)| *pair)
    }

    /// For each edge between two triangles their other corners, in the order of the edges; along links: the nodes
    /// two apart. Where two triangles lie back to back there is no such pair.
    pub fn bend_pairs(&self, triangles: &[[u32; 3]], links: &[[u32; 2]]) -> Vec<[u32; 2]> {
        let across = self.hinges(triangles).into_iter().map(|[_, _, left, right]| [left, right]);
        let along = links.windows(2).filter(|w| w[0][1] == w[1][0]).map(|w| [w[0][0], w[1][1]]);
        across.chain(along).filter(|[a, b]| a != b).map(|[a, b]| [a.min(b), a.max(b)]).collect()
    }

    /// `[a, b, left, right]` for each edge between two triangles: its ends, the other corner of the triangle that
    /// runs a→b, and that of the one that runs b→a.
    pub fn hinges(&self, triangles: &[[u32; 3]]) -> Vec<[u32; 4]> {
        let inner = self.pairs.iter().zip(&self.triangles).zip(&self.uses).filter(|(_, uses)| **uses == 2);
        inner
            .map(|((&[a, b], sides), _)| {
                let [left, right] =
                    sides.map(|t| triangles[t as usize].iter().fold(a ^ b, |x, corner| x ^ corner));
                [a, b, left, right]
            })
            .collect()
    }

    fn open(&self) -> impl Iterator<Item = [u32; 2]> {
        self.with_uses(|uses| uses == 1)
    }
}

/// The run number `half` (three of each triangle, then the links), seen from its smaller end `a`.
fn run(triangles: &[[u32; 3]], links: &[[u32; 2]], a: u32, half: usize) -> Run {
    let Some(corners) = triangles.get(half / 3) else {
        let [x, y] = links[half - 3 * triangles.len()];
        return (x ^ y ^ a, NONE, false);
    };
    let [from, to] = [corners[half % 3], corners[(half + 1) % 3]];
    (from ^ to ^ a, (half / 3) as u32, from != a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::shapes::grid_surface;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

    #[test]
    fn a_tetrahedron_is_closed_and_its_hinges_see_left_and_right() {
        let edges = Edges::new(4, &TETRAHEDRON, &[]);
        assert_eq!(edges.pairs, [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]);
        assert!(edges.is_closed());
        assert_eq!((edges.boundary_edges(), edges.holes()), (0, 0));
        assert_eq!(edges.hinges(&TETRAHEDRON)[0], [0, 1, 3, 2], "0→1 runs in triangle 0 1 3");
        assert_eq!(edges.bend_pairs(&TETRAHEDRON, &[])[0], [2, 3]);
    }

    #[test]
    fn a_missing_triangle_leaves_one_hole_of_three_edges() {
        let edges = Edges::new(4, &TETRAHEDRON[..3], &[]);
        assert_eq!((edges.boundary_edges(), edges.holes(), edges.is_closed()), (3, 1, false));
        assert_eq!(edges.boundary_nodes(), [1, 2, 3]);
        assert_eq!(edges.hinges(&TETRAHEDRON[..3]).len(), 3);
    }

    #[test]
    fn a_turned_triangle_and_a_third_sheet_are_seen() {
        let mut turned = TETRAHEDRON;
        turned[3] = [1, 3, 2];
        let edges = Edges::new(4, &turned, &[]);
        assert_eq!((edges.flipped, edges.boundary_edges(), edges.is_closed()), (3, 0, false));
        assert_eq!(edges.flipped_pairs(&turned).collect::<Vec<_>>(), [[1, 2], [1, 3], [2, 3]]);
        let fan = [[0, 1, 2], [0, 1, 3], [1, 0, 4]];
        let edges = Edges::new(5, &fan, &[]);
        assert_eq!((edges.non_manifold_edges(), edges.uses[0], edges.flipped), (1, 3, 0));
        assert!(edges.bend_pairs(&fan, &[]).is_empty());
    }

    #[test]
    fn a_sheet_with_a_window_has_two_boundary_loops() {
        let surface = grid_surface(4, 4, [1.0, 1.0]);
        let window = [5, 6, 9, 10];
        let frame: Vec<[u32; 3]> =
            surface.triangles.into_iter().filter(|t| !t.iter().all(|i| window.contains(i))).collect();
        let edges = Edges::new(16, &frame, &[]);
        assert_eq!((edges.holes(), edges.boundary_edges()), (2, 16));
    }

    #[test]
    fn a_chain_bends_between_nodes_two_apart() {
        let links = [[0, 1], [1, 2], [2, 3]];
        let edges = Edges::new(4, &[], &links);
        assert_eq!(edges.pairs, links);
        assert_eq!(edges.bend_pairs(&[], &links), [[0, 2], [1, 3]]);
        assert_eq!((edges.boundary_edges(), edges.is_closed()), (0, false));
    }
}
