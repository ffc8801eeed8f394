//! Parts of a surface: triangles joined by edges of two, with one winding.

use super::edges::{Across, Edges, ends};
use std::ops::Range;

/// The parts of a surface.
pub(super) struct Parts {
    /// All triangles, part after part.
    order: Vec<u32>,
    /// The parts, by their first triangle.
    pub list: Vec<Part>,
    /// Triangles to turn, so that neighbours agree with the majority of their part.
    pub turned: Vec<bool>,
}

/// A part.
pub(super) struct Part {
    members: Range<usize>,
    /// Whether it bounds a volume: it has no open edge, and at an edge with more than two triangles as many of its own
    /// run one way as the other.
    pub closed: bool,
    /// Whether it has only one side, so that no winding is right; its triangles stay as they are.
    pub twisted: bool,
}

impl Parts {
    pub fn of(triangles: &[[u32; 3]], edges: &Edges) -> Self {
        let count = triangles.len();
        let mut parts =
            Self { order: Vec::with_capacity(count), list: Vec::new(), turned: vec![false; count] };
        let mut seen = vec![false; count];
        for seed in 0..count {
            if !seen[seed] {
                parts.flood(seed, edges, &mut seen);
                parts.settle();
            }
        }
        parts.balance(triangles, edges);
        parts
    }

    /// The triangles of a part.
    pub fn members(&self, part: &Part) -> &[u32] {
        &self.order[part.members.clone()]
    }

    /// Finds the part of `seed`, breadth first; `order` is the queue.
    fn flood(&mut self, seed: usize, edges: &Edges, seen: &mut [bool]) {
        let start = self.order.len();
        let (mut closed, mut twisted) = (true, false);
        let mut head = start;
        self.order.push(seed as u32);
        seen[seed] = true;
        while let Some(&triangle) = self.order.get(head) {
            head += 1;
            for side in 3 * triangle..3 * triangle + 3 {
                // Neighbours that agree run along their edge in opposite directions.
                let Across::Side(across, disagree) = edges.across(side) else {
                    closed &= edges.across(side) == Across::Crowded;
                    continue;
                };
                let other = across as usize / 3;
                let must_turn = self.turned[triangle as usize] ^ disagree;
                if !seen[other] {
                    seen[other] = true;
                    self.turned[other] = must_turn;
                    self.order.push(other as u32);
                } else if self.turned[other] != must_turn {
                    twisted = true;
                }
            }
        }
        self.list.push(Part { members: start..head, closed: closed && !twisted, twisted });
    }

    /// Lets the majority of the last part decide.
    fn settle(&mut self) {
        let Some(part) = self.list.last() else { return };
        let members = &self.order[part.members.clone()];
        let turned = members.iter().filter(|&&t| self.turned[t as usize]).count();
        let most = 2 * turned > members.len();
        for &triangle in members {
            let turned = &mut self.turned[triangle as usize];
            // If it is twisted, no choice is right; the file's own is as good as any.
            *turned = !part.twisted && (*turned ^ most);
        }
    }

    /// The part of each triangle.
    fn labels(&self) -> Vec<u32> {
        let mut labels = vec![0; self.order.len()];
        for (part, label) in self.list.iter().zip(0..) {
            self.members(part).iter().for_each(|&triangle| labels[triangle as usize] = label);
        }
        labels
    }

    /// Parts that do not balance at an edge with more than two triangles are not closed.
    fn balance(&mut self, triangles: &[[u32; 3]], edges: &Edges) {
        if edges.crowded().next().is_none() {
            return;
        }
        let labels = self.labels();
        let mut runs: Vec<(u32, i64)> = Vec::new();
        for edge in edges.crowded() {
            runs.clear();
            runs.extend(edge.iter().map(|&side| {
                let triangle = side as usize / 3;
                let [from, to] = ends(triangles, side);
                (labels[triangle], if (from < to) ^ self.turned[triangle] { 1 } else { -1 })
            }));
            runs.sort_unstable();
            for own in runs.chunk_by(|a, b| a.0 == b.0) {
                if own.iter().map(|run| run.1).sum::<i64>() != 0 {
                    self.list[own[0].0 as usize].closed = false;
                }
            }
        }
    }
}
