//! What follows from meshes alone: shapes, edges, hinges, springs, adjacency, ordering, mass shares.
//!
//! # Panics
//! Functions here take triangles, edges and other lists of nodes at their word: where one names a node that is not there, or lists that
//! belong together have other lengths, they panic. [`Scene::validate`](crate::scene::Scene::validate) finds both in the surfaces of a
//! scene, and says where.

pub mod adjacency;
mod borders;
pub mod boxes;
pub mod edges;
mod ground;
mod inside;
mod inspect;
mod intersect;
pub mod mass;
pub mod measure;
mod near_pairs;
pub mod order;
mod piercings;
pub mod place;
mod predicate;
pub mod random;
pub mod rest;
pub mod segment;
pub mod select;
pub(crate) mod sets;
pub mod shapes;
pub mod struts;

pub use crate::real::LANES;
pub use crate::scene::{Polygons, Surface, Uvs};
pub use adjacency::{Csr, Gather};
pub use borders::Borders;
pub use edges::{Edges, NONE};
pub use ground::ground;
pub use inside::{NoInside, named_edges, no_inside};
pub use inspect::{Inspection, Part};
pub use intersect::{Intersections, self_intersections};
pub use piercings::{Piercing, Piercings, piercings};
pub(crate) use piercings::{list_piercings, piercings_apart};
pub use place::Placement;
pub(crate) use predicate::side_of_triangle;
pub use predicate::{meet_beyond_corner, overlap_beyond_edge, triangles_meet};
pub use rest::RestShape;
pub use select::Selectable;
