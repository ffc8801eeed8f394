//! The contact list of a worker: nodes in contact, tile by tile, and the nodes that each of them touches.

use std::ops::Range;

/// The contact list of a worker.
pub struct ContactList {
    /// Pairs in contact as a node of this worker and the other node, in any order.
    pub ends: Vec<[u32; 2]>,
    /// Nodes in contact, tile by tile.
    owners: Vec<u32>,
    /// Where the list of each begins, and where the last ends.
    starts: Vec<u32>,
    /// What each touches, ascending.
    others: Vec<u32>,
    /// The first of each of the worker's tiles, and where the last ends.
    tiles: Vec<u32>,
    /// By place: number of contacts, then where the next one goes; 0 where there are none.
    next: Vec<u32>,
}

impl ContactList {
    /// For so many places, and a worker with so many tiles.
    pub fn new(places: usize, tiles: usize) -> Self {
        Self {
            ends: Vec::new(),
            owners: Vec::new(),
            starts: vec![0],
            others: Vec::new(),
            tiles: vec![0; tiles + 1],
            next: vec![0; places],
        }
    }

    /// Empties the list.
    pub fn clear(&mut self) {
        for &node in &self.owners {
            self.next[node as usize] = 0;
        }
        self.ends.clear();
        self.owners.clear();
        self.starts.truncate(1);
    }

    /// Nodes in contact.
    pub fn owners(&self) -> &[u32] {
        &self.owners
    }

    /// The numbers of a tile's nodes.
    pub fn of_tile(&self, tile: usize) -> Range<usize> {
        self.tiles[tile] as usize..self.tiles[tile + 1] as usize
    }

    /// What a node touches, by its number.
    pub fn others(&self, number: usize) -> &[u32] {
        &self.others[self.starts[number] as usize..self.starts[number + 1] as usize]
    }

    /// Sorts `ends` by node, and nodes by tile.
    pub fn sort(&mut self, tile: impl Fn(u32) -> usize) {
        let mut found = Vec::new();
        for &[node, _] in &self.ends {
            let count = &mut self.next[node as usize];
            if *count == 0 {
                found.push(node);
            }
            *count += 1;
        }
        self.sort_owners(&found, tile);
        let mut sum = 0;
        for &node in &self.owners {
            let count = &mut self.next[node as usize];
            (*count, sum) = (sum, sum + *count);
            self.starts.push(sum);
        }
        self.others.resize(sum as usize, 0);
        for &[node, other] in &self.ends {
            let next = &mut self.next[node as usize];
            self.others[*next as usize] = other;
            *next += 1;
        }
        for ends in self.starts.windows(2) {
            self.others[ends[0] as usize..ends[1] as usize].sort_unstable();
        }
    }

    /// Sorts nodes by tile.
    fn sort_owners(&mut self, found: &[u32], tile: impl Fn(u32) -> usize) {
        self.tiles.fill(0);
        found.iter().for_each(|&node| self.tiles[tile(node)] += 1);
        let mut sum = 0;
        for start in &mut self.tiles {
            (*start, sum) = (sum, sum + *start);
        }
        self.owners.resize(found.len(), 0);
        for &node in found {
            let next = &mut self.tiles[tile(node)];
            self.owners[*next as usize] = node;
            *next += 1;
        }
        // Each start has advanced to the next one.
        self.tiles.rotate_right(1);
        self.tiles[0] = 0;
    }
}
