//! A body's surface as its file gave it (vertices, polygons, texture coordinates, groups) and as it is simulated
//! (nodes, triangles, links).

/// A surface, checked and ready to be simulated.
///
/// `vertices` are what the file has, in the file's order; `nodes` are what is simulated: vertices at one place share
/// a node. Outputs follow the vertices.
///
/// ```
/// use std::sync::Arc;
/// use taffeta::scene::{Body, Mass, Mesh, Surface};
///
/// // Two triangles of a mesh that your program has.
/// let nodes = vec![[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.0, 0.1], [0.0, 0.0, 0.1]];
/// let surface = Surface::of_triangles(nodes, vec![[0, 1, 2], [0, 2, 3]]);
/// let patch = Body::cloth("patch", Mesh::Surface(Arc::new(surface))).with_mass(Mass::Area(0.2)).structural(20.0, 0.01);
/// assert_eq!(patch.mesh.nodes(), 4);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Surface {
    /// Places of the vertices [m], in the file's order.
    pub vertices: Vec<[f64; 3]>,
    /// The file's faces, of any size.
    pub polygons: Polygons,
    /// Texture coordinates, if the file has them.
    pub uvs: Option<Uvs>,
    /// Named sets of vertices: OBJ groups, PLY vertex attributes above 0.5.
    pub groups: Vec<(String, Vec<u32>)>,
    /// Places of the nodes [m].
    pub nodes: Vec<[f64; 3]>,
    /// The node of each vertex; `None` where every vertex is its own node. `u32::MAX`: a vertex that no face uses;
    /// it is kept in outputs where it was, and not simulated.
    pub node_of_vertex: Option<Vec<u32>>,
    /// Triangles of nodes, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Pairs of nodes joined without a triangle (chains), in order.
    pub links: Vec<[u32; 2]>,
    /// Places of each triangle's corners at rest [m], where that is another shape than `nodes`: a garment's pattern.
    /// Corners at one node may lie at different places, as on either side of a seam.
    pub rest: Option<Vec<[[f64; 3]; 3]>>,
    /// What was repaired on the way in, in words for the user.
    pub repairs: Vec<String>,
}

impl Surface {
    /// A surface of triangles alone: nodes [m] are its vertices, triangles its faces, counter-clockwise from outside.
    pub fn of_triangles(nodes: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Self {
        let mut polygons = Polygons::default();
        triangles.iter().for_each(|triangle| polygons.push(triangle));
        Self { vertices: nodes.clone(), polygons, nodes, triangles, ..Self::default() }
    }

    /// The first vertex at a node, for messages. A node that no vertex has, as where a point was split into several
    /// nodes, stands at the place of one.
    pub fn first_vertex_of(&self, node: u32) -> usize {
        let Some(list) = &self.node_of_vertex else { return node as usize };
        let here = || self.vertices.iter().position(|place| *place == self.nodes[node as usize]);
        list.iter().position(|n| *n == node).or_else(here).unwrap_or(0)
    }
}

/// Faces with any number of corners, one after the other.
///
/// ```
/// use taffeta::scene::Polygons;
///
/// let mut faces = Polygons::default();
/// faces.push(&[0, 1, 2, 3]);
/// faces.push(&[0, 3, 4]);
/// assert_eq!(faces.iter().map(<[u32]>::len).collect::<Vec<_>>(), [4, 3]);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Polygons {
    /// Where each face's corners start in `corners`; one more than there are faces, the first is 0. Empty: no faces.
    pub offsets: Vec<u32>,
    /// Vertex indices.
    pub corners: Vec<u32>,
}

impl Polygons {
    /// Adds a face.
    pub fn push(&mut self, face: &[u32]) {
        if self.offsets.is_empty() {
            self.offsets.push(0);
        }
        self.corners.extend_from_slice(face);
        self.offsets.push(self.corners.len() as u32);
    }

    /// Number of faces.
    pub fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The faces in order, each a slice of vertex indices. One whose offsets are beyond `corners`, or do not ascend, has none.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let face = |ends: &[u32]| self.corners.get(ends[0] as usize..ends[1] as usize).unwrap_or_default();
        self.offsets.windows(2).map(face)
    }
}

/// Texture coordinates, one index a face corner.
///
/// ```
/// use taffeta::scene::{Surface, Uvs};
///
/// let nodes = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
/// let mut surface = Surface::of_triangles(nodes, vec![[0, 1, 2]]);
/// surface.uvs = Some(Uvs { coords: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], corners: vec![0, 1, 2] });
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Uvs {
    /// Coordinates.
    pub coords: Vec<[f32; 2]>,
    /// One index into `coords` for each entry of [`Polygons::corners`].
    pub corners: Vec<u32>,
}
