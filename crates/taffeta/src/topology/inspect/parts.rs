//! What hangs together. The Euler characteristic of a part is counted on the surface cut open at nodes where it only
//! touches itself, so that it is a manifold with b borders: χ = 2 − 2g − b.

use crate::topology::Edges;
use crate::topology::inspect::sets::Sets;
use crate::topology::inspect::sides::{Sides, next};
use crate::topology::measure::{bounds, cross, dot, sub};

/// Triangles that hang together by edges.
///
/// ```
/// use taffeta::scene::{Cube, Mesh};
/// use taffeta::topology::{Inspection, shapes};
///
/// // A cube, and beside it a loose triangle.
/// let mut surface = shapes::surface(&Mesh::Cube(Cube { size: 1.0, divisions: 1 }))?;
/// surface.nodes.extend([[2.0, 0.0, 0.0], [3.0, 0.0, 0.0], [2.0, 1.0, 0.0]]);
/// surface.triangles.push([8, 9, 10]);
/// let [cube, loose] = Inspection::new(&surface).parts[..] else { panic!("two parts") };
/// assert!(cube.closed && (cube.volume.unwrap_or(0.0) - 1.0).abs() < 1e-12);
/// assert_eq!((loose.triangles, loose.first, loose.volume), (1, 12, None));
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Number of triangles.
    pub triangles: usize,
    /// The first of them.
    pub first: usize,
    /// Whether each edge has two triangles that agree on their sides.
    pub closed: bool,
    /// Whether its triangles can be turned so that neighbours agree on their sides.
    pub orientable: bool,
    /// Volume inside [m³], of a closed part; negative for a cavity, whose triangles look into it.
    pub volume: Option<f64>,
    /// Number of handles; `None` with edges of more than two triangles, or if it is not orientable.
    pub genus: Option<u64>,
}

/// The parts of a surface.
pub(crate) struct Found {
    pub parts: Vec<Part>,
    /// Number of parts, if those that touch at a node count as one.
    pub joined: usize,
    /// Nodes with more than one fan of triangles.
    pub bow_ties: Vec<u32>,
    /// Number of nodes with triangles.
    pub nodes: usize,
}

/// What is counted of a part.
#[derive(Clone, Default)]
struct Tally {
    triangles: usize,
    fans: i64,
    edges: i64,
    open: usize,
    crowded: usize,
    flipped: usize,
    borders: i64,
    twisted: bool,
    sixfold: f64,
}

/// Whether the triangles can be turned so that neighbours agree on their sides.
pub fn is_orientable(triangles: &[[u32; 3]], edges: &Edges, sides: &Sides) -> bool {
    !twists(triangles, edges, sides).contains(&true)
}

/// For each triangle whether a contradiction was found at one of its edges.
fn twists(triangles: &[[u32; 3]], edges: &Edges, sides: &Sides) -> Vec<bool> {
    let mut sets = Sets::new(triangles.len());
    let mut twisted = vec![false; triangles.len()];
    for (a, b, uses) in sides.neighbours(edges) {
        if uses == 2 && !sets.join(a / 3, b / 3, start(triangles, a) == start(triangles, b)).agrees {
            twisted[b as usize / 3] = true;
        }
    }
    twisted
}

pub(crate) fn find(nodes: &[[f64; 3]], triangles: &[[u32; 3]], edges: &Edges, sides: &Sides) -> Found {
    let mut sets = Sets::new(triangles.len());
    for (a, b, _) in sides.neighbours(edges) {
        sets.join(a / 3, b / 3, false);
    }
    let (part_of, count) = sets.numbers();
    let mut tallies = vec![Tally::default(); count];
    let part = |side: u32| part_of[side as usize / 3] as usize;
    count_edges(triangles, edges, sides, part, &mut tallies);
    for (t, twisted) in twists(triangles, edges, sides).into_iter().enumerate() {
        tallies[part_of[t] as usize].twisted |= twisted;
    }
    let mut fans = Fans::new(triangles, edges, sides);
    fans.corners.iter().for_each(|corner| tallies[part(*corner)].fans += 1);
    let (bow_ties, with_triangles) = fans.bow_ties(nodes.len(), triangles);
    fans.count_borders(edges, sides, |side, borders| tallies[part(side)].borders += borders);
    add_volumes(nodes, triangles, &part_of, &mut tallies);
    Found {
        joined: joined(triangles, &bow_ties, &part_of, count),
        parts: firsts(&part_of, count).into_iter().zip(tallies).map(|(first, t)| t.part(first)).collect(),
        bow_ties,
        nodes: with_triangles,
    }
}

