//! Constraints: what must hold whatever the forces are. They correct forces, or positions.

pub mod attach;
pub mod distance;
pub mod joints;
pub mod primal;
pub mod volume;
