//! Contact of nodes with colliders, and with each other: where the surface is, and what it does to a node.

pub mod cells;
pub mod contact;
mod hull;
pub mod mesh;
pub mod moving;
pub mod pair;
mod poses;
pub mod press;
pub mod shape;
pub mod tree;
pub mod triangle;
