//! One node for vertices at one place.

use std::hash::{BuildHasher, RandomState};

/// An empty slot.
const NONE: u32 = u32::MAX;

/// Gives vertices at exactly one place one node: the first of them, in the vertices' order.
pub(super) fn weld(vertices: &[[f64; 3]], repairs: &mut Vec<String>) -> (Vec<[f64; 3]>, Vec<u32>) {
    let mut places = Places::new(vertices);
    let mut node_of_vertex: Vec<u32> = Vec::with_capacity(vertices.len());
    let mut count = 0;
    for vertex in 0..vertices.len() {
        let first = places.first(vertex as u32) as usize;
        let node = if first == vertex { count } else { node_of_vertex[first] };
        count += u32::from(first == vertex);
        node_of_vertex.push(node);
    }
    drop(places);
    let mut nodes = Vec::with_capacity(count as usize);
    for (vertex, &node) in vertices.iter().zip(&node_of_vertex) {
        if node as usize == nodes.len() {
            nodes.push(*vertex);
        }
    }
    if nodes.len() < vertices.len() {
        let (all, places) = (vertices.len(), nodes.len());
        repairs.push(format!("welded {all} vertices into {places}: they lay at the same places"));
    }
    (nodes, node_of_vertex)
}

/// The first vertex at each place: a hash table with open addressing of four bytes a slot.
struct Places<'a> {
    vertices: &'a [[f64; 3]],
    /// A power of two of them.
    slots: Vec<u32>,
    /// Differ from run to run, so that no file can be made to be slow; what is found does not depend on them.
    keys: [u64; 3],
}

impl<'a> Places<'a> {
    fn new(vertices: &'a [[f64; 3]]) -> Self {
        let slots = (vertices.len() + vertices.len() / 2 + 1).next_power_of_two();
        let random = RandomState::new();
        Self { vertices, slots: vec![NONE; slots], keys: [0, 1, 2].map(|i| random.hash_one(i)) }
    }

    /// The first vertex asked for at this one's place; itself, if it is the first.
    fn first(&mut self, vertex: u32) -> u32 {
        let place = self.vertices[vertex as usize];
        let last = self.slots.len() - 1;
        let mut slot = self.hash(place) as usize & last;
        loop {
            match self.slots[slot] {
                NONE => {
                    self.slots[slot] = vertex;
                    return vertex;
                }
                // As numbers, so that −0 is the same place as 0.
                there if self.vertices[there as usize] == place => return there,
                _ => slot = (slot + 1) & last,
            }
        }
    }

    fn hash(&self, place: [f64; 3]) -> u64 {
        // Adding zero makes −0 the same bits as 0.
        let [x, y, z] = place.map(|x| (x + 0.0).to_bits());
        let [a, b, c] = self.keys;
        fold(fold(x ^ a, y ^ b) ^ z, c)
    }
}

/// Both halves of the product, so that every bit of either number counts.
fn fold(a: u64, b: u64) -> u64 {
    let product = u128::from(a) * u128::from(b | 1);
    product as u64 ^ (product >> 64) as u64
}