fn count_edges(
    triangles: &[[u32; 3]],
    edges: &Edges,
    sides: &Sides,
    part: impl Fn(u32) -> usize,
    tallies: &mut [Tally],
) {
    (0..triangles.len()).for_each(|t| tallies[part(3 * t as u32)].triangles += 1);
    for (&side, &uses) in sides.first.iter().zip(&edges.uses).filter(|(_, uses)| **uses > 0) {
        let tally = &mut tallies[part(side)];
        tally.edges += 1;
        tally.open += usize::from(uses == 1);
        tally.crowded += usize::from(uses > 2);
    }
    for (a, b, uses) in sides.neighbours(edges) {
        tallies[part(a)].flipped += usize::from(uses == 2 && start(triangles, a) == start(triangles, b));
    }
}

/// The node from which a side runs.
fn start(triangles: &[[u32; 3]], side: u32) -> u32 {
    triangles[side as usize / 3][side as usize % 3]
}

/// Adds Σ a·(b×c) about the middle of all, so that no digits are lost far from the origin.
fn add_volumes(nodes: &[[f64; 3]], triangles: &[[u32; 3]], part_of: &[u32], tallies: &mut [Tally]) {
    let [lo, hi] = bounds(nodes);
    let middle = [0, 1, 2].map(|i| 0.5 * (lo[i] + hi[i]));
    for (triangle, part) in triangles.iter().zip(part_of) {
        let [a, b, c] = triangle.map(|node| sub(nodes[node as usize], middle));
        tallies[*part as usize].sixfold += dot(a, cross(b, c));
    }
}

/// First triangle of each part.
fn firsts(part_of: &[u32], count: usize) -> Vec<usize> {
    let mut firsts = vec![0; count];
    part_of.iter().enumerate().rev().for_each(|(t, part)| firsts[*part as usize] = t);
    firsts
}

/// Number of parts after those that touch at a node are joined.
fn joined(triangles: &[[u32; 3]], bow_ties: &[u32], part_of: &[u32], count: usize) -> usize {
    if bow_ties.is_empty() {
        return count;
    }
    let mut sets = Sets::new(count);
    let mut part_at = vec![u32::MAX; bow_ties.len()];
    let mut joined = count;
    for (triangle, part) in triangles.iter().zip(part_of) {
        for tie in triangle.iter().filter_map(|node| bow_ties.binary_search(node).ok()) {
            let other = std::mem::replace(&mut part_at[tie], *part);
            joined -= usize::from(other != u32::MAX && sets.join(other, *part, false).joined);
        }
    }
    joined
}

impl Tally {
    fn part(self, first: usize) -> Part {
        let closed = self.open == 0 && self.crowded == 0 && self.flipped == 0;
        let handles = 2 - self.borders - (self.fans - self.edges + self.triangles as i64);
        let surface = self.crowded == 0 && !self.twisted;
        Part {
            triangles: self.triangles,
            first,
            closed,
            orientable: !self.twisted,
            volume: closed.then_some(self.sixfold / 6.0),
            genus: surface.then_some((handles / 2).max(0) as u64),
        }
    }
}

/// Fans: triangles at a node that hang together by edges there.
struct Fans {
    /// Sets of corners, 3·triangle + i.
    sets: Sets,
    /// One corner of each fan.
    corners: Vec<u32>,
}

impl Fans {
    fn new(triangles: &[[u32; 3]], edges: &Edges, sides: &Sides) -> Self {
        let mut sets = Sets::new(3 * triangles.len());
        for (a, b, _) in sides.neighbours(edges) {
            let same = start(triangles, a) == start(triangles, b);
            let [from, to] = if same { [b, next(b)] } else { [next(b), b] };
            sets.join(a, from, false);
            sets.join(next(a), to, false);
        }
        let corners = (0..sets.parent.len() as u32).filter(|c| sets.parent[*c as usize] == *c).collect();
        Self { sets, corners }
    }

    /// Nodes with more than one fan, and the number of nodes with any.
    fn bow_ties(&self, nodes: usize, triangles: &[[u32; 3]]) -> (Vec<u32>, usize) {
        let mut fans = vec![0_u32; nodes];
        self.corners.iter().for_each(|corner| fans[start(triangles, *corner) as usize] += 1);
        let ties = (0..nodes as u32).filter(|node| fans[*node as usize] > 1).collect();
        (ties, fans.iter().filter(|fans| **fans > 0).count())
    }

    /// Joins fans along open edges: what hangs together then is a border. Adds one for each fan on an open edge,
    /// and takes one away for each two that are joined.
    fn count_borders(&mut self, edges: &Edges, sides: &Sides, mut add: impl FnMut(u32, i64)) {
        let open =
            || sides.first.iter().zip(&edges.uses).filter(|(_, uses)| **uses == 1).map(|(side, _)| *side);
        let mut seen = vec![false; self.sets.parent.len()];
        for corner in open().flat_map(|side| [side, next(side)]) {
            let root = self.sets.root(corner).0;
            add(corner, i64::from(!std::mem::replace(&mut seen[root as usize], true)));
        }
        for side in open() {
            add(side, -i64::from(self.sets.join(side, next(side), false).joined));
        }
    }
}
