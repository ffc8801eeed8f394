//! Struts inside a closed surface: straight lines between its nodes that do not leave it.

use crate::topology::measure::{cross, dot, norm, sub};
use crate::topology::random::SplitMix64;
use crate::topology::segment::Obstacles;
use crate::topology::{Csr, Edges, Surface};
use std::collections::BTreeSet;

/// Least sine of the angle between a strut and the surface it starts from; lines along a face are not inside.
const INWARD: f64 = 1e-3;
/// Up to this number of nodes every pair is tried before too few struts are found.
const FEW_NODES: usize = 2048;
/// Pairs that are tried to tell how many struts there may be.
const SAMPLE: u32 = 4096;
/// Tries in a row without a strut after which the search by chance ends.
const PATIENCE: u32 = 100_000;

/// `count` pairs of nodes `[a, b]`, a < b, sorted: all different, no edges of the surface, the line between them
/// inside the closed surface, away from it at both ends, and touching no triangle without one of its ends. Chosen
/// by `seed`; the same on every platform. If there are fewer, the error says how many were found.
///
/// ```
/// use taffeta::scene::{Cube, Mesh};
/// use taffeta::topology::{Edges, shapes, struts::struts};
///
/// // A box of eight nodes has four lines through its inside.
/// let cube = shapes::surface(&Mesh::Cube(Cube { size: 0.2, divisions: 1 }))?;
/// let edges = Edges::new(8, &cube.triangles, &[]);
/// let diagonals = struts(&cube.nodes, &cube.triangles, &edges, 4, 1)?;
/// assert_eq!(diagonals, [[0, 7], [1, 6], [2, 5], [3, 4]]);
/// let error = struts(&cube.nodes, &cube.triangles, &edges, 5, 1).unwrap_err();
/// assert_eq!(error, "5 struts are asked for, 4 were found inside; that many would do");
/// # Ok::<(), String>(())
/// ```
pub fn struts(
    nodes: &[[f64; 3]],
    triangles: &[[u32; 3]],
    edges: &Edges,
    count: u32,
    seed: u64,
) -> Result<Vec<[u32; 2]>, String> {
    if count == 0 {
        return Ok(Vec::new());
    }
    if !edges.is_closed() {
        let [open, crowded] = [edges.boundary_edges(), edges.non_manifold_edges()];
        return Err(format!(
            "struts need a closed surface; this one has {open} open edges, {crowded} edges of more than two \
             triangles and {} where it changes sides",
            edges.flipped
        ));
    }
    let inside = Inside {
        nodes,
        triangles,
        edges,
        corners: Csr::corners(nodes.len(), triangles),
        obstacles: Obstacles::new(nodes, triangles),
    };
    let most = if nodes.len() > FEW_NODES { inside.about() } else { u64::MAX };
    if u64::from(count) > most {
        return Err(format!(
            "{count} struts are asked for, and no more than about {most} fit inside; fewer would do"
        ));
    }
    let mut random = SplitMix64::new(seed);
    let mut found = BTreeSet::new();
    let mut misses = 0;
    while found.len() < count as usize && misses < PATIENCE {
        let pair = random.pair(nodes.len());
        let fresh = !found.contains(&pair) && inside.has(pair);
        misses = if fresh { 0 } else { misses + 1 };
        if fresh {
            found.insert(pair);
        }
    }
    if found.len() < count as usize && nodes.len() <= FEW_NODES {
        inside.fill_up(&mut found, count as usize, &mut random);
    }
    if found.len() < count as usize {
        return Err(format!(
            "{count} struts are asked for, {} were found inside; that many would do",
            found.len()
        ));
    }
    Ok(found.into_iter().collect())
}

/// Struts from a file, as pairs of the user's vertices, to pairs of nodes `[a, b]`, a < b, in the order given. The
/// error is (index of the pair, message).
///
/// ```
/// use taffeta::scene::{Cube, Mesh};
/// use taffeta::topology::{shapes, struts::given_struts};
///
/// let cube = shapes::surface(&Mesh::Cube(Cube { size: 0.2, divisions: 1 }))?;
/// assert_eq!(given_struts(&[[7, 0], [1, 6]], &cube), Ok(vec![[0, 7], [1, 6]]));
/// let (index, message) = given_struts(&[[7, 0], [1, 8]], &cube).unwrap_err();
/// assert_eq!((index, message.as_str()), (1, "strut 1 has vertex 8, 0 to 7 would do"));
/// # Ok::<(), String>(())
/// ```
pub fn given_struts(pairs: &[[u32; 2]], surface: &Surface) -> Result<Vec<[u32; 2]>, (usize, String)> {
    let vertices = surface.vertices.len();
    let mut struts = Vec::with_capacity(pairs.len());
    let mut seen = BTreeSet::new();
    for (i, pair) in pairs.iter().enumerate() {
        if let Some(vertex) = pair.iter().find(|v| **v as usize >= vertices) {
            let last = vertices.saturating_sub(1);
            return Err((i, format!("strut {i} has vertex {vertex}, 0 to {last} would do")));
        }
        let node = |v: u32| surface.node_of_vertex.as_ref().map_or(v, |list| list[v as usize]);
        let [a, b] = pair.map(node);
        let [a, b] = [a.min(b), a.max(b)];
        if b == u32::MAX {
            let message =
                format!("strut {i} has a vertex that no face uses: {pair:?}; vertices of faces would do");
            return Err((i, message));
        }
        if a == b || surface.nodes[a as usize] == surface.nodes[b as usize] {
            return Err((i, format!("strut {i} has no length: {pair:?}; two vertices apart would do")));
        }
        if !seen.insert([a, b]) {
            return Err((i, format!("strut {i} is given twice: {pair:?}; once would do")));
        }
        struts.push([a, b]);
    }
    Ok(struts)
}

