//! Contact: of nodes with colliders, with meshes among them, and with each other.

pub mod collider_mesh;
pub mod colliders;
pub mod nodes;
