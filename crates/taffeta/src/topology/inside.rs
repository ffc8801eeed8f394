//! Whether a surface has an inside, and why not, in words that checks and runs share.

use crate::topology::inspect::{Sides, is_orientable};
use crate::topology::measure::{area, volume};
use crate::topology::{Edges, Surface};
use std::collections::HashMap;
use std::fmt;

/// How many edges are named.
const NAMED: usize = 5;
/// Volume below which a closed surface holds nothing, relative to its area to the power 3/2: rounding, not shape.
const FLAT: f64 = 1e-12;

/// Why a surface has no inside.
///
/// ```
/// use taffeta::scene::{Cube, Mesh};
/// use taffeta::topology::{Edges, no_inside, shapes};
///
/// // A box without half of its lid.
/// let mut cube = shapes::surface(&Mesh::Cube(Cube { size: 0.2, divisions: 1 }))?;
/// cube.triangles.pop();
/// let why = no_inside(&cube, &Edges::new(8, &cube.triangles, &[])).expect("it is open");
/// assert!(why.to_string().starts_with("a soft body needs a closed surface, and this one has 1 hole, 3 boundary edges"));
/// assert!(why.fillable);
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NoInside {
    /// What is wrong, in words.
    pub faults: Vec<String>,
    /// Whether holes are all that is wrong, so that filling them would do.
    pub fillable: bool,
}

impl fmt::Display for NoInside {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a soft body needs a closed surface, and this one {}", self.faults.join("; it "))
    }
}

/// `1 edge`, `2 edges`.
fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Why a surface cannot be a soft body; `None` if it can: it has triangles, each edge has two, which agree on their
/// sides, and the volume is positive. Edges are named by vertices of the file.
///
/// ```
/// use taffeta::scene::{Cube, Mesh};
/// use taffeta::topology::{Edges, no_inside, shapes};
///
/// let mut cube = shapes::surface(&Mesh::Cube(Cube { size: 1.0, divisions: 1 }))?;
/// assert_eq!(no_inside(&cube, &Edges::new(8, &cube.triangles, &[])), None);
/// cube.triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
/// let why = no_inside(&cube, &Edges::new(8, &cube.triangles, &[])).expect("it is turned");
/// assert_eq!(why.faults, ["is inside out: its volume is -1.0000e0 m³"]);
/// # Ok::<(), String>(())
/// ```
pub fn no_inside(surface: &Surface, edges: &Edges) -> Option<NoInside> {
    let mut faults = Vec::new();
    let triangles = &surface.triangles;
    let borders = edges.borders();
    let crowded = edges.non_manifold_edges();
    if triangles.is_empty() {
        faults.push("has no triangles".to_owned());
    } else if edges.is_closed() {
        faults.extend(no_volume(surface));
    } else {
        let vertices = surface.vertex_of_node();
        let open = edges.boundary_edges();
        if open > 0 {
            let holes = borders.loops.len();
            let holes = if holes > 0 { counted(holes, "hole") + ", " } else { String::new() };
            let open = counted(open, "boundary edge");
            faults
                .push(format!("has {holes}{open} ({})", named_edges(&vertices, edges.with_uses(|n| n == 1))));
        }
        if crowded > 0 {
            let crowded = counted(crowded, "edge");
            let names = named_edges(&vertices, edges.with_uses(|n| n > 2));
            faults.push(format!("has {crowded} with more than two triangles ({names})"));
        }
        if edges.flipped > 0 {
            let sides = Sides::new(surface.nodes.len(), triangles, edges);
            let twisted = !is_orientable(triangles, edges, &sides);
            let what = if twisted { "is not orientable, like a Möbius strip: it" } else { "" };
            let flipped = counted(edges.flipped, "edge");
            let names = named_edges(&vertices, edges.flipped_pairs(triangles));
            faults.push(format!("{what} changes its sides at {flipped} ({names})").trim_start().to_owned());
        }
    }
    let fillable = crowded == 0 && edges.flipped == 0 && borders.ends == 0 && !borders.loops.is_empty();
    (!faults.is_empty()).then_some(NoInside { faults, fillable })
}

/// What is wrong with the volume of a closed surface.
fn no_volume(surface: &Surface) -> Option<String> {
    let volume = volume(&surface.nodes, &surface.triangles);
    let area: f64 = surface.triangles.iter().map(|t| area(&surface.nodes, *t)).sum();
    if volume > FLAT * area * area.sqrt() {
        None
    } else if volume < -FLAT * area * area.sqrt() {
        Some(format!("is inside out: its volume is {volume:.4e} m³"))
    } else {
        Some("holds no volume".to_owned())
    }
}

