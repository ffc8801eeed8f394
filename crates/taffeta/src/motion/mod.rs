//! Motion that is given: keyframes, and the nodes that follow them.

pub mod cpu;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod keyframes;
pub mod pins;
