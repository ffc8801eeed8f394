//! Clusters of up to sixteen nodes that are near each other, groups of sixteen clusters, boxes around these, and bounds of how
//! far they move: what finds the nodes, or the triangles, that may touch.

pub mod bounds;
pub mod margin;
pub mod packed;
pub mod tree;
