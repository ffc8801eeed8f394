//! Nodes at which parts of a surface touch in a point only, given to each part for itself.

use super::clean::counted;
use super::edges::{Across, Edges};
use std::collections::BTreeMap;
use taffeta::topology::Polygons;

/// Splits nodes whose triangles form several fans that share no edge at the node: one node for each fan. A vertex goes
/// with the fan that uses it; with the first one, by its lowest triangle, where several do.
pub(super) fn split(
    triangles: &mut [[u32; 3]],
    edges: &Edges,
    nodes: &mut Vec<[f64; 3]>,
    node_of_vertex: &mut [u32],
    polygons: &Polygons,
    repairs: &mut Vec<String>,
) {
    let corners = suspects(triangles, edges, nodes.len());
    let mut fans = Fans::default();
    let mut ties: BTreeMap<u32, Tie> = BTreeMap::new();
    let mut moves: Vec<(u32, u32)> = Vec::new();
    for row in corners.chunk_by(|a, b| a.0 == b.0) {
        let node = row[0].0;
        let count = fans.find(row, triangles);
        if count < 2 {
            continue;
        }
        let first = nodes.len() as u32;
        nodes.extend(std::iter::repeat_n(nodes[node as usize], count as usize - 1));
        let moved = row.iter().zip(&fans.fan).filter(|(_, fan)| **fan > 0);
        moves.extend(moved.map(|(&(_, corner), &fan)| (corner, first + fan - 1)));
        let neighbours = fans.neighbours.iter().map(|&(other, at)| (other, fans.fan[at as usize])).collect();
        ties.insert(node, Tie { first, neighbours });
    }
    if ties.is_empty() {
        return;
    }
    move_vertices(&ties, node_of_vertex, polygons);
    moves.into_iter().for_each(|(corner, node)| triangles[corner as usize / 3][corner as usize % 3] = node);
    let split = counted(ties.len(), "node");
    repairs.push(format!("split {split} where parts of the surface touched in a point only"));
}

/// Node and corner, `3·triangle + i`, of all corners at nodes that a walk around one fan does not see all of, sorted.
/// Where more than two triangles meet at an edge, several such fans may be one.
fn suspects(triangles: &[[u32; 3]], edges: &Edges, nodes: usize) -> Vec<(u32, u32)> {
    let mut seen = vec![false; edges.sides() as usize];
    let (mut begun, mut suspect) = (vec![false; nodes], vec![false; nodes]);
    for (&node, corner) in triangles.as_flattened().iter().zip(0..) {
        if !seen[corner as usize] {
            seen[corner as usize] = true;
            walk(corner, true, edges, &mut seen);
            walk(corner, false, edges, &mut seen);
            suspect[node as usize] |= begun[node as usize];
            begun[node as usize] = true;
        }
    }
    let corners = triangles.as_flattened().iter().copied().zip(0..);
    let mut found: Vec<(u32, u32)> = corners.filter(|(node, _)| suspect[*node as usize]).collect();
    found.sort_unstable();
    found
}

/// Marks the corners of a fan from `corner` on, first across the side that starts at it, or else the one that ends.
fn walk(mut corner: u32, mut starts: bool, edges: &Edges, seen: &mut [bool]) {
    let before = |corner: u32| corner - corner % 3 + (corner % 3 + 2) % 3;
    let after = |corner: u32| corner - corner % 3 + (corner % 3 + 1) % 3;
    loop {
        let side = if starts { corner } else { before(corner) };
        let Across::Side(across, same_way) = edges.across(side) else { return };
        // The other triangle's side starts at the node, if it runs as this one does and this one starts there.
        let other_starts = starts == same_way;
        corner = if other_starts { across } else { after(across) };
        if std::mem::replace(&mut seen[corner as usize], true) {
            return;
        }
        starts = !other_starts;
    }
}

/// A node to be split.
struct Tie {
    /// The new node of fan 1; the others follow it.
    first: u32,
    /// Nodes next to this one, sorted, with their fan.
    neighbours: Vec<(u32, u32)>,
}

impl Tie {
    fn fan(&self, neighbour: u32) -> Option<u32> {
        let at = self.neighbours.binary_search_by_key(&neighbour, |n| n.0).ok()?;
        Some(self.neighbours[at].1)
    }
}

/// The fans at a node; room to find them in.
#[derive(Default)]
struct Fans {
    /// Each other node of a triangle, and the place of its triangle among the node's; sorted.
    neighbours: Vec<(u32, u32)>,
    /// The fan of each of the node's triangles, by lowest triangle.
    fan: Vec<u32>,
}

impl Fans {
    /// Finds the fans of the corners `row`, all that a node has, ascending. Returns their number.
    fn find(&mut self, row: &[(u32, u32)], triangles: &[[u32; 3]]) -> u32 {
        self.neighbours.clear();
        for (&(node, corner), at) in row.iter().zip(0..) {
            let others = triangles[corner as usize / 3].iter().filter(|other| **other != node);
            self.neighbours.extend(others.map(|&other| (other, at)));
        }
        self.neighbours.sort_unstable();
        // Places of triangles, each joined to an earlier one of its fan.
        self.fan.clear();
        self.fan.extend(0..row.len() as u32);
        for pair in self.neighbours.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            let (a, b) = (root(&mut self.fan, pair[0].1), root(&mut self.fan, pair[1].1));
            self.fan[a.max(b) as usize] = a.min(b);
        }
        let mut count = 0;
        for at in 0..row.len() {
            let to = self.fan[at] as usize;
            self.fan[at] = if to == at { count } else { self.fan[to] };
            count += u32::from(to == at);
        }
        count
    }
}

/// The earliest place joined to `at`, halving the path to it.
fn root(fan: &mut [u32], mut at: u32) -> u32 {
    while fan[at as usize] != at {
        fan[at as usize] = fan[fan[at as usize] as usize];
        at = fan[at as usize];
    }
    at
}

/// Gives each vertex at a split node the node of the first fan that a face uses it in.
fn move_vertices(ties: &BTreeMap<u32, Tie>, node_of_vertex: &mut [u32], polygons: &Polygons) {
    let mut fan_of_vertex: BTreeMap<u32, u32> = BTreeMap::new();
    for polygon in polygons.iter() {
        let node = |i: usize| node_of_vertex[polygon[i % polygon.len()] as usize];
        for (i, vertex) in polygon.iter().enumerate() {
            let Some(tie) = ties.get(&node(i)) else { continue };
            let beside = [node(i + polygon.len() - 1), node(i + 1)];
            if let Some(fan) = beside.into_iter().filter_map(|other| tie.fan(other)).min() {
                let lowest = fan_of_vertex.entry(*vertex).or_insert(fan);
                *lowest = fan.min(*lowest);
            }
        }
    }
    for (vertex, fan) in fan_of_vertex.into_iter().filter(|(_, fan)| *fan > 0) {
        let node = &mut node_of_vertex[vertex as usize];
        *node = ties[node].first + fan - 1;
    }
}