/// A closed surface, ready to be asked which lines are inside.
struct Inside<'a> {
    nodes: &'a [[f64; 3]],
    triangles: &'a [[u32; 3]],
    edges: &'a Edges,
    corners: Csr,
    obstacles: Obstacles<'a>,
}

impl Inside<'_> {
    /// Whether a pair, a < b, is a strut.
    fn has(&self, pair: [u32; 2]) -> bool {
        let [a, b] = pair;
        a != b
            && self.edges.pairs.binary_search(&pair).is_err()
            && self.starts_inward(a, b)
            && self.starts_inward(b, a)
            && !self.obstacles.block(pair)
    }

    /// Whether the line from `apex` to `to` leaves into the inside of the cone that the triangles at `apex` make.
    ///
    /// Which side of the cone the unit vector d lies on is told by the normal where the cone is nearest to d: of a
    /// triangle, the sum of two at an edge, the angle-weighted sum at the apex (Bærentzen and Aanæs, "Signed
    /// distance computation using the angle weighted pseudonormal", IEEE TVCG 11 (2005)).
    fn starts_inward(&self, apex: u32, to: u32) -> bool {
        let from_apex = |i: u32| sub(self.nodes[i as usize], self.nodes[apex as usize]);
        let Some(d) = unit(from_apex(to)) else { return false };
        let mut nearest = Nearest { distance: 1.0, normal: [0.0; 3] };
        for &corner in self.corners.row(apex as usize) {
            let triangle = self.triangles[corner as usize / 3];
            let side = |k: u32| unit(from_apex(triangle[(corner + k) as usize % 3]));
            let (Some(e), Some(f)) = (side(1), side(2)) else { return false };
            let Some(n) = unit(cross(e, f)) else { return false };
            nearest.add_sector(d, e, f, n);
        }
        nearest.distance > INWARD && dot(d, nearest.normal) < 0.0
    }

    /// Above the number of struts that there are, with all but certainty: from the share of a sample (five standard
    /// deviations more), and at most all pairs but the edges.
    fn about(&self) -> u64 {
        let nodes = self.nodes.len() as u64;
        let pairs = (nodes * nodes.saturating_sub(1) / 2).saturating_sub(self.edges.pairs.len() as u64);
        let mut random = SplitMix64::new(0);
        let hits = (0..SAMPLE).filter(|_| self.has(random.pair(self.nodes.len()))).count() as f64;
        let share = (hits + 5.0 * hits.sqrt() + 25.0) / f64::from(SAMPLE);
        if share < 1.0 { (share * pairs as f64) as u64 } else { pairs }
    }

    /// Adds struts from all that there are, in an order by chance, up to `count`.
    fn fill_up(&self, found: &mut BTreeSet<[u32; 2]>, count: usize, random: &mut SplitMix64) {
        let all = (0..self.nodes.len() as u32).flat_map(|b| (0..b).map(move |a| [a, b]));
        let mut rest: Vec<_> = all.filter(|pair| !found.contains(pair) && self.has(*pair)).collect();
        while found.len() < count && !rest.is_empty() {
            found.insert(rest.swap_remove(random.below(rest.len())));
        }
    }
}

/// What is nearest to a unit vector on a cone: its distance, and the sum of normals there.
struct Nearest {
    distance: f64,
    normal: [f64; 3],
}

impl Nearest {
    /// Compares with the sector between the unit vectors `e` and `f`, whose normal is `n`.
    fn add_sector(&mut self, d: [f64; 3], e: [f64; 3], f: [f64; 3], n: [f64; 3]) {
        if dot(cross(e, d), n) >= 0.0 && dot(cross(d, f), n) >= 0.0 {
            self.add(dot(d, n).abs(), n);
            return;
        }
        let along = dot(d, e).max(dot(d, f));
        if along > 0.0 {
            let ray = if dot(d, e) == along { e } else { f };
            self.add(norm(cross(d, ray)), n);
        } else {
            let angle = libm::acos(dot(e, f).clamp(-1.0, 1.0));
            self.add(1.0, n.map(|x| x * angle));
        }
    }

    fn add(&mut self, distance: f64, n: [f64; 3]) {
        if distance < self.distance {
            *self = Self { distance, normal: [0.0; 3] };
        }
        if distance == self.distance {
            self.normal = [0, 1, 2].map(|i| self.normal[i] + n[i]);
        }
    }
}

fn unit(p: [f64; 3]) -> Option<[f64; 3]> {
    let length = norm(p);
    (length > 0.0).then(|| p.map(|x| x / length))
}

#[cfg(test)]
mod tests;
