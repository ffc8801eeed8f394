//! The chunks of a system.

use crate::solvers::constraints::Constraints;
use std::ops::Range;

/// Rows of a chunk at most.
const ROWS: usize = 256;
/// Nodes of a chunk at most.
const NODES: usize = 128;

/// Some rows, or nodes, of one body.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chunk {
    pub body: usize,
    pub part: Range<usize>,
}

/// The chunks of a system.
#[derive(Clone, Debug, Default)]
pub struct Layout {
    pub rows: Vec<Chunk>,
    pub nodes: Vec<Chunk>,
    /// Chunks of rows of each body.
    pub of_body: Vec<Range<usize>>,
    /// Nodes of each tile, if constraints are adaptive.
    pub nodes_of_tile: Vec<Range<usize>>,
    /// Number of rows.
    pub count: usize,
}

impl Layout {
    /// Cuts systems into chunks, by the rows and nodes of each body in turn.
    pub fn cut(&mut self, bodies: impl Iterator<Item = (Range<usize>, Range<usize>)>) {
        self.rows.clear();
        self.nodes.clear();
        self.of_body.clear();
        self.count = 0;
        for (body, (rows, nodes)) in bodies.enumerate() {
            let from = self.rows.len();
            self.count += rows.len();
            self.rows.extend(chunks(body, rows, ROWS));
            self.of_body.push(from..self.rows.len());
            self.nodes.extend(chunks(body, nodes, NODES));
        }
    }
}

/// Chunks that the rows of a scene need at most.
pub fn most_chunks(list: &Constraints) -> usize {
    list.bodies.iter().map(|rows| rows.len().div_ceil(ROWS)).sum()
}

fn chunks(body: usize, all: Range<usize>, size: usize) -> impl Iterator<Item = Chunk> {
    all.clone().step_by(size).map(move |start| Chunk { body, part: start..all.end.min(start + size) })
}
