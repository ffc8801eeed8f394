//! The chunks of a system.

use crate::solvers::constraints::Constraints;
use crate::solvers::dual::cpu::bands::{self, Bands};
use std::ops::Range;

/// Rows of a chunk at most.
const ROWS: usize = 256;
/// Nodes of a chunk at most.
const NODES: usize = 128;

/// Some rows, or nodes, of one body. Of a body with bands, both are nodes of the body.
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
        self.clear();
        bodies.for_each(|(rows, nodes)| self.push(rows, nodes));
    }

    /// No chunks.
    pub fn clear(&mut self) {
        self.rows.clear();
        self.nodes.clear();
        self.of_body.clear();
        self.count = 0;
    }

    /// Cuts the system of the next body.
    pub fn push(&mut self, rows: Range<usize>, nodes: Range<usize>) {
        let (from, body) = (self.rows.len(), self.of_body.len());
        self.count += rows.len();
        self.rows.extend(chunks(body, rows, ROWS));
        self.of_body.push(from..self.rows.len());
        self.nodes.extend(chunks(body, nodes, NODES));
    }

    /// The same of a body with bands, and so many constraints.
    pub fn push_bands<T>(&mut self, bands: &Bands<T>, constraints: usize) {
        let (from, body) = (self.rows.len(), self.of_body.len());
        self.count += constraints;
        self.rows.extend(chunks(body, 0..bands.nodes, bands::CHUNK));
        self.of_body.push(from..self.rows.len());
        self.nodes.extend(chunks(body, 0..bands.nodes, bands::CHUNK));
    }
}

/// Chunks that the rows of a scene need at most.
pub fn most_chunks<T>(list: &Constraints, bands: &[Option<Bands<T>>]) -> usize {
    let of_body = |(rows, bands): (&Range<usize>, &Option<Bands<T>>)| match bands {
        Some(bands) => bands.nodes.div_ceil(bands::CHUNK),
        None => rows.len().div_ceil(ROWS),
    };
    list.bodies.iter().zip(bands).map(of_body).sum()
}

fn chunks(body: usize, all: Range<usize>, size: usize) -> impl Iterator<Item = Chunk> {
    all.clone().step_by(size).map(move |start| Chunk { body, part: start..all.end.min(start + size) })
}
