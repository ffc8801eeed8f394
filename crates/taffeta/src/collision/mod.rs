//! Contact of nodes with colliders, and with each other: where the surface is, and what it does to a node.

pub mod cells;
pub mod contact;
pub mod pair;
pub mod press;
pub mod shape;
