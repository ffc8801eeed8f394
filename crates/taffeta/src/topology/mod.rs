//! What follows from meshes alone: shapes, edges, hinges, springs, adjacency, ordering, mass shares.

pub mod adjacency;
pub mod edges;
pub mod mass;
pub mod measure;
pub mod order;
pub mod place;
pub mod random;
mod segment;
pub mod select;
pub mod shapes;
pub mod springs;
mod stencil;
pub mod struts;
mod surface;

pub use adjacency::{Csr, Gather, LANES};
pub use edges::{Edges, NONE};
pub use place::Placement;
pub use select::Selectable;
pub use springs::{GridCounts, SpringKind, SpringList};
pub use stencil::GRID_STEPS;
pub use surface::{Polygons, Surface, Uvs};
