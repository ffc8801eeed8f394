//! Elements: what acts between a few neighbouring nodes, or on a node alone.

pub mod aero;
pub mod hinge;
pub mod load;
#[cfg(feature = "gpu")]
pub mod parity;
pub mod spring;
