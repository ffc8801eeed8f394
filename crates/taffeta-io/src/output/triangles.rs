//! A surface's own faces as triangles, by corner.

use taffeta::topology::Surface;

/// A surface's own faces as triangles of its vertices, in the faces' order.
///
/// ```
/// use taffeta_io::output::triangles_of;
/// use taffeta_io::{MeshFormat, MeshOptions, parse_mesh};
///
/// let square = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
/// let surface = parse_mesh(square, MeshFormat::Obj, &MeshOptions::default())?;
/// assert_eq!(triangles_of(&surface), [[0, 1, 2], [0, 2, 3]]);
/// # Ok::<(), taffeta_io::MeshError>(())
/// ```
pub fn triangles_of(surface: &Surface) -> Vec<[u32; 3]> {
    let mut all = Vec::new();
    each_triangle(surface, |corners| all.push(corners.map(|corner| surface.polygons.corners[corner])));
    all
}

/// Calls `each` with the corners of every triangle, as indices into the faces' list of corners. Faces are cut as in
/// the simulation, and triangles look the way they do there, to which normals belong; what the simulation left out
/// (faces without area) is cut like a fan.
///
/// An ear of a cut polygon is three neighbouring corners that are a triangle of the cut, and what is left without its
/// tip is a cut polygon again (Meisters, Polygons have ears, 1975): one walk around the corners with a stack finds all.
pub(super) fn each_triangle(surface: &Surface, mut each: impl FnMut([usize; 3])) {
    let simulated = Simulated::of(surface);
    let node = |corner: usize| {
        let vertex = surface.polygons.corners[corner];
        surface.node_of_vertex.as_ref().map_or(vertex, |nodes| nodes[vertex as usize])
    };
    let mut stack: Vec<usize> = Vec::new();
    for face in surface.polygons.offsets.windows(2) {
        stack.clear();
        for corner in face[0] as usize..face[1] as usize {
            stack.push(corner);
            while let [.., a, b, c] = stack[..] {
                match simulated.turned([a, b, c].map(node)) {
                    Some(turned) => each(if turned { [a, c, b] } else { [a, b, c] }),
                    None => break,
                }
                stack.remove(stack.len() - 2);
            }
        }
        for pair in stack.windows(2).skip(1) {
            let corners = [stack[0], pair[0], pair[1]];
            let [a, b, c] = corners.map(node);
            if a != b && b != c && c != a {
                each(corners);
            }
        }
    }
}

/// The simulation's triangles, to be found by their nodes.
struct Simulated {
    /// Nodes ascending, and whether the triangle goes round them the other way; sorted.
    triangles: Vec<([u32; 3], bool)>,
}

impl Simulated {
    fn of(surface: &Surface) -> Self {
        let mut triangles: Vec<_> = surface.triangles.iter().map(|&nodes| ascending(nodes)).collect();
        triangles.sort_unstable();
        Self { triangles }
    }

    /// Whether the triangle of these nodes goes round them the other way; `None` if there is none.
    fn turned(&self, nodes: [u32; 3]) -> Option<bool> {
        let (nodes, odd) = ascending(nodes);
        let at = self.triangles.binary_search_by_key(&nodes, |(nodes, _)| *nodes).ok()?;
        Some(self.triangles[at].1 != odd)
    }
}

/// The nodes in ascending order, and whether that turns the triangle over.
fn ascending([a, b, c]: [u32; 3]) -> ([u32; 3], bool) {
    let mut nodes = [a, b, c];
    nodes.sort_unstable();
    (nodes, nodes != [a, b, c] && nodes != [b, c, a] && nodes != [c, a, b])
}
