//! Holes closed by triangles between the nodes of their borders.

use super::borders::Borders;
use super::clean::{counted, is_flat};
use super::edges::{Edges, ends};
use super::least_area::least_area;
use super::polygon::Triangulator;
use super::triangles::Triangles;
use std::collections::BTreeSet;

/// How many borders a message describes.
const DESCRIBED: usize = 8;

/// Closes holes whose border passes each of its nodes once. Neighbours agree on their winding; the new triangles agree
/// with them. Returns whether there are new ones.
pub(super) fn fill(
    triangles: &mut Triangles,
    edges: &Edges,
    nodes: &[[f64; 3]],
    node_of_vertex: &[u32],
    repairs: &mut Vec<String>,
) -> bool {
    let Borders { simple, others } = Borders::of(nodes.len(), &triangles.nodes, edges);
    // What closes a lone triangle is the same triangle again.
    let lone = |border: &Vec<u32>| border.iter().all(|side| side / 3 == border[0] / 3);
    let (unfit, borders): (Vec<_>, Vec<_>) = simple.into_iter().partition(lone);
    // A border runs as its triangles do; a neighbour's runs against it.
    let ring = |border: Vec<u32>| -> Vec<u32> {
        border.into_iter().rev().map(|side| ends(&triangles.nodes, side)[0]).collect()
    };
    let rings: Vec<Vec<u32>> = borders.into_iter().map(ring).collect();
    let mut chords = Chords::of(&rings, &triangles.nodes, nodes.len());
    let before = triangles.nodes.len();
    let (mut filled, mut unfit) = (Vec::new(), unfit.len());
    for ring in &rings {
        match triangulate(ring, nodes, &chords) {
            Some(new) => {
                chords.new.extend(new.iter().flat_map(|t| sides(*t)));
                triangles.nodes.extend(new);
                filled.push(ring.len());
            }
            None => unfit += 1,
        }
    }
    if let Some(vertices) = &mut triangles.vertices {
        let first = first_vertices(nodes.len(), node_of_vertex);
        vertices.extend(triangles.nodes[before..].iter().map(|t| t.map(|node| first[node as usize])));
    }
    report(&filled, triangles.nodes.len() - before, others, unfit, repairs);
    !filled.is_empty()
}

/// Triangles of a ring, none of them flat, that use no edge a second time; `None`, where there are none.
fn triangulate(ring: &[u32], nodes: &[[f64; 3]], chords: &Chords) -> Option<Vec<[u32; 3]>> {
    let local: Vec<u32> = (0..ring.len() as u32).collect();
    let mut triangulator = Triangulator::default();
    triangulator.add(&local, ring, nodes);
    let new = triangulator.triangles;
    let mut border: Vec<_> = (0..ring.len()).map(|i| edge(ring[i], ring[(i + 1) % ring.len()])).collect();
    border.sort_unstable();
    let free = |side: &[u32; 2]| border.binary_search(side).is_ok() || !chords.has(side);
    let fits = |t: &[u32; 3]| !is_flat(t.map(|node| nodes[node as usize])) && sides(*t).iter().all(free);
    if new.len() + 2 == ring.len() && new.iter().all(fits) {
        return Some(new);
    }
    least_area(ring, nodes, |a, b| !chords.has(&edge(a, b)))
}

/// Edges between nodes of borders, which a new triangle may not use again.
struct Chords {
    /// Those of the surface, sorted.
    old: Vec<[u32; 2]>,
    /// Those of new triangles.
    new: BTreeSet<[u32; 2]>,
}

impl Chords {
    fn of(rings: &[Vec<u32>], triangles: &[[u32; 3]], nodes: usize) -> Self {
        let mut at_border = vec![false; nodes];
        rings.iter().flatten().for_each(|&node| at_border[node as usize] = true);
        let within = |side: &[u32; 2]| side.iter().all(|&node| at_border[node as usize]);
        let mut old: Vec<_> = triangles.iter().flat_map(|t| sides(*t)).filter(within).collect();
        old.sort_unstable();
        Self { old, new: BTreeSet::new() }
    }

    fn has(&self, side: &[u32; 2]) -> bool {
        self.old.binary_search(side).is_ok() || self.new.contains(side)
    }
}

fn sides([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [edge(a, b), edge(b, c), edge(c, a)]
}

fn edge(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// The first vertex at each node.
fn first_vertices(nodes: usize, node_of_vertex: &[u32]) -> Vec<u32> {
    let mut first = vec![0; nodes];
    for (vertex, &node) in node_of_vertex.iter().enumerate().rev() {
        first[node as usize] = vertex as u32;
    }
    first
}

fn report(filled: &[usize], triangles: usize, others: usize, unfit: usize, repairs: &mut Vec<String>) {
    if !filled.is_empty() {
        let lengths: Vec<String> = filled.iter().take(DESCRIBED).map(usize::to_string).collect();
        let more = if filled.len() > DESCRIBED { ", …" } else { "" };
        let borders = if filled.len() == 1 { "a border" } else { "borders" };
        repairs.push(format!(
            "filled {} with {} ({borders} of {}{more} edges)",
            counted(filled.len(), "hole"),
            counted(triangles, "triangle"),
            lengths.join(", ")
        ));
    }
    if others > 0 {
        repairs.push(format!(
            "left {} as found: the border runs into an edge with more than two triangles, or a twist",
            counted(others, "open edge")
        ));
    }
    if unfit > 0 {
        repairs.push(format!(
            "left {} open: triangles between the nodes of the border would be flat, or use edges of the mesh again",
            counted(unfit, "hole")
        ));
    }
}
