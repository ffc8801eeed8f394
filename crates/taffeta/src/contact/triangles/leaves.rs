//! Leaves: a few triangles of one surface, in one of its zones, that are near each other, with their nodes, and what is known of
//! pairs of nodes of two leaves.

use crate::contact::triangles::surfaces::Surfaces;
use crate::topology::LANES;
use std::collections::HashSet;
use std::ops::Range;

/// Triangles of a leaf, at most, and its edges.
pub const LEAF: usize = 8;
pub const EDGES: usize = 3 * LEAF;

/// Up to eight triangles of one surface with up to sixteen nodes. Nodes of its triangles, edges and vertices are given by lane.
#[derive(Clone, Debug)]
pub struct Leaf {
    /// Its nodes by place; the first fills the lanes that are left.
    pub nodes: [u32; LANES],
    /// How many they are.
    pub count: usize,
    /// The number of its material: that of its surface, or of a zone.
    pub material: u32,
    /// Nodes that never give way, a bit for each lane.
    pub held: u16,
    /// The first of its triangles, edges and vertices among those of all surfaces, and how many it has.
    pub first: [u32; 3],
    pub counts: [usize; 3],
    pub triangles: [[u8; 3]; LEAF],
    /// Edges and vertices that no earlier leaf has.
    pub edges: [[u8; 2]; EDGES],
    pub vertices: [u8; LANES],
}

/// Pairs of nodes of two leaves: for each lane of the first, a bit for each lane of the second.
pub type Mask = [u16; LANES];

/// What is known of the nodes of two leaves.
#[derive(Clone, Copy, Debug)]
pub struct Ring {
    /// Nodes that are one: the same, sewn together, or split from one.
    pub same: Mask,
    /// Nodes that are neighbours along the surface.
    pub near: Mask,
}

/// The pairs of leaves with such nodes.
#[derive(Default)]
pub struct Rings {
    /// Where the row of each leaf begins, and where the last ends.
    pub starts: Vec<u32>,
    /// Second leaves, not before the first, ascending, with where their ring is.
    pub rows: Vec<(u32, u32)>,
    /// All of them; the first is empty.
    pub rings: Vec<Ring>,
}

impl Leaf {
    fn new(material: u32, first: [u32; 3]) -> Self {
        Self {
            nodes: [0; LANES],
            count: 0,
            material,
            held: 0,
            first,
            counts: [0; 3],
            triangles: [[0; 3]; LEAF],
            edges: [[0; 2]; EDGES],
            vertices: [0; LANES],
        }
    }

    /// Its nodes, without repetition.
    pub fn own(&self) -> &[u32] {
        &self.nodes[..self.count]
    }

    /// Whether there is room for a triangle.
    fn takes(&self, triangle: [u32; 3]) -> bool {
        let new = triangle.iter().filter(|node| !self.own().contains(node)).count();
        self.counts[0] < LEAF && self.count + new <= LANES
    }

    /// The lane of a node, which it may get now.
    fn lane(&mut self, node: u32) -> u8 {
        let lane = self.own().iter().position(|&one| one == node).unwrap_or_else(|| {
            self.nodes[self.count] = node;
            self.count += 1;
            self.count - 1
        });
        lane as u8
    }
}

/// Cuts triangles into leaves, in their order. Gives each edge and each vertex to the first leaf that has it.
pub struct Cut {
    pub leaves: Vec<Leaf>,
    /// By place: of all leaves.
    pub edges: Vec<[u32; 2]>,
    pub vertices: Vec<u32>,
}

