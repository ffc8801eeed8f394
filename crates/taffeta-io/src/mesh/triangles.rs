//! Triangles on their way from a file's faces to a surface.

use super::polygon::Triangulator;
use taffeta::topology::Polygons;

/// Triangles of nodes, and of vertices where a rest shape needs them.
pub(super) struct Triangles {
    /// Nodes at the corners.
    pub nodes: Vec<[u32; 3]>,
    /// Vertices at the corners, in step with `nodes`.
    pub vertices: Option<Vec<[u32; 3]>>,
}

/// Faces that did not become triangles as they should.
pub(super) struct Faulty {
    /// Too few corners are left to have one.
    pub collapsed: usize,
    /// They cross themselves.
    pub crossed: usize,
}

impl Triangles {
    /// The triangles of faces.
    pub fn of_nodes(polygons: &Polygons, node_of_vertex: &[u32], nodes: &[[f64; 3]]) -> (Self, Faulty) {
        let mut triangulator = with_room(polygons);
        polygons.iter().for_each(|polygon| triangulator.add(polygon, node_of_vertex, nodes));
        let Triangulator { collapsed, crossed, .. } = triangulator;
        (Self { nodes: triangulator.triangles, vertices: None }, Faulty { collapsed, crossed })
    }

    /// As [`Self::of_nodes`], and knows which vertex is at each corner.
    pub fn with_vertices(
        polygons: &Polygons,
        node_of_vertex: &[u32],
        vertices: &[[f64; 3]],
    ) -> (Self, Faulty) {
        let node = |vertex: u32| node_of_vertex[vertex as usize];
        let themselves: Vec<u32> = (0..vertices.len() as u32).collect();
        let mut triangulator = with_room(polygons);
        let mut ring: Vec<u32> = Vec::new();
        for polygon in polygons.iter() {
            // Neighbours at one node are one corner, as they are where the triangulator sees nodes.
            ring.clear();
            ring.extend(polygon);
            ring.dedup_by_key(|vertex| node(*vertex));
            while ring.len() > 1 && node(ring[0]) == node(ring[ring.len() - 1]) {
                ring.pop();
            }
            triangulator.add(&ring, &themselves, vertices);
        }
        let Triangulator { triangles: vertices, collapsed, crossed, .. } = triangulator;
        let nodes = vertices.iter().map(|triangle| triangle.map(node)).collect();
        (Self { nodes, vertices: Some(vertices) }, Faulty { collapsed, crossed })
    }

    /// Keeps the triangles that `keep` says, by index and nodes. Returns how many went.
    pub fn retain(&mut self, mut keep: impl FnMut(usize, [u32; 3]) -> bool) -> usize {
        let before = self.nodes.len();
        let mut kept = 0;
        for index in 0..before {
            if keep(index, self.nodes[index]) {
                self.nodes[kept] = self.nodes[index];
                if let Some(vertices) = &mut self.vertices {
                    vertices[kept] = vertices[index];
                }
                kept += 1;
            }
        }
        self.nodes.truncate(kept);
        self.vertices.iter_mut().for_each(|vertices| vertices.truncate(kept));
        before - kept
    }

    /// Turns a triangle over.
    pub fn turn(&mut self, index: usize) {
        self.nodes[index].swap(1, 2);
        self.vertices.iter_mut().for_each(|vertices| vertices[index].swap(1, 2));
    }
}

/// Room for all triangles at once: a vector that grows would need twice as much.
fn with_room(polygons: &Polygons) -> Triangulator {
    let mut triangulator = Triangulator::default();
    triangulator.triangles.reserve_exact(polygons.corners.len().saturating_sub(2 * polygons.len()));
    triangulator
}
