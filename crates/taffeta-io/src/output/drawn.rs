//! A surface as renderers want it: vertices with one texture coordinate each, in triangles and lines.

use super::triangles::each_triangle;
use super::uvs::Split;
use taffeta::topology::Surface;

/// What to draw of a surface.
///
/// ```
/// use taffeta_io::output::Drawn;
/// use taffeta_io::{MeshFormat, MeshOptions, parse_mesh};
///
/// let square = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
/// let drawn = Drawn::of(&parse_mesh(square, MeshFormat::Obj, &MeshOptions::default())?);
/// assert_eq!((drawn.vertices.len(), drawn.triangles.len()), (4, 2));
/// # Ok::<(), taffeta_io::MeshError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawn {
    /// The file's vertex that each vertex to draw is: its own in order, then copies of those at a seam of the texture.
    pub vertices: Vec<u32>,
    /// The node that moves each; `u32::MAX` where no face uses it.
    pub nodes: Vec<u32>,
    /// Texture coordinates, counted from the bottom of the picture, if the file has them.
    pub uvs: Option<Vec<[f32; 2]>>,
    /// The faces as triangles, cut as in the simulation.
    pub triangles: Vec<[u32; 3]>,
    /// Lines between vertices that no triangle joins.
    pub links: Vec<[u32; 2]>,
}

impl Drawn {
    /// Cuts faces, and vertices along seams of the texture.
    pub fn of(surface: &Surface) -> Self {
        let split = surface.uvs.as_ref().map(|uvs| Split::of(surface, uvs));
        let corners = split.as_ref().map_or(&surface.polygons.corners, |split| &split.corners);
        let mut triangles = Vec::new();
        each_triangle(surface, |three| triangles.push(three.map(|corner| corners[corner])));
        let (vertices, uvs) = match split {
            Some(split) => (split.source, Some(split.coords)),
            None => ((0..surface.vertices.len() as u32).collect(), None),
        };
        let node = |&vertex: &u32| surface.node_of_vertex.as_ref().map_or(vertex, |map| map[vertex as usize]);
        let nodes = vertices.iter().map(node).collect();
        Self { vertices, nodes, uvs, triangles, links: surface.links.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{MeshFormat, MeshOptions, parse_mesh};

    #[test]
    fn a_vertex_at_a_seam_is_drawn_twice_and_moved_by_one_node() {
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 9 9 9\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0.5 0.5\n\
                    f 1/1 2/2 3/3\nf 1/5 3/3 4/4\n";
        let surface = parse_mesh(text.as_bytes(), MeshFormat::Obj, &MeshOptions::default()).unwrap();
        let drawn = Drawn::of(&surface);
        assert_eq!(drawn.vertices, [0, 1, 2, 3, 4, 0]);
        assert_eq!(drawn.nodes, [0, 1, 2, 3, u32::MAX, 0]);
        assert_eq!(drawn.triangles, [[0, 1, 2], [5, 2, 3]]);
        assert_eq!(drawn.uvs.unwrap()[5], [0.5, 0.5]);
    }
}
