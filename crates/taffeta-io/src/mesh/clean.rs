//! Welding, and dropping what cannot be simulated. All by sorting: the same answer every time, and no input is slow.

/// Area below which a triangle counts as flat, relative to its longest edge squared: rounding of coordinates, not shape.
const FLAT: f64 = 1e-12;

/// `1 triangle`, `2 triangles`.
pub(super) fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Gives vertices at exactly one place one node: the first of them, in the vertices' order.
pub(super) fn weld(vertices: &[[f64; 3]], repairs: &mut Vec<String>) -> (Vec<[f64; 3]>, Vec<u32>) {
    // Adding zero makes −0 the same place as 0.
    let bits = |v: &[f64; 3]| v.map(|x| (x + 0.0).to_bits());
    let mut order: Vec<([u64; 3], u32)> = vertices.iter().zip(0..).map(|(v, i)| (bits(v), i)).collect();
    order.sort_unstable();
    let mut first: Vec<u32> = (0..vertices.len() as u32).collect();
    for same in order.chunk_by(|a, b| a.0 == b.0) {
        same.iter().for_each(|&(_, vertex)| first[vertex as usize] = same[0].1);
    }
    let mut nodes = Vec::new();
    let mut node_of_vertex = vec![0; vertices.len()];
    for (vertex, &first) in first.iter().enumerate() {
        node_of_vertex[vertex] = if first as usize == vertex {
            nodes.push(vertices[vertex]);
            nodes.len() as u32 - 1
        } else {
            node_of_vertex[first as usize]
        };
    }
    let welded = vertices.len() - nodes.len();
    if welded > 0 {
        let places = nodes.len();
        repairs
            .push(format!("welded {} vertices into {places}: they lay at the same places", vertices.len()));
    }
    (nodes, node_of_vertex)
}

/// Drops triangles without area; `collapsed` faces had too few corners left to become triangles.
pub(super) fn drop_flat(
    triangles: &mut Vec<[u32; 3]>,
    nodes: &[[f64; 3]],
    collapsed: usize,
    repairs: &mut Vec<String>,
) {
    let before = triangles.len();
    triangles.retain(|triangle| !is_flat(triangle.map(|node| nodes[node as usize])));
    let dropped = before - triangles.len() + collapsed;
    if dropped > 0 {
        repairs.push(format!("dropped {} without area", counted(dropped, "triangle")));
    }
}

fn is_flat([a, b, c]: [[f64; 3]; 3]) -> bool {
    let sub = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|i| p[i] - q[i]);
    let square = |v: [f64; 3]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    let (u, v) = (sub(b, a), sub(c, a));
    let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let longest = square(u).max(square(v)).max(square(sub(c, b)));
    square(cross).sqrt() <= FLAT * longest
}

/// Keeps the first of triangles that have the same three nodes, whatever their winding.
pub(super) fn drop_duplicates(triangles: &mut Vec<[u32; 3]>, repairs: &mut Vec<String>) {
    let key = |(triangle, index): (&[u32; 3], u32)| {
        let mut sorted = *triangle;
        sorted.sort_unstable();
        let [a, b, c] = sorted.map(u128::from);
        a << 96 | b << 64 | c << 32 | u128::from(index)
    };
    let mut keys: Vec<u128> = triangles.iter().zip(0..).map(key).collect();
    keys.sort_unstable();
    let mut again = vec![false; triangles.len()];
    for pair in keys.windows(2).filter(|pair| pair[0] >> 32 == pair[1] >> 32) {
        again[pair[1] as u32 as usize] = true;
    }
    let before = triangles.len();
    let mut again = again.into_iter();
    triangles.retain(|_| !again.next().unwrap_or(false));
    let dropped = before - triangles.len();
    if dropped > 0 {
        repairs
            .push(format!("dropped {} with the same corners as another one", counted(dropped, "triangle")));
    }
}

/// Drops nodes that no triangle uses. Returns the nodes, and the node of each vertex: `u32::MAX` for a dropped one,
/// `None` where every vertex is its own node.
pub(super) fn compact(
    nodes: Vec<[f64; 3]>,
    mut node_of_vertex: Vec<u32>,
    triangles: &mut [[u32; 3]],
    repairs: &mut Vec<String>,
) -> (Vec<[f64; 3]>, Option<Vec<u32>>) {
    let mut new = vec![u32::MAX; nodes.len()];
    triangles.iter().flatten().for_each(|&node| new[node as usize] = 0);
    let mut kept = Vec::with_capacity(nodes.len());
    for (new, node) in new.iter_mut().zip(nodes).filter(|(new, _)| **new == 0) {
        *new = kept.len() as u32;
        kept.push(node);
    }
    triangles.iter_mut().flatten().for_each(|node| *node = new[*node as usize]);
    node_of_vertex.iter_mut().for_each(|node| *node = new[*node as usize]);
    let unused = node_of_vertex.iter().filter(|&&node| node == u32::MAX).count();
    if unused > 0 {
        let vertices = if unused == 1 { "1 vertex".to_owned() } else { format!("{unused} vertices") };
        repairs.push(format!("{vertices} of no triangle: kept in outputs, not simulated"));
    }
    let same = node_of_vertex.iter().zip(0..).all(|(&node, vertex)| node == vertex);
    (kept, (!same).then_some(node_of_vertex))
}
