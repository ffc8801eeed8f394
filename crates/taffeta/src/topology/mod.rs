//! What follows from meshes alone: shapes, edges, hinges, springs, adjacency, ordering, mass shares.

mod surface;
pub use surface::{Polygons, Surface, Uvs};
