//! Dropping what cannot be simulated.

use super::triangles::Triangles;
use taffeta::topology::Csr;

/// Area below which a triangle counts as flat, relative to its longest edge squared: rounding of coordinates, not shape.
const FLAT: f64 = 1e-12;

/// `1 triangle`, `2 triangles`.
pub(super) fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Drops triangles without area; `collapsed` faces had too few corners left to become triangles.
pub(super) fn drop_flat(
    triangles: &mut Triangles,
    nodes: &[[f64; 3]],
    collapsed: usize,
    repairs: &mut Vec<String>,
) {
    let dropped = triangles.retain(|_, triangle| !is_flat(triangle.map(|n| nodes[n as usize]))) + collapsed;
    if dropped > 0 {
        repairs.push(format!("dropped {} without area", counted(dropped, "triangle")));
    }
}

/// Whether a triangle has no area worth the name, whatever its size.
pub(super) fn is_flat([a, b, c]: [[f64; 3]; 3]) -> bool {
    let sub = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|i| p[i] - q[i]);
    let square = |v: [f64; 3]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    let (u, v) = (sub(b, a), sub(c, a));
    let size = u.iter().chain(&v).fold(0.0_f64, |size, x| size.max(x.abs()));
    if size == 0.0 {
        return true;
    }
    // To a size near one, so that the squares of small numbers do not vanish.
    let (u, v) = (u.map(|x| x / size), v.map(|x| x / size));
    let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let longest = square(u).max(square(v)).max(square(sub(v, u)));
    square(cross).sqrt() <= FLAT * longest
}

/// Keeps the first of triangles that have the same three nodes, and two back to back where sewn panels end in a corner:
/// all three corners of either lie on the seam then.
pub(super) fn drop_duplicates(triangles: &mut Triangles, nodes: usize, repairs: &mut Vec<String>) {
    let mut again = vec![false; triangles.nodes.len()];
    let mut pairs = Vec::new();
    for same in alike(&triangles.nodes, nodes) {
        same[1..].iter().for_each(|&index| again[index as usize] = true);
        if let [a, b] = same[..]
            && is_turned(triangles.nodes[a as usize], triangles.nodes[b as usize])
        {
            pairs.push([a, b]);
        }
    }
    for [_, kept] in sewn_corners(&triangles.nodes, pairs) {
        again[kept as usize] = false;
    }
    let dropped = triangles.retain(|index, _| !again[index]);
    if dropped > 0 {
        repairs
            .push(format!("dropped {} with the same corners as another one", counted(dropped, "triangle")));
    }
}

/// Triangles that have their three nodes in common with others, by index, ascending.
fn alike(triangles: &[[u32; 3]], nodes: usize) -> Vec<Vec<u32>> {
    let smallest = triangles.iter().map(|&[a, b, c]| a.min(b).min(c));
    let by_smallest = Csr::new(nodes, smallest.zip(0..));
    let (mut groups, mut keys) = (Vec::new(), Vec::new());
    for row in (0..nodes).map(|node| by_smallest.row(node)).filter(|row| row.len() > 1) {
        keys.clear();
        keys.extend(row.iter().map(|&index| {
            let mut corners = triangles[index as usize];
            corners.sort_unstable();
            (corners, index)
        }));
        keys.sort_unstable();
        let same = keys.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() > 1);
        groups.extend(same.map(|same| same.iter().map(|key| key.1).collect()));
    }
    groups
}

/// Whether two triangles of the same nodes are wound against each other.
fn is_turned([a, b, c]: [u32; 3], other: [u32; 3]) -> bool {
    ![[a, b, c], [b, c, a], [c, a, b]].contains(&other)
}

/// Those of the `pairs` of triangles back to back that end a seam: without one of them an edge would be open, and beyond
/// another edge the panels part. A face that is given with both its sides has neighbours that are as well.
fn sewn_corners(triangles: &[[u32; 3]], pairs: Vec<[u32; 2]>) -> Vec<[u32; 2]> {
    let sides = |index: u32| {
        let [a, b, c] = triangles[index as usize];
        [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)])
    };
    let mut paired: Vec<[u32; 2]> = pairs.iter().flatten().flat_map(|&index| sides(index)).collect();
    paired.sort_unstable();
    let mut edges = paired.clone();
    edges.dedup();
    // How many triangles in all each edge of a pair has.
    let mut uses = vec![0_usize; edges.len()];
    if !pairs.is_empty() {
        for side in (0..triangles.len() as u32).flat_map(sides) {
            edges.binary_search(&side).into_iter().for_each(|edge| uses[edge] += 1);
        }
    }
    let of_pairs =
        |edge: &[u32; 2]| paired.partition_point(|e| e <= edge) - paired.partition_point(|e| e < edge);
    let count = |edge: &[u32; 2]| edges.binary_search(edge).map_or(0, |at| uses[at]);
    let ends = |&[first, _]: &[u32; 2]| {
        let sides = sides(first);
        sides.iter().any(|edge| count(edge) == 2) && sides.iter().any(|edge| count(edge) > of_pairs(edge))
    };
    pairs.into_iter().filter(ends).collect()
}

/// What is said of vertices that no face uses, but not of a hull, where they count.
pub(crate) const UNUSED: &str = ": kept in outputs, not simulated";

/// Drops nodes that no triangle uses. Returns the nodes, and the node of each vertex: `u32::MAX` for a dropped one,
/// `None` where the vertices are the nodes.
pub(super) fn compact(
    mut nodes: Vec<[f64; 3]>,
    mut node_of_vertex: Vec<u32>,
    triangles: &mut [[u32; 3]],
    repairs: &mut Vec<String>,
) -> (Vec<[f64; 3]>, Option<Vec<u32>>) {
    let mut new = vec![u32::MAX; nodes.len()];
    triangles.iter().flatten().for_each(|&node| new[node as usize] = 0);
    let mut kept = 0;
    for node in 0..nodes.len() {
        if new[node] == 0 {
            nodes[kept] = nodes[node];
            new[node] = kept as u32;
            kept += 1;
        }
    }
    nodes.truncate(kept);
    triangles.iter_mut().flatten().for_each(|node| *node = new[*node as usize]);
    node_of_vertex.iter_mut().for_each(|node| *node = new[*node as usize]);
    let unused = node_of_vertex.iter().filter(|&&node| node == u32::MAX).count();
    if unused > 0 {
        let vertices = if unused == 1 { "1 vertex".to_owned() } else { format!("{unused} vertices") };
        repairs.push(format!("{vertices} of no triangle{UNUSED}"));
    }
    let same =
        kept == node_of_vertex.len() && node_of_vertex.iter().zip(0..).all(|(&node, vertex)| node == vertex);
    (nodes, (!same).then_some(node_of_vertex))
}
