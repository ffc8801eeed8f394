//! Borders of holes, as rings of open edges.

use super::edges::{Across, Edges, ends};

const NONE: usize = usize::MAX;

/// The borders of a surface whose neighbours agree on their winding.
pub(super) struct Borders {
    /// Sides along open edges, head to tail, each ring passing each of its nodes once.
    pub simple: Vec<Vec<u32>>,
    /// Number of open edges of other borders: those that run into an edge with more than two triangles, or a twist.
    pub others: usize,
}

impl Borders {
    pub fn of(nodes: usize, triangles: &[[u32; 3]], edges: &Edges) -> Self {
        let mut borders = Self { simple: Vec::new(), others: 0 };
        let mut seen = vec![false; edges.sides() as usize];
        // Where the path passes a node.
        let mut passed = vec![NONE; nodes];
        for seed in 0..edges.sides() {
            if edges.across(seed) == Across::Open && !seen[seed as usize] {
                borders.walk(seed, triangles, edges, &mut seen, &mut passed);
            }
        }
        borders
    }

    /// Follows a border from `side`, and cuts off a ring whenever it comes back to a node that it has passed: so two
    /// holes that touch at a point are two.
    fn walk(
        &mut self,
        mut side: u32,
        triangles: &[[u32; 3]],
        edges: &Edges,
        seen: &mut [bool],
        passed: &mut [usize],
    ) {
        let start = |side: u32| ends(triangles, side)[0] as usize;
        let mut path: Vec<u32> = Vec::new();
        loop {
            let node = start(side);
            if passed[node] != NONE {
                let ring = path.split_off(passed[node]);
                ring.iter().for_each(|&side| passed[start(side)] = NONE);
                self.simple.push(ring);
            }
            if seen[side as usize] {
                break;
            }
            seen[side as usize] = true;
            passed[node] = path.len();
            path.push(side);
            match following(side, edges) {
                Some(next) => side = next,
                None => break,
            }
        }
        self.others += path.len();
        path.into_iter().for_each(|side| passed[start(side)] = NONE);
    }
}

/// The side after `side` along a border: around the node at its end, across the triangles there.
fn following(side: u32, edges: &Edges) -> Option<u32> {
    let next = |side: u32| side - side % 3 + (side % 3 + 1) % 3;
    let mut at = next(side);
    loop {
        match edges.across(at) {
            Across::Open => return Some(at),
            Across::Side(across, false) => at = next(across),
            Across::Crowded | Across::Side(_, true) => return None,
        }
    }
}