/// `vertices 1–3, 4–5, …`: the first of some edges between nodes, by the first vertex of each.
///
/// ```
/// use taffeta::topology::named_edges;
///
/// // Nodes 0 to 2 are the file's vertices 7, 3 and 5.
/// assert_eq!(named_edges(&[7, 3, 5], [[0, 1], [1, 2]].into_iter()), "vertices 3–7, 3–5");
/// ```
pub fn named_edges(vertex_of_node: &[u32], mut edges: impl Iterator<Item = [u32; 2]>) -> String {
    let first: Vec<String> = edges
        .by_ref()
        .take(NAMED)
        .map(|edge| {
            let [a, b] = edge.map(|node| vertex_of_node[node as usize]);
            format!("{}–{}", a.min(b), a.max(b))
        })
        .collect();
    let more = if edges.next().is_some() { ", …" } else { "" };
    format!("vertices {}{more}", first.join(", "))
}

impl Surface {
    /// The first vertex of each node; the first at its place, where a node was split and another one has the vertex.
    pub fn vertex_of_node(&self) -> Vec<u32> {
        let Some(map) = &self.node_of_vertex else { return (0..self.nodes.len() as u32).collect() };
        let mut vertices = vec![u32::MAX; self.nodes.len()];
        for (vertex, &node) in (0..map.len() as u32).zip(map).rev().filter(|(_, node)| **node != u32::MAX) {
            vertices[node as usize] = vertex;
        }
        // Adding zero makes −0 the same bits as 0.
        let key = |place: [f64; 3]| place.map(|x| (x + 0.0).to_bits());
        let split: Vec<usize> = (0..vertices.len()).filter(|node| vertices[*node] == u32::MAX).collect();
        let mut first: HashMap<_, u32> = split.iter().map(|node| (key(self.nodes[*node]), 0)).collect();
        if !split.is_empty() {
            for (vertex, place) in (0..self.vertices.len() as u32).zip(&self.vertices).rev() {
                first.entry(key(*place)).and_modify(|first| *first = vertex);
            }
        }
        split.into_iter().for_each(|node| vertices[node] = first[&key(self.nodes[node])]);
        vertices
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

    fn why(triangles: &[[u32; 3]]) -> Option<NoInside> {
        let surface = Surface {
            nodes: CORNERS.to_vec(),
            // Vertex 0 is not used, and the last one is where the first is.
            node_of_vertex: Some(vec![u32::MAX, 0, 1, 2, 3, 0]),
            triangles: triangles.to_vec(),
            ..Surface::default()
        };
        no_inside(&surface, &Edges::new(4, &surface.triangles, &[]))
    }

    #[test]
    fn each_fault_is_named_with_its_edges() {
        assert_eq!(why(&TETRAHEDRON), None);
        let open = why(&TETRAHEDRON[..3]).unwrap();
        assert_eq!(
            open.to_string(),
            "a soft body needs a closed surface, and this one has 1 hole, 3 boundary edges (vertices 2–3, 2–4, 3–4)"
        );
        assert!(open.fillable);
        let mut turned = TETRAHEDRON;
        turned[3] = [1, 3, 2];
        assert_eq!(why(&turned).unwrap().faults, ["changes its sides at 3 edges (vertices 2–3, 2–4, 3–4)"]);
        let inside_out = TETRAHEDRON.map(|[a, b, c]| [a, c, b]);
        assert_eq!(why(&inside_out).unwrap().faults, ["is inside out: its volume is -1.6667e-1 m³"]);
        assert_eq!(why(&[[0, 1, 2], [0, 2, 1]]).unwrap().faults, ["holds no volume"]);
        assert_eq!(why(&[]).unwrap().faults, ["has no triangles"]);
    }

    #[test]
    fn a_split_node_is_called_by_the_vertex_at_its_place() {
        let place = CORNERS[1];
        let surface = Surface {
            vertices: vec![[9.0; 3], CORNERS[2], [1.0, -0.0, 0.0], place, CORNERS[3]],
            nodes: vec![CORNERS[3], place, CORNERS[2], place],
            node_of_vertex: Some(vec![u32::MAX, 2, 1, 1, 0]),
            ..Surface::default()
        };
        assert_eq!(surface.vertex_of_node(), [4, 2, 1, 2]);
    }

    #[test]
    fn three_triangles_at_an_edge_cannot_be_filled() {
        let fan = why(&[[0, 1, 2], [1, 0, 3], [0, 1, 3]]).unwrap();
        assert!(!fan.fillable);
        assert!(fan.faults[1].starts_with("has 1 edge with more than two triangles (vertices 1–2)"), "{fan}");
    }
}
