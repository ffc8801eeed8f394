//! Contact of nodes with colliders: where the surface is, and what it does to a node.

pub mod contact;
pub mod shape;