impl Cut {
    /// Of triangles by place, with the material of each, and whether each place is held.
    pub fn new(triangles: &[[u32; 3]], materials: &[u32], held: &[bool]) -> Self {
        let mut all = Self { leaves: Vec::new(), edges: Vec::new(), vertices: Vec::new() };
        let (mut edges, mut vertices) = (HashSet::new(), HashSet::new());
        for (number, (&triangle, &material)) in (0..).zip(triangles.iter().zip(materials)) {
            let fits =
                all.leaves.last().is_some_and(|leaf| leaf.material == material && leaf.takes(triangle));
            if !fits {
                let first = [number, all.edges.len() as u32, all.vertices.len() as u32];
                all.leaves.push(Leaf::new(material, first));
            }
            let Some(leaf) = all.leaves.last_mut() else { continue };
            let lanes = triangle.map(|node| leaf.lane(node));
            leaf.triangles[leaf.counts[0]] = lanes;
            leaf.counts[0] += 1;
            for [i, j] in [[0, 1], [1, 2], [2, 0]] {
                let (a, b) = if triangle[i] < triangle[j] { (i, j) } else { (j, i) };
                let edge = [triangle[a], triangle[b]];
                if edges.insert(edge) {
                    all.edges.push(edge);
                    leaf.edges[leaf.counts[1]] = [lanes[a], lanes[b]];
                    leaf.counts[1] += 1;
                }
            }
            for (node, lane) in triangle.into_iter().zip(lanes) {
                if vertices.insert(node) {
                    all.vertices.push(node);
                    leaf.vertices[leaf.counts[2]] = lane;
                    leaf.counts[2] += 1;
                }
            }
        }
        for leaf in &mut all.leaves {
            let first = leaf.nodes[0];
            leaf.nodes[leaf.count..].fill(first);
            for (lane, &node) in leaf.nodes.iter().enumerate() {
                leaf.held |= u16::from(held[node as usize]) << lane;
            }
        }
        all
    }
}

impl Surfaces {
    /// The first triangle, edge and vertex of each leaf.
    pub fn firsts(&self) -> Vec<[u32; 3]> {
        self.leaves.iter().map(|leaf| leaf.first).collect()
    }

    /// The leaves of each place.
    pub fn leaves_by_place(&self) -> Lists {
        let mut starts = vec![0; self.all_places() + 1];
        for leaf in &self.leaves {
            leaf.own().iter().for_each(|&node| starts[node as usize + 1] += 1);
        }
        for place in 0..self.all_places() {
            starts[place + 1] += starts[place];
        }
        let (mut next, mut items) = (starts.clone(), vec![0; starts[self.all_places()] as usize]);
        for (number, leaf) in (0..).zip(&self.leaves) {
            for &node in leaf.own() {
                let at = &mut next[node as usize];
                items[*at as usize] = number;
                *at += 1;
            }
        }
        Lists { starts, items }
    }
}

/// A list for each place.
pub struct Lists {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Lists {
    /// That of a place.
    pub fn of(&self, place: usize) -> &[u32] {
        &self.items[self.starts[place] as usize..self.starts[place + 1] as usize]
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        4 * (self.starts.len() + self.items.len())
    }
}

impl Rings {
    /// Of leaves, where `each` calls its last argument with all nodes that are one with a node, and `true`, and with all
    /// neighbours of it, and `false`.
    pub fn new(leaves: &[Leaf], by_place: &Lists, each: impl Fn(u32, &mut dyn FnMut(u32, bool))) -> Self {
        let empty = Ring { same: [0; LANES], near: [0; LANES] };
        let mut all = Self { starts: vec![0], rows: Vec::new(), rings: vec![empty] };
        let mut found: Vec<(u32, u8, u32, bool)> = Vec::new();
        for (number, leaf) in (0..).zip(leaves) {
            found.clear();
            for (lane, &node) in (0..).zip(leaf.own()) {
                let mut note = |other: u32, same: bool| {
                    let later = by_place.of(other as usize).iter().filter(|&&leaf| leaf >= number);
                    found.extend(later.map(|&leaf| (leaf, lane, other, same)));
                };
                note(node, true);
                each(node, &mut note);
            }
            found.sort_unstable_by_key(|one| one.0);
            for of_one in found.chunk_by(|a, b| a.0 == b.0) {
                let second = &leaves[of_one[0].0 as usize];
                let mut ring = empty;
                for &(_, lane, other, same) in of_one {
                    let Some(at) = second.own().iter().position(|&node| node == other) else { continue };
                    let mask = if same { &mut ring.same } else { &mut ring.near };
                    mask[usize::from(lane)] |= 1 << at;
                }
                all.rows.push((of_one[0].0, all.rings.len() as u32));
                all.rings.push(ring);
            }
            all.starts.push(all.rows.len() as u32);
        }
        all
    }

    /// The number of the ring of two leaves, `a` not after `b`; 0 if they have none.
    pub fn find(&self, a: usize, b: u32) -> u32 {
        let row: Range<usize> = self.starts[a] as usize..self.starts[a + 1] as usize;
        let row = &self.rows[row];
        row.binary_search_by_key(&b, |(second, _)| *second).map_or(0, |at| row[at].1)
    }

    /// A ring by its number.
    pub fn ring(&self, number: u32) -> &Ring {
        &self.rings[number as usize]
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        4 * self.starts.len() + size_of_val(&self.rows[..]) + size_of_val(&self.rings[..])
    }
}
