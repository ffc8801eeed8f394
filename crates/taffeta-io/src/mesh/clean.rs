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

/// Keeps the first of triangles that have the same three nodes, whatever their winding.
pub(super) fn drop_duplicates(triangles: &mut Triangles, nodes: usize, repairs: &mut Vec<String>) {
    let smallest = triangles.nodes.iter().map(|&[a, b, c]| a.min(b).min(c));
    let by_smallest = Csr::new(nodes, smallest.zip(0..));
    let mut again = vec![false; triangles.nodes.len()];
    let mut keys = Vec::new();
    for row in (0..nodes).map(|node| by_smallest.row(node)).filter(|row| row.len() > 1) {
        keys.clear();
        keys.extend(row.iter().map(|&index| {
            let mut corners = triangles.nodes[index as usize];
            corners.sort_unstable();
            (corners, index)
        }));
        keys.sort_unstable();
        for pair in keys.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            again[pair[1].1 as usize] = true;
        }
    }
    let dropped = triangles.retain(|index, _| !again[index]);
    if dropped > 0 {
        repairs
            .push(format!("dropped {} with the same corners as another one", counted(dropped, "triangle")));
    }
}

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
        repairs.push(format!("{vertices} of no triangle: kept in outputs, not simulated"));
    }
    let same =
        kept == node_of_vertex.len() && node_of_vertex.iter().zip(0..).all(|(&node, vertex)| node == vertex);
    (nodes, (!same).then_some(node_of_vertex))
}
