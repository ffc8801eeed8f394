//! The springs that each node of a grid owns.

/// Steps in rows and columns from a node to the other ends of its six springs: along the row by one and two, to the
/// rows below by one and two, both diagonals down. Every spring of a grid is owned by one node.
pub const GRID_STEPS: [(usize, isize); 6] = [(0, 1), (0, 2), (1, 0), (2, 0), (1, 1), (1, -1)];
